"""Moves in time: each step with its tolerance and its settling times, and the error along the path."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._piezoid import PiezoidError
from ..timing import Timing
from ._panels import Panels, label, legend, panels, several, span, unit, width, zero
from ._style import COLOURS, EQUALS

MOST = 3
"""Largest number of steps in a figure."""

SHOWN, BEFORE, FEWEST = 1.6, 0.15, 20
"""What is shown of a step: so many of its longest settling or move, a share of this before it, at least so many samples."""

HEIGHT = 8.0
"""Largest error that is shown [tolerances]."""


def moves(timing: Timing, *, ax: Any = None) -> Panels:
    """Displacement over time of every run around the first three steps of a path, and the error along the path.

    The band is the tolerance, about the goal of a step and about no error; a marker stands where a run has settled. Runs
    of a straight line are dashed. Errors above eight tolerances are cut off. A path without steps is drawn whole.

    ax: an Axes for each of these steps, and one for the error

    Returns an array of the Axes.
    """
    if not isinstance(timing, Timing):
        raise PiezoidError(f"a {type(timing).__name__} is no timing: give the result of pz.timing")
    steps = timing.figures["runs"][0]["steps"][:MOST]
    places = list(range(max(1, len(steps))))
    axes = panels(ax, [places, [len(places)] * len(places)], 0.9, ratios=[1.0, 0.8], shared=(False, False))
    y, t = unit(timing.figures["unit"]), 1e3 * timing.ts * np.arange(len(timing.path))
    for k, a in enumerate(axes[:-1]):
        a.plot(t, timing.path, color=COLOURS["reference"], linewidth=width(0.8), linestyle=":", label="path")
        for n, (name, found) in enumerate(timing.displacements.items()):
            a.plot(t, found, label=name, **_look(n, name))
        if steps:
            _step(a, timing, k)
        label(a, "time [ms]", f"displacement [{y}]" if k == 0 else "")
    error = axes[-1]
    zero(error)
    _band(error, 0.0, timing.tolerance)
    most = 0.0
    for n, (name, found) in enumerate(timing.displacements.items()):
        error.plot(t, found - timing.path, label=name, **_look(n, name))
        most = max(most, float(np.abs(found - timing.path).max(initial=0.0)))
    high = min(1.1 * max(most, timing.tolerance), HEIGHT * timing.tolerance)
    error.set_ylim(-high, high)
    span([error], t[0], t[-1])
    label(error, "time [ms]", f"error [{y}]")
    if ax is None:
        figure = axes[0].get_figure(root=True)
        assert figure is not None
        legend(axes[0], figure)
    else:
        legend(axes[0])
    return several(axes)


def _look(n: int, name: str) -> dict[str, Any]:
    """Each player has a colour; its straight line is dashed."""
    is_straight = name.endswith("straight line")
    return {"color": EQUALS[(n // 2) % len(EQUALS)], "linestyle": "--" if is_straight else "-", "linewidth": width()}


def _band(ax: Axes, at: float, tolerance: float) -> None:
    ax.axhspan(at - tolerance, at + tolerance, color=COLOURS["muted"], linewidth=0, alpha=0.6, zorder=0)


def _step(ax: Axes, timing: Timing, k: int) -> None:
    """Limits a panel to one step, and marks when each run has settled."""
    runs = timing.figures["runs"]
    steps = runs[0]["steps"]
    step = steps[k]
    settled = [run["steps"][k]["settling_s"] for run in runs]
    until = steps[k + 1]["at_s"] if k + 1 < len(steps) else timing.ts * (len(timing.path) - 1)
    time = SHOWN * max(step["move_s"], FEWEST * timing.ts, *(s for s in settled if s is not None))
    _band(ax, step["to"], timing.tolerance)
    for n, (run, found) in enumerate(zip(runs, settled, strict=True)):
        if found is not None:
            at = step["at_s"] + found
            look = {"color": _look(n, run["name"])["color"], "markerfacecolor": "none", "linestyle": "none"}
            ax.plot([1e3 * at], [timing.displacements[run["name"]][round(at / timing.ts)]], marker="o", zorder=4, **look)
    span([ax], 1e3 * (step["at_s"] - BEFORE * time), 1e3 * min(step["at_s"] + time, until))
    height = step["to"] - step["from"]
    ax.set_ylim(*sorted((step["from"] - 0.15 * height, step["to"] + 0.25 * height)))
