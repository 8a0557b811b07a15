"""Panels, their labels and legends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.ticker import FuncFormatter, NullFormatter
from matplotlib.textpath import TextPath

from .._piezoid import PiezoidError
from ._style import COLOURS

Panels: TypeAlias = "npt.NDArray[np.object_]"
"""Several Axes."""

GAP = 3.5
"""Width of a legend entry beside its letters: the line and the gaps [font size]."""

SINGLE = 3.4
"""Up to this width [in] a figure keeps its proportions; the height of a wider one grows more slowly."""


def panels(
    ax: object,
    rows: Sequence[Sequence[int]],
    height: float,
    *,
    ratios: Sequence[float] | None = None,
    shared: tuple[bool, bool] = (True, False),
) -> list[Axes]:
    """The given Axes, or those of a new figure.

    rows: the number of the panel at each place, counted from 0; -1 for an empty place
    height: relative to the width, for a single column; ratios: heights of the rows; shared: x and y axes
    """
    n = 1 + max(max(row) for row in rows)
    if ax is not None:
        source = list(np.ravel(np.asarray(ax, dtype=object)))
        if len(source) != n or not all(isinstance(a, Axes) for a in source):
            what = f"{len(source)} of {type(source[0]).__name__}" if source else "nothing"
            raise PiezoidError(f"ax holds {what}: this figure takes {n} Axes, as plt.subplots({n}) makes them")
        return source
    width = mpl.rcParams["figure.figsize"][0]
    tall = height * (width if width <= SINGLE else SINGLE + 0.4 * (width - SINGLE))
    figure = plt.figure(figsize=(width, tall), layout="constrained")
    result = figure.subplot_mosaic(
        [list(row) for row in rows], height_ratios=ratios, sharex=shared[0], sharey=shared[1], empty_sentinel=-1
    )
    for a in result.values():
        _hold(a)
    return [result[k] for k in range(n)]


def _hold(ax: Axes) -> None:
    # Matplotlib creates ticks when it draws, with the settings of that moment. This fixes the present settings.
    now: Any = mpl.rcParams
    for name, axis in (("xtick", ax.xaxis), ("ytick", ax.yaxis)):
        both = {key: now[f"{name}.{key}"] for key in ("direction", "labelsize")}
        for which in ("major", "minor"):
            own = {key: now[f"{name}.{which}.{key}"] for key in ("size", "width", "pad")}
            axis.set_tick_params(which=which, labelfontfamily=now["font.family"], **own, **both)


def several(axes: Iterable[Axes]) -> Panels:
    """Axes as an array, as in matplotlib."""
    return np.array(list(axes), dtype=object)


def label(ax: Axes, x: str, y: str) -> None:
    """Labels both axes."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)


def unit(name: str) -> str:
    """A unit in its printed form."""
    return "µ" + name[1:] if name.startswith("u") and len(name) > 1 else name


def width(share: float = 1.0) -> float:
    """Width of a line, as a share of the default."""
    return share * float(mpl.rcParams["lines.linewidth"])


def stacked(axes: Sequence[Axes]) -> None:
    """Panels over one x axis: only the lowest of a column labels it, and the y labels are aligned."""
    columns = {ax: spec.colspan for ax in axes if (spec := ax.get_subplotspec()) is not None}
    for k, ax in enumerate(axes):
        x = ax.get_xlabel()
        ax.label_outer()
        # A panel above an empty place is also the lowest of its column.
        if ax in columns and not any(columns.get(below) == columns[ax] for below in axes[k + 1 :]):
            ax.xaxis.set_tick_params(labelbottom=True)
            ax.set_xlabel(x)
    figure = axes[0].get_figure(root=True)
    assert figure is not None
    figure.align_ylabels(axes)


def span(axes: Iterable[Axes], start: float, end: float) -> None:
    """Limits the time axes to these ends."""
    for ax in axes:
        ax.set_xlim(start, end)


def plain(axis: Axis) -> None:
    """Plain numbers along a logarithmic axis: 1, 10, 100; also 2 and 5 if these are few."""
    low, high = axis.get_view_interval()
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    between = FuncFormatter(lambda x, _: f"{x:g}" if f"{x:e}"[0] in "25" else "")
    axis.set_minor_formatter(between if high < 100 * low else NullFormatter())


def zero(ax: Axes) -> None:
    """A thin line at 0."""
    ax.axhline(0.0, color=COLOURS["muted"], linewidth=width(0.7), zorder=0)


def legend(ax: Axes, over: Figure | None = None) -> None:
    """Names the lines above their panel, outside the data, or above the figure `over`, in as many columns as fit."""
    handles, names = ax.get_legend_handles_labels()
    if len(names) < 2:
        return
    font = FontProperties(size=mpl.rcParams["legend.fontsize"])
    size, figure = font.get_size_in_points(), ax.get_figure(root=True)
    room = 72.0 * (figure.get_figwidth() if figure else SINGLE) * (1.0 if over else ax.get_position().width + 0.05)
    widths = [TextPath((0, 0), name, prop=font).get_extents().width + GAP * size for name in names]
    rows = next(r for r in range(1, 1 + len(names)) if r == len(names) or _columns(widths, r) < room)
    above = {"loc": "outside upper left"} if over else {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}
    result = (over or ax).legend(
        handles, names, **above, ncols=-(-len(names) // rows), prop=font, frameon=False, borderaxespad=0.1,
        borderpad=0.2, handlelength=1.6, handletextpad=0.5, columnspacing=1.4,
    )  # fmt: skip
    for line in result.get_lines():
        line.set_linewidth(max(line.get_linewidth(), width(1.4)))


def _columns(widths: Sequence[float], rows: int) -> float:
    """Width of names that are arranged in columns, `rows` to a column."""
    return sum(max(widths[k : k + rows]) for k in range(0, len(widths), rows))


def named(source: Any, kinds: tuple[type, ...]) -> dict[str, Any] | None:
    """Several by name, where a number is a frequency [Hz]; None if a single one is given."""
    if isinstance(source, kinds):
        return None
    expected = " or ".join(f"a {kind.__name__}" for kind in kinds)
    if isinstance(source, Mapping) and source and all(isinstance(one, kinds) for one in source.values()):
        return {name if isinstance(name, str) else f"{name:g} Hz": one for name, one in source.items()}
    raise PiezoidError(f"a {type(source).__name__} cannot be drawn here: give {expected}, or a mapping from names to such")
