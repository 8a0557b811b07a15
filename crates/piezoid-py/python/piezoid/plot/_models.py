"""Figures of models without records: the hysteresis operator, the linear block."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from .._piezoid import PiezoidError
from .._types import Array
from ..model import Model
from ._panels import Panels, label, legend, panels, plain, several, stacked, unit, width
from ._style import COLOURS

HIDDEN, MAJOR, MINOR = 0.0, 1.2, 0.8
WAY = (
    *((1.0, HIDDEN), (0.0, HIDDEN), (1.0, MAJOR), (0.0, MAJOR)),
    *((0.92, HIDDEN), (0.1, MINOR), (0.76, MINOR), (0.26, MINOR), (0.6, MINOR), (0.42, MINOR), (0.92, MINOR)),
)
"""Reversal points, as shares of the range, and the width of the line to each. A first cycle, which is not drawn, wipes
out the past; each minor loop lies within the previous one."""

FEWEST, MOST = 60, 20_000
"""Minimum and maximum number of samples from one end of the range to the other."""


def blocks(model: Model, *, ax: Any = None) -> Panels:
    """The parts of a model: the loops of its hysteresis operator, gain and phase of its linear block.

    ax: three Axes

    Returns an array of the Axes.
    """
    _checked(model)
    axes = panels(ax, [[0, 1], [0, 2]], 0.75, ratios=[1.0, 0.7], shared=(False, False))
    branches(model, over=model.input_range or (-1.0, 1.0), ax=axes[0])
    response(model, ax=axes[1:])
    if ax is None:
        axes[1].set_xlabel("")
        axes[1].xaxis.set_tick_params(labelbottom=False)
        figure, verdict = axes[0].get_figure(root=True), model.verdict
        assert figure is not None
        figure.suptitle(f"{model.operator}, {verdict.short}" if verdict else model.operator, fontsize="small")
    return several(axes)


def branches(
    model: Model, *, over: tuple[float, float] | None = None, hz: float | None = None, ax: Any = None
) -> Axes:
    """The hysteresis operator alone, without creep and driver: its major loop, and minor loops within it.

    over: lowest and highest input [input unit]; default: the range of the identification data
    hz: frequency of the major loop [Hz], for rate-dependent operators; if not given, the lowest frequency of the
    identification data

    Returns the Axes.
    """
    _checked(model)
    low, high = over or model.input_range or (0.0, 0.0)
    if not low < high:
        remedy = "give the lowest and the highest input, because the model does not state its input range"
        raise PiezoidError(f"over = {over}: {remedy}")
    document = model.to_dict()
    known = (document.get("identified") or {}).get("hz") or [1.0]
    n = int(np.clip(0.5 / ((hz or known[0]) * model.ts), FEWEST, MOST))
    alone = Model.from_dict({key: part for key, part in document.items() if key not in ("creep", "driver")})
    starts = (0.5, *(end for end, _ in WAY))
    ways = [_way(start, end, n) for start, (end, _) in zip(starts, WAY, strict=False)]
    z = np.split(alone.hidden(low + (high - low) * np.concatenate(ways)), np.cumsum([len(way) for way in ways])[:-1])

    [a] = panels(ax, [[0]], 0.8)
    for k, (start, (end, wide)) in enumerate(zip(starts, WAY, strict=False)):
        if wide == HIDDEN:
            continue
        name = "ascending" if end > start else "descending"
        u_shown = low + (high - low) * np.append(ways[k - 1][-1], ways[k])
        z_shown = np.append(z[k - 1][-1], z[k])
        shown = name if wide == MAJOR else None
        a.plot(u_shown, z_shown, color=COLOURS[name], linewidth=width(wide), label=shown, zorder=2 + wide)
        if wide == MAJOR:
            _arrow(a, u_shown, z_shown, COLOURS[name])
    u_unit = unit(model.units[0])
    label(a, f"input u [{u_unit}]", f"hidden variable z [{u_unit}]")
    legend(a)
    return a


def response(model: Model, *, ax: Any = None) -> Panels:
    """The linear block over frequency: gain and phase up to half the sampling rate, with its resonance marked.

    ax: two Axes

    Returns an array of the Axes.
    """
    _checked(model)
    half, mode = 0.5 / model.ts, model.resonance
    low = min(1e-3 * half, 0.1 * mode[0]) if mode else 1e-3 * half
    hz = np.geomspace(low, half, 600)
    if mode:
        # The peak of a lightly damped mode is narrower than the frequency steps elsewhere.
        about = mode[0] * (1.0 + np.clip(abs(mode[1]), 1e-6, 0.3) * np.linspace(-5.0, 5.0, 201))
        hz = np.sort(np.append(hz, about[(about > low) & (about < half)]))
    values = model.response(hz)
    axes = panels(ax, [[0], [1]], 0.85, ratios=[1.0, 0.7])
    gain, phase = axes
    gain.loglog(hz, np.abs(values), color=COLOURS["model"])
    phase.semilogx(hz, np.degrees(np.unwrap(np.angle(values))), color=COLOURS["model"])
    u, y = map(unit, model.units)
    label(gain, "frequency [Hz]", f"gain [{y}/{u}]")
    label(phase, "frequency [Hz]", "phase [°]")
    phase.yaxis.set_major_locator(MultipleLocator(180 if np.ptp(phase.get_ylim()) > 450 else 90))
    for a in axes:
        a.set_xlim(low, half)
        plain(a.xaxis)
        if mode:
            a.axvline(mode[0], color=COLOURS["reference"], linewidth=width(0.7), linestyle=":", zorder=1)
    plain(gain.yaxis)
    if mode:
        gain.annotate(
            f"{mode[0]:.4g} Hz, damping {mode[1]:.2g}", (mode[0], 1.0), (0, 2), ha="center", fontsize="small",
            xycoords=("data", "axes fraction"), textcoords="offset points",
        )  # fmt: skip
    if ax is None:
        stacked(axes)
    return several(axes)


def _checked(model: object) -> None:
    if not isinstance(model, Model):
        raise PiezoidError(f"a {type(model).__name__} is no model: give the result of pz.identify or pz.load")


def _way(start: float, end: float, n: int) -> Array:
    """From one reversal to the next along half a sine, without the start; `n` samples cover the whole range."""
    samples = max(2, round(abs(end - start) * n))
    way: Array = start + (end - start) * 0.5 * (1.0 - np.cos(np.pi * np.arange(1, samples + 1) / samples))
    return way


def _arrow(ax: Axes, x: Array, y: Array, colour: str) -> None:
    """An arrow head in the middle of a line that shows its direction."""
    k = len(x) // 2
    head = {"arrowstyle": "-|>,head_width=0.28,head_length=0.65", "color": colour, "linewidth": 0}
    ax.annotate("", (x[k + 1], y[k + 1]), (x[k - 1], y[k - 1]), arrowprops=head | {"shrinkA": 0, "shrinkB": 0})
