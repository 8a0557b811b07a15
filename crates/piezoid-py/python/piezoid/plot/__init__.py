"""Figures with matplotlib, formatted for a journal: `pip install piezoid[plot]`.

>>> import numpy as np, piezoid as pz
>>> plant = pz.plants["pl140"]
>>> record = plant.measure(pz.excite.rising_sine(ts=5e-4, duration=1, amplitude=28, frequency=5), ts=5e-4)
>>> with pz.plot.style(width="single"):
...     ax = pz.plot.loops(record)
>>> ax.get_xlabel(), ax.get_ylabel()
('input u [V]', 'output y [µm]')
>>> ax.figure.savefig("loops.pdf")  # doctest: +SKIP

Every function draws into the given `ax`, or into a new figure with the width of `figure.figsize`, and returns what it
drew into. The colour of a line shows its kind (measured, model, ...); brightness, markers and the legend show it as
well. No figure is displayed, and no setting of matplotlib stays changed.
"""

from .._piezoid import PiezoidError

try:
    import matplotlib as _matplotlib
except ImportError:
    raise PiezoidError("figures need matplotlib: pip install piezoid[plot]") from None

from ._errors import frequencies, tracking
from ._models import blocks, branches, response
from ._records import loops, residuals, series
from ._search import search
from ._style import COLOURS, EQUALS, style
from ._timing import moves

__all__ = [
    "COLOURS",
    "EQUALS",
    "blocks",
    "branches",
    "frequencies",
    "loops",
    "moves",
    "residuals",
    "response",
    "search",
    "series",
    "style",
    "tracking",
]
