"""Objects in a notebook: a small table of properties, with lines in the colour of the text, light or dark."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ._types import Array

if TYPE_CHECKING:
    from .model import Model, Validation
    from .records import Record

Rows: TypeAlias = list[tuple[str, str, str]]
"""Name, text, and drawing of each row; the drawing may be empty."""

WIDTH, HEIGHT = 180, 36
"""Size of a drawing [pixels]."""

LEFT = "style='text-align:left'"


def record(r: Record) -> str:
    (u, y), (low, high), (bottom, top) = r.units, (r.u.min(), r.u.max()), (r.y.min(), r.y.max())
    return _table(
        "Record",
        [
            ("samples", f"{len(r)}, {r.duration:g} s, one every {r.ts:g} s", ""),
            ("input", f"{low:.4g} to {high:.4g} {u}", _series(r.u)),
            ("output", f"{bottom:.4g} to {top:.4g} {y}", _series(r.y)),
        ],
    )


def model(m: Model) -> str:
    (u, y), rows = m.units, [("hysteresis", m.operator, _loop(m))]
    document = m.to_dict()
    if document.get("driver"):
        rows.append(("driver", f"lag {document['driver']['lag_s']:g} s", ""))
    lags = len(document.get("creep") or [])
    rows.append(("creep", f"{lags} lag{'s' if lags > 1 else ''}" if lags else "none", ""))
    mode = f", resonance {m.resonance[0]:.4g} Hz, damping {m.resonance[1]:.3g}" if m.resonance else ""
    rows.append(("linear block", f"order {len(m.a)}, gain {m.dc_gain:.4g} {y}/{u}{mode}", _gain(m)))
    rows.append(("sampled", f"every {m.ts:g} s", ""))
    if m.input_range:
        rows.append(("identified for inputs", f"{m.input_range[0]:.4g} to {m.input_range[1]:.4g} {u}", ""))
    return _table("Model", rows, m.notes)


def validation(v: Validation) -> str:
    unit = v.record.units[1]
    return _table(
        "Free run against the record",
        [
            ("nrmse", f"{v.nrmse_percent:.4g} %", ""),
            ("noise floor", f"{v.floor['nrmse_percent']:.2g} %" if v.floor else "unknown", ""),
            ("rms / peak-to-peak", f"{v.rms_pp_percent:.4g} %", ""),
            ("rms", f"{v.rmse:.4g} {unit}", ""),
            ("largest", f"{v.max_abs:.4g} {unit}", _series(v.residual[v.start :])),
            ("samples", f"{v.n}", ""),
        ],
        v.remarks + ([v.advice] if v.advice else []) + [f"unproven: {part}" for part in v.unproven],
    )


def _table(title: str, rows: Rows, notes: list[str] | None = None) -> str:
    cells = "".join(
        f"<tr><th {LEFT}>{escape(name)}</th><td {LEFT}>{escape(text)}</td><td {LEFT}>{drawn}</td></tr>"
        for name, text, drawn in rows
    )
    message = "".join(f"<li>{escape(note)}</li>" for note in notes or [])
    return f"<table><caption {LEFT}>{escape(title)}</caption>{cells}</table>" + (f"<ul>{message}</ul>" if message else "")


def _series(samples: Array) -> str:
    """Samples over time: each column of pixels reaches from its minimum to its maximum."""
    columns = np.array_split(samples, min(len(samples), WIDTH))
    there = np.arange(len(columns))
    high, low = (np.array([end(column) for column in columns]) for end in (np.max, np.min))
    return _line(np.append(there, there[::-1]), np.append(high, low[::-1]), fill="currentColor")


def _loop(m: Model) -> str:
    """The major loop."""
    low, high = m.input_range or (-1.0, 1.0)
    u = low + (high - low) * (0.5 - 0.5 * np.cos(np.linspace(0, 3 * np.pi, 3 * WIDTH)))
    return _line(u[WIDTH::4], m.hidden(u)[WIDTH::4], width=2 * HEIGHT, fill="currentColor")


def _gain(m: Model) -> str:
    """The gain over frequency up to half the sampling rate; both axes are logarithmic."""
    hz = np.geomspace(1e-3, 0.5, WIDTH) / m.ts
    gain = np.abs(m.response(hz))
    return _line(np.log(hz), np.log(np.maximum(gain, 1e-4 * gain.max() or 1.0)))


def _line(x: Array, y: Array, *, width: int = WIDTH, fill: str = "none") -> str:
    across, down = (
        1 + (length - 2) * (values - values.min()) / (np.ptp(values) or 1.0)
        for values, length in ((x, width), (-y, HEIGHT))
    )
    points = " ".join(f"{a:.4g},{d:.3g}" for a, d in zip(across, down, strict=True))
    return (
        f"<svg width='{width}' height='{HEIGHT}' style='vertical-align:middle'><polyline points='{points}' "
        f"fill='{fill}' fill-opacity='0.3' stroke='currentColor' stroke-opacity='0.8' stroke-width='0.8'/></svg>"
    )
