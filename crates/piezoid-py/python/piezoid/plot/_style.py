"""The style of a paper: sizes, fonts and colours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib as mpl
from cycler import cycler
from matplotlib.font_manager import fontManager

from .._piezoid import PiezoidError

COLOURS = {
    "ascending": "#00568a",
    "descending": "#e07b2e",
    "measured": "#aab0b7",
    "model": "#00593f",
    "reference": "#1d2126",
    "residual": "#9c4a8c",
    "muted": "#d5d9dd",
}
"""Kinds of lines and their colours: the hues of the library's reports, which also differ in brightness."""

EQUALS = ("#0b3c6f", "#d5752a", "#83386f", "#d4a833", "#1f8465")
"""Colours of lines of the same kind: all differ in brightness, adjacent ones strongly."""

WIDTHS = {"single": 3.4, "double": 7.0}
"""Widths of figures in one or two columns of a journal [in]."""

FONTS = ("Helvetica", "Arial", "Liberation Sans", "DejaVu Sans")


@contextmanager
def style(width: Literal["single", "double"] | float = "single") -> Iterator[None]:
    """Figures created within this context fit a paper: one or two of its columns, or another width [in]."""
    inches = WIDTHS.get(width) if isinstance(width, str) else width
    if inches is None or not inches > 0:
        raise PiezoidError(f"width = {width}: must be single, double, or a number of inches above 0")
    # One installed font by its own name: texts keep it when the style has ended.
    known = {font.name for font in fontManager.ttflist}
    font = next((name for name in FONTS if name in known), FONTS[-1])
    look: dict[Any, Any] = {
        "figure.figsize": (inches, 0.75 * inches),
        "figure.dpi": 144,
        "savefig.dpi": 600,
        "figure.constrained_layout.use": True,
        "figure.constrained_layout.w_pad": 0.02,
        "figure.constrained_layout.h_pad": 0.02,
        "pdf.fonttype": 42,
        "font.family": [font],
        "font.size": 8,
        "axes.labelsize": 8,
        "axes.titlesize": 8,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "legend.fontsize": 7,
        "lines.linewidth": 0.9,
        "lines.markersize": 3.5,
        "axes.linewidth": 0.6,
        "axes.labelpad": 3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": False,
        "axes.axisbelow": True,
        "axes.prop_cycle": cycler(color=EQUALS),
        **{f"{axis}tick.{which}.width": 0.6 for axis in "xy" for which in ("major", "minor")},
        **{f"{axis}tick.major.size": 2.5 for axis in "xy"},
        **{f"{axis}tick.minor.size": 1.5 for axis in "xy"},
        **{f"{axis}tick.major.pad": 2.5 for axis in "xy"},
    }
    # Only these settings are restored: the first figure in a notebook also sets how the notebook displays figures.
    before = {name: mpl.rcParams[name] for name in look}
    mpl.rcParams.update(look)
    try:
        yield
    finally:
        mpl.rcParams.update(before)
