"""Recursive identification: a model that follows its actuator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._keywords import known, takes
from ._options import OnlineOptions
from ._progress import watched
from ._types import Progress
from .model import Model
from .records import as_record
from .results import frame

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

    from .records import Source

__all__ = ["Online"]


class Online:
    """A model whose gain, offset, weights and linear block move with the samples; it keeps its state between calls.

    >>> import numpy as np, piezoid as pz
    >>> model = pz.Model.from_dict({
    ...     "piezoid": 1, "ts": 1e-3, "units": {"u": "V", "y": "um"},
    ...     "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [2.0]},
    ...     "identified": {"u": [-10, 10], "hz": [0, 100], "slew": 2000, "mean": [0, 0]}})
    >>> u = 10 * np.sin(0.2 * np.arange(2000))
    >>> follower = pz.Online(model, every=0.5)
    >>> rows = follower.follow(pz.Record(u, 2.2 * u, ts=1e-3))
    >>> rows["gain"].round(3).tolist()
    [1.1, 1.1, 1.1, 1.1]
    >>> round(follower.model.dc_gain, 2)
    2.2
    """

    __slots__ = ("_core",)

    @takes(OnlineOptions)
    def __init__(self, model: Model, **options: Unpack[OnlineOptions]) -> None:
        """Starts at `model`, which states the range of its inputs and has no hysteresis in feedback.

        {options}
        """
        self._core = _piezoid.Online(model._core, known(Online.__init__, options))

    def step(self, u: float, y: float) -> dict[str, Any] | None:
        """One sample, input [input unit] and reading [output unit]; a `y` of nan is a missing reading.

        Returns the parameters by name whenever they are due (`every`), otherwise None.
        """
        return self._core.step(u, y)

    def follow(self, record: Source, *, progress: Progress = None) -> pd.DataFrame:
        """Follows a record from here on. Returns the parameters over time, one row each time they were due.

        record: anything that `read` accepts, with the sampling period of the model
        """
        measured = as_record(record)
        with watched(progress) as watch:
            return frame(self._core.follow(measured._core, watch))

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters now: gain relative to the start, offset, factors of the weights, coefficients, first mode."""
        return self._core.row()

    @property
    def model(self) -> Model:
        """The model with the parameters as they are. Validate it: it has no verdict."""
        return Model._of(self._core.model())

    @property
    def remarks(self) -> list[str]:
        """What does not move, and why."""
        return self._core.remarks()

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return self._core.samples()
