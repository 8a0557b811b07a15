"""How things look in a notebook: a small table of what they are."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .model import Model, Validation
    from .records import Record


def _table(title: str, rows: list[tuple[str, str]], notes: list[str] | None = None) -> str:
    cells = "".join(f"<tr><th style='text-align:left'>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in rows)
    told = "".join(f"<li>{escape(note)}</li>" for note in notes or [])
    return f"<table><caption>{escape(title)}</caption>{cells}</table>" + (f"<ul>{told}</ul>" if told else "")


def record(r: Record) -> str:
    (u, y), (low, high), (bottom, top) = r.units, (r.u.min(), r.u.max()), (r.y.min(), r.y.max())
    return _table(
        "Record",
        [
            ("samples", f"{len(r)}, {r.duration:g} s, one every {r.ts:g} s"),
            ("input", f"{low:.4g} to {high:.4g} {u}"),
            ("output", f"{bottom:.4g} to {top:.4g} {y}"),
        ],
    )


def model(m: Model) -> str:
    (u, y), rows = m.units, [("hysteresis", m.operator)]
    document = m.to_dict()
    if document.get("driver"):
        rows.append(("driver", f"lag {document['driver']['lag_s']:g} s"))
    rows.append(("creep", f"{len(document.get('creep') or [])} lags"))
    mode = f", resonance {m.resonance[0]:.4g} Hz, damping {m.resonance[1]:.3g}" if m.resonance else ""
    rows.append(("linear block", f"order {len(m.a)}, gain {m.dc_gain:.4g} {y}/{u}{mode}"))
    rows.append(("sampled", f"every {m.ts:g} s"))
    if m.input_range:
        rows.append(("knows inputs", f"{m.input_range[0]:.4g} to {m.input_range[1]:.4g} {u}"))
    return _table("Model", rows, m.notes)


def validation(v: Validation) -> str:
    unit = v.record.units[1]
    rows = [
        ("nrmse", f"{v.nrmse_percent:.4g} %"),
        ("rms / peak-to-peak", f"{v.rms_pp_percent:.4g} %"),
        ("rms", f"{v.rmse:.4g} {unit}"),
        ("largest", f"{v.max_abs:.4g} {unit}"),
        ("samples", f"{v.n}"),
    ]
    return _table("Free run against the record", rows, v.remarks)
