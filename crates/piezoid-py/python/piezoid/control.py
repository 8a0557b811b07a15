"""Schemes of control, side by side on a twin."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._checks import limits as checked
from ._checks import whole
from ._progress import told
from ._types import Array, Progress, Samples
from .model import Model
from .plants import Plant, plants

if TYPE_CHECKING:
    import pandas as pd

    from ._checks import Limits, Unpack

MOST = 1e8
"""Samples of a reference."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Each controller along each reference."""

    figures: dict[str, Any] = field(repr=False)
    """All figures, as the command line writes them."""
    runs: list[dict[str, Any]] = field(repr=False)
    """One dict a run: `controller`, `reference`, and the arrays `u`, `y`, `r` of shape (n,), or an `error`."""
    html: str = field(repr=False)
    """A page with tables and figures."""
    ts: float = field(repr=False)
    """Sampling period of the runs [s]."""

    def run(self, controller: str | None = None, reference: str | None = None) -> dict[str, Any]:
        """The first run of these names."""
        for run in self.runs:
            if controller in (None, run["controller"]) and reference in (None, run["reference"]):
                return run
        names = sorted({f"{run['controller']} along {run['reference']}" for run in self.runs})
        raise _piezoid.PiezoidError(f"there is no run of {controller} along {reference}: there are {', '.join(names)}")

    @property
    def table(self) -> pd.DataFrame:
        """Rms errors in percent of the height of the reference, of one that repeats from its second period on: one row a
        reference, one column a controller."""
        import pandas as pd

        rows: dict[str, dict[str, float]] = {}
        for run in self.runs:
            rows.setdefault(run["reference"], {})[run["controller"]] = run.get("percent_of_stroke", float("nan"))
        return pd.DataFrame.from_dict(rows, orient="index")


def reference(name: str, model: Model, *, peak: float, frequency: float, duration: float) -> Array:
    """A reference by name (`pz.references`) [output unit], of shape (n,), for this `duration` [s].

    >>> import piezoid as pz
    >>> block = {"a": [0.5], "b": [1.0]}
    >>> model = pz.Model.from_dict({"piezoid": 1, "ts": 1e-3, "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": block})
    >>> r = pz.reference("triangle", model, peak=2.0, frequency=5.0, duration=0.4)
    >>> len(r), float(abs(r).max())
    (400, 2.0)
    """
    if not 1 <= duration / model.ts <= MOST:
        raise _piezoid.PiezoidError(f"duration = {duration:g} s: must be from 1 to {MOST:g} samples of {model.ts:g} s")
    n = round(duration / model.ts)
    return _piezoid.follow(name, model.ts, n, peak, frequency)


def control(
    plant: Plant | str,
    model: Model,
    reference: Samples | Mapping[str, Samples],
    *,
    controller: str | Iterable[str] = ("gain", "feed-forward", "integral-notch", "feed-forward+integral-notch"),
    late: int = 0,
    gain_margin: float | None = None,
    phase_margin: float | None = None,
    preview: int | None = None,
    tolerance: tuple[float, int] | None = None,
    seed: int = 1,
    progress: Progress = None,
    **limits: Unpack[Limits],
) -> Comparison:
    """Drives a twin along references [output unit of the model], by one or several controllers (`pz.controllers`), such as
    "feed-forward+pi", tuned to the model.

    late: samples by which readings come late; gain_margin [dB], phase_margin [degrees]: what controllers are tuned to
    preview: samples of the reference known ahead; to its end where it is not given
    tolerance: (share, draws) drives plants drawn about this one too
    limits: `driver`, `capacitance`, `low`, `high`, `slew`, `current`, `clip`, as of `Model.compensation`
    """
    named = reference if isinstance(reference, Mapping) else {"reference": reference}
    twin = plants[plant] if isinstance(plant, str) else plant
    schemes = [controller] if isinstance(controller, str) else list(controller)
    with told(progress) as watch:
        figures, runs, html = _piezoid.control(
            (twin.name, twin._core),
            model._core,
            schemes,
            list(named.items()),
            checked(limits),
            (whole("late", late), gain_margin, phase_margin),
            None if preview is None else whole("preview", preview),
            whole("seed", seed),
            tolerance,
            watch,
        )
    return Comparison(figures, runs, html, model.ts)

