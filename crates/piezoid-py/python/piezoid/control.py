"""Comparison of controllers on a twin."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._checks import called, number, some
from ._keywords import known, takes
from ._options import ControlOptions
from ._progress import watched
from ._types import Array, Progress, Samples
from .model import Model, as_model
from .plants import Plant, plants

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

MOST = 1e8
"""Maximum number of samples of a reference."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of each controller along each reference."""

    figures: dict[str, Any] = field(repr=False)
    """All figures, as the command line writes them."""
    runs: list[dict[str, Any]] = field(repr=False)
    """One dict per run: `controller`, `reference`, and the arrays `u`, `y`, `r` of shape (n,), or an `error`."""
    html: str = field(repr=False)
    """A page with tables and figures."""
    ts: float = field(repr=False)
    """Sampling period of the runs [s]."""

    def run(self, controller: str | None = None, reference: str | None = None) -> dict[str, Any]:
        """The first run of this controller along this reference; None stands for any."""
        for run in self.runs:
            if controller in (None, run["controller"]) and reference in (None, run["reference"]):
                return run
        names = sorted({f"{run['controller']} along {run['reference']}" for run in self.runs})
        requested = f"{controller or 'any'} along {reference or 'any'}"
        raise _piezoid.PiezoidError(f"there is no run of {requested}; the runs are: {', '.join(names)}")

    @property
    def table(self) -> pd.DataFrame:
        """Rms errors in percent of the peak-to-peak of the reference: one row per reference, one column per controller.

        The first whole periods (0.25 s or more) of a periodic reference are left out.
        """
        import pandas as pd

        rows: dict[str, dict[str, float]] = {}
        for run in self.runs:
            rows.setdefault(run["reference"], {})[run["controller"]] = run.get("percent_of_stroke", float("nan"))
        return pd.DataFrame.from_dict(rows, orient="index")

    def __repr__(self) -> str:
        return f"<Comparison: rms errors [% of height]>\n{self.table}"


def reference(name: str, model: Model | str | os.PathLike[str], *, peak: float, frequency: float, duration: float) -> Array:
    """A reference by name (`pz.references`) [output unit], of shape (n,), for this `duration` [s].

    >>> import piezoid as pz
    >>> block = {"a": [0.5], "b": [1.0]}
    >>> model = pz.Model.from_dict({"piezoid": 1, "ts": 1e-3, "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": block})
    >>> r = pz.reference("triangle", model, peak=2.0, frequency=5.0, duration=0.4)
    >>> len(r), float(abs(r).max())
    (400, 2.0)
    """
    model = as_model(model)
    if not 1 <= number("duration", duration) / model.ts <= MOST:
        raise _piezoid.PiezoidError(f"duration = {duration:g} s: must be from 1 to {MOST:g} samples of {model.ts:g} s")
    n = round(duration / model.ts)
    with called(amplitude="peak"):
        return _piezoid.follow(name, model.ts, n, number("peak", peak), number("frequency", frequency))


@takes(ControlOptions)
def control(
    plant: Plant | str,
    model: Model | str | os.PathLike[str],
    reference: Samples | Mapping[str, Samples],
    *,
    controller: str | Iterable[str] = ("gain", "feed-forward", "integral-notch", "feed-forward+integral-notch"),
    tolerance: tuple[float, int] | None = None,
    progress: Progress = None,
    **options: Unpack[ControlOptions],
) -> Comparison:
    """Simulates a plant that follows references [output unit of the model] with one or several controllers.

    controller: names in `pz.controllers`, such as "feed-forward+pi"; they are tuned to the model
    tolerance: (share, draws), such as (0.2, 200): also simulates 200 random plants, whose parameters differ from those
    of the plant by up to 0.2 (20 %; the option of the command line is in percent)

    {options}
    """
    settings = known(control, options)
    named = reference if isinstance(reference, Mapping) else {"reference": reference}
    twin, own = plants[plant] if isinstance(plant, str) else plant, as_model(model)
    if not isinstance(twin, Plant):
        raise _piezoid.PiezoidError(f"plant = {plant!r}: must be a Plant, or the name of one")
    schemes = [controller] if isinstance(controller, str) else list(controller)
    if not schemes or not named:
        raise _piezoid.PiezoidError(f"there is no {'reference' if schemes else 'controller'}: give one at least")
    share = (None, 200) if tolerance is None else some("tolerance", tolerance, "share, draws")
    # The library uses percent.
    percent = None if share[0] is None else round(100 * number("tolerance", share[0]), 12)
    settings |= {"controller": schemes, "tolerance": percent, "draws": share[1]}
    references = [(str(name), r) for name, r in named.items()]
    with watched(progress) as watch:
        figures, runs, html = _piezoid.control((twin.name, twin._core), own._core, references, settings, watch)
    return Comparison(figures, runs, html, own.ts)

