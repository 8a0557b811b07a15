"""A campaign: from a function that plays voltages, or a simulated actuator, to a model and a path that was measured."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np

from . import _piezoid
from ._progress import watched
from ._types import Array, Progress
from ._piezoid import PiezoidError
from .model import Model
from .plants import Plant, plants

__all__ = ["Campaign", "campaign"]


class Campaign:
    """What a campaign found.

    model: the model; better: how many times smaller the rms error of the compensated path is than with a straight line;
    straight, compensated: voltage `u` [V], requested `r` and measured displacement `y`, arrays of shape (n,) by name;
    results: all figures, as the command line writes them; page: the page as HTML
    """

    def __init__(
        self, model: Model, straight: dict[str, Array], compensated: dict[str, Array], results: dict[str, Any], page: str
    ) -> None:
        self.model, self.straight, self.compensated = model, straight, compensated
        self.results, self.page = results, page

    @property
    def better(self) -> float:
        """The rms error with a straight line over that of the compensated path."""
        return float(self.results["better"])

    def __repr__(self) -> str:
        error, unit = self.results["compensated"]["rmse"], self.results["compensated"]["unit"]
        return f"Campaign: rms error {error:.4g} {unit}, {self.better:.3g} times smaller than with a straight line"


def campaign(
    measure: Callable[[Array], Any] | Plant | str,
    *,
    ts: float | None = None,
    range: tuple[float, float] | None = None,
    bandwidth: float,
    unit: str | None = None,
    wait: float = 10.0,
    operator: str = "auto",
    actuator: str | None = None,
    slew: float | None = None,
    reference: Any = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress = None,
) -> Campaign:
    """Measures, identifies and straightens an actuator by a function, and measures how well it follows a path.

    The function plays voltages [V], one every `ts`, and returns the displacement at each of them. It is called several
    times with arrays of shape (n,), and the voltage stays between two calls. The first call moves slowly from 0 V, or
    from the end of the range nearest to it; the last one returns there. With nidaqmx it is about this:

        def measure(u):
            output.write(u, auto_start=False); reading.start(); output.start()
            return 20.0 * np.asarray(reading.read(len(u), timeout=len(u) * ts + 5))

    A simulated actuator in its place, a `stand_in` or a twin by name, is a rehearsal. Nothing waits then, and `ts` and
    `range` are optional: they are those of the stand-in, or the plan and the driver of the twin give them.

    ts: sampling period [s]; range: lowest and highest voltage [V]; bandwidth: highest frequency of the application [Hz];
    unit: that of the displacement, um by default; wait: after each demagnetisation [s]; operator: as for `identify`;
    actuator: one of `lists()["actuators"]`; slew: largest change of the voltage [V/s]; reference: the path to follow
    [unit], every `ts`, instead of one of its own; folder: gets each record once it is measured, and the page; what it
    holds is not measured again; progress: as for `identify`

    >>> import numpy as np, piezoid as pz
    >>> twin = pz.Model.from_dict({
    ...     "piezoid": 1, "ts": 0.01, "units": {"u": "V", "y": "um"},
    ...     "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [2.0]}})
    >>> noise = np.random.default_rng(0)
    >>> found = pz.campaign(lambda u: twin.simulate(u) + noise.normal(0, 1e-3, u.size),
    ...     ts=0.01, range=(-10, 10), bandwidth=2, wait=0, operator="proportional")
    >>> round(found.model.dc_gain, 2)
    2.0
    """
    plant = plants[measure] if isinstance(measure, str) else measure if isinstance(measure, Plant) else None
    own = "um" if plant is None else plant._core.units[1]
    if plant is not None:
        if unit not in (None, own):
            raise PiezoidError(f"unit = {unit}: the displacement of {plant.name} is in {own}: leave unit out")
        ts = plant._core.ts if ts is None else ts
    missing = "ts" if ts is None and (plant is None or reference is not None) else "range"
    if missing == "ts" or (plant is None and range is None):
        why = "the path" if plant is not None else "a function"
        raise PiezoidError(f"{missing} is missing: {why} needs it")
    options: dict[str, Any] = {"bandwidth": bandwidth, "wait": wait, "operator": operator}
    rows = [("range", None if range is None else list(range)), ("period", ts), ("actuator", actuator), ("slew", slew)]
    options |= {name: value for name, value in rows if value is not None}
    path = None if reference is None else np.asarray(reference, dtype=float).tolist()
    with watched(progress) as watch:
        model, straight, compensated, results, page = _piezoid.campaign(
            (None, (plant.name, plant._core)) if plant is not None else (measure, None),
            (ts or 0.0, unit or own),
            options,
            (folder, path),
            watch,
        )
    return Campaign(Model._of(model), straight, compensated, results, page)
