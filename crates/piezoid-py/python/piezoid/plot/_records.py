"""Figures of records and free runs: loops, time series, residuals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._piezoid import PiezoidError
from ..model import Validation
from ..records import Record
from ._panels import Panels, label, legend, named, panels, several, span, stacked, unit, width, zero
from ._style import COLOURS, EQUALS

POINTS = 5000
"""More points than this are drawn as an image, also in a PDF."""

LAGS = 20
"""Largest lag of an autocorrelation that is drawn [samples]."""


def loops(
    data: Record | Validation | Mapping[Any, Record] | Mapping[Any, Validation], *, ax: Any = None
) -> Axes | Panels:
    """Output over input: measured, and the free run of the model.

    data: one, or several by name, where a number is a frequency [Hz]; records share a panel, validations have one each
    ax: Axes to draw into; one per validation

    Returns the Axes, or an array of one per validation.
    """
    many = named(data, (Record, Validation))
    if many is None:
        many = {"": data}
    runs = {name: one for name, one in many.items() if isinstance(one, Validation)}
    if not runs:
        [a] = panels(ax, [[0]], 0.8)
        for k, (name, record) in enumerate(many.items()):
            colour = COLOURS["reference"] if len(many) == 1 else EQUALS[k % len(EQUALS)]
            # The record with the longest path lies at the bottom, because it covers the most.
            order = 2.0 + 1.0 / (1.0 + float(np.abs(np.diff(record.u)).sum()))
            thin = width(0.8 if len(many) == 1 else 0.5)
            a.plot(record.u, record.y, color=colour, linewidth=thin, zorder=order, label=name or "measured")
        _over_input(a, next(iter(many.values())), "y")
        legend(a)
        return a
    if len(runs) < len(many):
        raise PiezoidError("records and validations cannot share a figure: give one kind")
    columns = min(len(runs), 2 if len(runs) in (2, 4) else 3)
    grid = np.full(-(-len(runs) // columns) * columns, -1)
    grid[: len(runs)] = np.arange(len(runs))
    rows = grid.reshape(-1, columns)
    axes = panels(ax, rows.tolist(), 0.8 if columns == 1 else 0.25 + 0.8 * len(rows) / columns, shared=(True, True))
    for a, (name, run) in zip(axes, runs.items(), strict=True):
        record, part = run.record, slice(run.start, None)
        a.plot(record.u[part], record.y[part], color=COLOURS["measured"], linewidth=width(1.8), label="measured")
        a.plot(record.u[part], run.simulated[part], color=COLOURS["model"], linewidth=width(0.6), label="free run")
        a.text(0.04, 0.97, name, transform=a.transAxes, va="top")
        _over_input(a, record, "y")
    if ax is None:
        stacked(axes)
    legend(axes[0], axes[0].get_figure(root=True) if ax is None and len(axes) > 1 else None)
    return axes[0] if data is runs.get("") else several(axes)


def series(data: Record | Validation, *, ax: Any = None) -> Panels:
    """Input and output over time; for a validation also the free run, and below, on a separate scale, the residual.

    ax: two Axes for a record, three for a validation

    Returns an array of the Axes.
    """
    if not isinstance(data, (Record, Validation)):
        raise PiezoidError(f"a {type(data).__name__} has no series: give a Record or a Validation")
    record, start = (data.record, data.start) if isinstance(data, Validation) else (data, 0)
    t, part = record.t[start:], slice(start, None)
    ratios = [0.6, 1.0, 0.6] if isinstance(data, Validation) else [0.6, 1.0]
    axes = panels(ax, [[k] for k in range(len(ratios))], 0.5 * sum(ratios), ratios=ratios)
    axes[0].plot(t, record.u[part], color=COLOURS["reference"], linewidth=width(0.8))
    label(axes[0], "time [s]", f"input u [{unit(record.units[0])}]")
    if isinstance(data, Validation):
        axes[1].plot(t, record.y[part], color=COLOURS["measured"], linewidth=width(1.8), label="measured")
        axes[1].plot(t, data.simulated[part], color=COLOURS["model"], linewidth=width(0.6), label="free run")
        residual(axes[2], data)
    else:
        axes[1].plot(t, record.y, color=COLOURS["reference"], linewidth=width(0.8))
    label(axes[1], "time [s]", f"output y [{unit(record.units[1])}]")
    legend(axes[1])
    span(axes, t[0], record.duration)
    if ax is None:
        stacked(axes)
    return several(axes)


def residuals(validation: Validation, *, ax: Any = None) -> Panels:
    """Residual of the free run: over time, its autocorrelation, and over the input.

    White noise stays within the shaded bound at all lags in 99 of 100 records; 20 of them are drawn. If there are too few residuals for an
    autocorrelation, their histogram is drawn instead.

    ax: three Axes

    Returns an array of the Axes.
    """
    if not isinstance(validation, Validation):
        raise PiezoidError(f"a {type(validation).__name__} has no residuals: give the result of Model.validate")
    record, part = validation.record, slice(validation.start, None)
    axes = panels(ax, [[0, 0], [1, 2]], 0.85, ratios=[0.8, 1.0], shared=(False, False))
    over_time, noise, over_input = axes
    left = validation.residual[part]
    residual(over_time, validation)
    span([over_time], record.t[validation.start], record.duration)
    white = validation.figures["whiteness"]
    if white is None:
        noise.hist(left, bins="auto", color=COLOURS["residual"])
        label(noise, f"residual [{unit(record.units[1])}]", "samples [-]")
    else:
        bound, own = white["autocorrelation_bound"], white["autocorrelation"][:LAGS]
        lags = np.arange(1, 1 + len(own))
        noise.axhspan(-bound, bound, color=COLOURS["muted"], linewidth=0, zorder=0)
        noise.vlines(lags, 0.0, own, color=COLOURS["residual"], linewidth=width())
        noise.set_xlim(0, len(lags) + 1)
        label(noise, "lag [samples]", "autocorrelation [-]")
    over_input.plot(
        record.u[part], left, ".", color=COLOURS["residual"], markersize=2.0, alpha=0.6, markeredgewidth=0,
        rasterized=len(left) > POINTS,
    )  # fmt: skip
    zero(over_input)
    _over_input(over_input, record, "residual")
    return several(axes)


def residual(ax: Axes, validation: Validation) -> None:
    """The residual over time."""
    part = slice(validation.start, None)
    zero(ax)
    ax.plot(validation.record.t[part], validation.residual[part], color=COLOURS["residual"], linewidth=width(0.7))
    label(ax, "time [s]", f"residual [{unit(validation.record.units[1])}]")


def _over_input(ax: Axes, record: Record, what: str) -> None:
    u, y = map(unit, record.units)
    label(ax, f"input u [{u}]", f"output y [{y}]" if what == "y" else f"{what} [{y}]")
