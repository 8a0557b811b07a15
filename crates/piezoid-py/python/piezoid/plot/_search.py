"""A search while it runs: loops, errors over time, and the ranking of the operators."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..model import Model
from ..records import Record
from ._panels import Panels, panels, plain, several
from ._records import loops, residual
from ._style import COLOURS


class Search:
    """The figure of a search, redrawn whenever it finds something."""

    def __init__(self, record: Record, ax: Any) -> None:
        self.record = record
        self.model: Model | None = None
        """The best model so far."""
        self.errors: dict[str, float] = {}
        """Error of each operator so far [% of stroke]: the larger of the held-out and the free-run error."""
        self.axes: Panels = several(panels(ax, [[0, 1], [2, 2]], 1.1, shared=(False, False)))

    def __call__(self, what: str, done: int, total: int) -> None:
        """The library calls this with each step, which the figure does not show."""

    def found(self, what: str, figures: dict[str, float], model: Model | None, best: bool) -> None:
        """Redraws. The library calls this with the operator, its errors, its model or None, and if that is the best."""
        error = figures.get("error_percent", figures.get("held_out_percent"))
        if error is not None and np.isfinite(error):
            self.errors[what] = error
        if best:
            self.model = model
        self._draw()
        canvas = self.axes[0].figure.canvas
        canvas.draw_idle()
        canvas.flush_events()

    def _draw(self) -> None:
        loop, ranking, error = self.axes
        for axes in self.axes:
            axes.clear()
        if self.model is None:
            loops(self.record, ax=loop)
        else:
            run = self.model.validate(self.record, offset="free")
            loops(run, ax=loop)
            residual(error, run)
        names = sorted(self.errors, key=lambda name: -self.errors[name])
        ranking.barh(names, [self.errors[name] for name in names], color=COLOURS["muted"])
        if names:
            ranking.set_xscale("log")
            plain(ranking.xaxis)
        ranking.set_xlabel("error [% of stroke]")


def search(record: Record, *, ax: Any = None) -> Search:
    """The figure of a search, for `pz.identify(..., progress=pz.plot.search(record))`.

    record: what is drawn of the records: its loop with that of the best model so far, and the error of the model over
    time; beside them are the errors of the operators
    ax: three Axes: the loop, the ranking, the error

    Returns what `pz.identify` takes as `progress`. Its `model` is the best so far, `errors` are those of the operators
    [% of stroke], and `axes` the Axes. In a notebook use a backend that redraws (`%matplotlib widget`).

    >>> import piezoid as pz
    >>> record = pz.plants["pl140"].measure(pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4), ts=1e-3)
    >>> figure = pz.plot.search(record)
    >>> model = pz.identify(record, operator="pi,preisach", order=2, progress=figure)
    >>> sorted(figure.errors)
    ['prandtl-ishlinskii', 'preisach']
    """
    return Search(record, ax)
