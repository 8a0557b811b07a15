"""Moves in time: settling, overshoot, scan lag, and the fastest moves."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._keywords import known, takes
from ._options import TimingOptions
from ._progress import watched
from ._types import Array, Progress, Samples
from .model import Model, as_model
from .plants import Plant, plants
from .results import frame

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

__all__ = ["Timing", "timing"]


@dataclass(frozen=True, eq=False)
class Timing:
    """The timing of moves along a path, and the fastest moves."""

    figures: dict[str, Any] = field(repr=False)
    """All figures, as the command line writes them."""
    ts: float = field(repr=False)
    """Sampling period [s]."""
    u: Array = field(repr=False)
    """The compensated voltage [input unit], of shape (n,)."""
    path: Array = field(repr=False)
    """The path after shaping [output unit], of shape (n,)."""
    displacements: dict[str, Array] = field(repr=False)
    """The displacement of each run [output unit], of shape (n,), by the name of the run."""

    @property
    def tolerance(self) -> float:
        """Largest error of a settled displacement [output unit]."""
        return float(self.figures["tolerance"])

    @property
    def steps(self) -> pd.DataFrame:
        """One row per run and step: times [s], overshoot [output unit and % of the step]."""
        return frame([{"run": run["name"], **step} for run in self.figures["runs"] for step in run["steps"]])

    @property
    def scans(self) -> pd.DataFrame:
        """One row per run: share of the time within the tolerance [%], and the lag of a periodic path [s]."""
        rows = [
            {"run": run["name"], "within_percent": run["within_percent"], **(run["scan"] or {})}
            for run in self.figures["runs"]
        ]
        return frame(rows)

    @property
    def fastest(self) -> pd.DataFrame:
        """One row per purpose and shape of move: durations [s], overshoot [output unit]."""
        return frame(self.figures["fastest"])

    @property
    def notes(self) -> list[str]:
        """Remarks: on the tolerance, clipped voltages, the plant."""
        return [str(note) for note in self.figures["notes"]]

    def plot(self, *, ax: Any = None) -> Any:
        """A figure of the first steps, of when each run settles, and of the error along the path.

        It needs matplotlib and is `pz.plot.moves`. Returns an array of the Axes.
        """
        from . import plot

        return plot.moves(self, ax=ax)

    def __repr__(self) -> str:
        lines = [f"{m['purpose']} {1e3 * m['settling_s']:.4g} ms ({m['shape']})" for m in self._shortest()]
        unit = self.figures["unit"]
        return f"<Timing within {self.tolerance:.4g} {unit}: {', '.join(lines) or 'no move settles'}>"

    def _shortest(self) -> list[dict[str, Any]]:
        found = [self.figures[purpose]["shortest"] for purpose in ("step", "flyback")]
        return [move for move in found if move is not None]


@takes(TimingOptions)
def timing(
    model: Model | str | os.PathLike[str],
    path: Samples | None = None,
    *,
    plant: Plant | str | None = None,
    measured: Samples | None = None,
    on: Callable[[Array], Any] | None = None,
    wait: float = 10.0,
    progress: Progress = None,
    **options: Unpack[TimingOptions],
) -> Timing:
    """Times a path [output unit of the model], of shape (n,): on the model, compensated and along a straight line.

    It reports when each step settles and how far it overshoots, the lag of a periodic path, and the fastest steps and
    flybacks that the model can make. Without a path it is a step up and down.

    plant: also plays the path on this simulated actuator: a Plant, or the name of one
    measured: the displacement that was measured along the path [output unit], of shape (n,)
    on: also plays the path on the actuator, as in `campaign`: a function that plays voltages [V], one every `model.ts`,
    and returns the displacement at each of them [output unit]; it moves over the whole range, to demagnetise
    wait: after each demagnetisation, until creep has decayed [s]

    {options}

    >>> import piezoid as pz
    >>> model = pz.Model.from_dict({
    ...     "piezoid": 1, "ts": 1e-4, "units": {"u": "V", "y": "um"}, "hysteresis": {"operator": "proportional", "gain": 1.0},
    ...     "linear": {"a": [1.95, -0.96], "b": [0.0, 0.02]}, "identified": {"u": [0, 100], "hz": [0, 1000], "slew": 1e6, "mean": [0, 0]}})
    >>> found = pz.timing(model, tolerance="0.1um", slew=1e5)
    >>> bool(found.fastest["settling_s"].min() < found.steps["settling_s"].max())
    True
    """
    settings, own = known(timing, options), as_model(model)
    twin = plants[plant] if isinstance(plant, str) else plant
    if twin is not None and not isinstance(twin, Plant):
        raise _piezoid.PiezoidError(f"plant = {plant!r}: must be a Plant, or the name of one")
    named = None if twin is None else (twin.name, twin._core)
    if on is not None:
        settings["wait"] = wait
    with watched(progress) as watch:
        figures, u, shaped, runs = _piezoid.timing(own._core, path, (named, measured, on), settings, watch)
    return Timing(figures, own.ts, u, shaped, dict(runs))
