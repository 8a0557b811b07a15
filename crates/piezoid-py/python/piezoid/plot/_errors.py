"""Errors by frequency and amplitude, and tracking errors of controllers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal, TypeAlias

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from .._piezoid import PiezoidError
from ..control import Comparison
from ..model import Validation
from ._panels import Panels, label, legend, panels, plain, several, span, stacked, unit, width, zero
from ._style import COLOURS, EQUALS

MARKERS = "osD^vP"
"""One more than the colours, so that thirty series all look different."""

Several: TypeAlias = Validation | Iterable[Validation]


def frequencies(
    validations: Several | Mapping[Any, Several],
    *,
    by: Literal["frequency", "amplitude"] = "frequency",
    measure: Literal["nrmse_percent", "rms_pp_percent", "rmse"] = "nrmse_percent",
    ax: Any = None,
) -> Axes:
    """Errors by frequency, or by amplitude of the input, as in the tables of a validation.

    validations: one or several validations of one model; for several models, a mapping of these by name
    measure: rms error divided by the standard deviation of the output, or by its peak-to-peak, or undivided [output
    unit]

    The axis of errors is logarithmic if they differ by more than a factor of ten. A bar shows the width of the band of
    a point. Hollow points come from the spectrum, for inputs without cycles. Dotted lines are the noise in the errors, of
    the same bandwidth. Bands in which little is excited (`little_excited` of the table) are not drawn: their error is
    that of noise or of other frequencies.

    Returns the Axes.
    """
    if by not in ("frequency", "amplitude"):
        raise PiezoidError(f"by = {by}: must be frequency or amplitude")
    many = validations if isinstance(validations, Mapping) else {"": validations}
    runs = {
        str(name): list(one) if isinstance(one, Iterable) and not isinstance(one, Validation) else [one]
        for name, one in many.items()
    }
    every = [run for some in runs.values() for run in some]
    if not every or not all(isinstance(run, Validation) for run in every):
        raise PiezoidError("only validations can be drawn here: give one, several, or a mapping from names to them")
    u, y = map(unit, every[0].record.units)
    measures = {
        "nrmse_percent": "rms error / std of y [%]",
        "rms_pp_percent": "rms error / peak-to-peak [%]",
        "rmse": f"rms error [{y}]",
    }
    if measure not in measures:
        raise PiezoidError(f"measure = {measure}: must be one of {', '.join(measures)}")
    tables = {
        name: pd.concat([run.table if by == "frequency" else run.by_amplitude for run in some], ignore_index=True)
        for name, some in runs.items()
    }
    if all(rows.empty for rows in tables.values()):
        remedy = '; try by="frequency"' if by == "amplitude" else ""
        raise PiezoidError(f"these records have no errors by {by}: their inputs have no cycles{remedy}")
    tables = {name: rows if rows.empty else rows[~rows["little_excited"]] for name, rows in tables.items()}
    noise = "noise" if measure == "rmse" else f"noise_{measure}"

    [a] = panels(ax, [[0]], 0.65)
    values: list[float] = []
    for k, (name, rows) in enumerate(tables.items()):
        if rows.empty:
            continue
        colour, marker = EQUALS[k % len(EQUALS)], MARKERS[k % len(MARKERS)]
        a.hlines(rows[measure], rows["low"], rows["high"], color=colour, linewidth=width(1.2))
        sources = set(rows["source"])
        for source, face in (("cycles", colour), ("spectrum", "white")):
            if source not in sources:
                continue
            shown = name if len(sources) == 1 else f"{name}, {source}".removeprefix(", ")
            part = rows[rows["source"] == source].sort_values("at")
            # If a band occurs twice, adjacent points do not belong together.
            joined = "-" if part["low"].is_unique else "none"
            a.plot(
                part["at"], part[measure], linestyle=joined, linewidth=width(0.6), marker=marker, color=colour,
                markerfacecolor=face, label=shown,
            )  # fmt: skip
            floor = part[[*("at", "low"), noise]].dropna()
            if len(floor) > 1 and floor["low"].is_unique:
                a.plot(floor["at"], floor[noise].astype(float), linestyle=":", linewidth=width(0.8), color=colour)
        values += [value for value in rows[measure] if value > 0]
    a.set_xscale("log")
    if max(values, default=0.0) > 10 * min(values, default=0.0):
        a.set_yscale("log")
        plain(a.yaxis)
    else:
        a.set_ylim(0.0, 1.12 * max(values, default=1.0))
    label(a, "frequency [Hz]" if by == "frequency" else f"amplitude of the input [{u}]", measures[measure])
    plain(a.xaxis)
    legend(a)
    return a


def tracking(
    comparison: Comparison,
    *,
    reference: str | None = None,
    controllers: Iterable[str] | None = None,
    ax: Any = None,
) -> Panels:
    """The reference and the displacement with each controller, and below, on a separate scale, the error.

    reference: name of one reference, by default the first; controllers: their names, by default all
    ax: two Axes

    Returns an array of the Axes.
    """
    if not isinstance(comparison, Comparison):
        raise PiezoidError(f"a {type(comparison).__name__} is no Comparison: give the result of pz.control")
    along = comparison.run(reference=reference)["reference"]
    names = [run["controller"] for run in comparison.runs] if controllers is None else controllers
    runs = [comparison.run(name, along) for name in dict.fromkeys(names)]
    failed = [f"{run['controller']}: {run['error']}" for run in runs if "error" in run]
    runs = [run for run in runs if "error" not in run]
    if not runs:
        raise PiezoidError(f"no controller ran along {along}: {'; '.join(failed) or 'none was named'}")
    path, left = axes = panels(ax, [[0], [1]], 0.95, ratios=[1.0, 0.9])
    r = runs[0]["r"]
    t = comparison.ts * np.arange(len(r))
    zero(left)
    path.plot(t, r, color=COLOURS["reference"], linewidth=width(0.8), linestyle="--", label="reference", zorder=3)
    for k, run in enumerate(runs):
        colour = EQUALS[k % len(EQUALS)]
        path.plot(t, run["y"], color=colour, linewidth=width(), label=run["controller"])
        left.plot(t, run["r"] - run["y"], color=colour, linewidth=width(0.8), label=run["controller"])
    y = unit(str(comparison.figures["unit"]))
    label(path, "time [s]", f"output y [{y}]")
    label(left, "time [s]", f"error r − y [{y}]")
    legend(path)
    span(axes, 0.0, comparison.ts * len(t))
    if ax is None:
        stacked(axes)
    return several(axes)
