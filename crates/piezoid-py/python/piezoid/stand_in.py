"""Stand-ins: simulated actuators made of the records of a measured one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._progress import watched
from ._types import Progress, Units
from .identify import _record
from .model import Model, as_model
from .plants import Plant
from .records import sources

if TYPE_CHECKING:
    from .records import Sources


def stand_in(
    model: Model | str | os.PathLike[str],
    data: Sources = (),
    *,
    ts: float | None = None,
    fs: float | None = None,
    units: Units | Mapping[str, str] | None = None,
    profile: str | os.PathLike[str] | None = None,
    small_signal: Sources = (),
    progress: Progress = None,
) -> Plant:
    """A stand-in for the actuator of a model: a second model of the same records, with an operator of another class.

    It differs from the model by as much as the actuator does on the records, and has their noise. `control`, `timing` and
    `campaign` take it in place of a twin; `str(stand_in)` says what it consists of.

    data, small_signal: the records that the model was identified from, as in `identify`
    ts, fs, units, profile: for every source that is not yet a `Record`, as for `read`

    >>> import piezoid as pz
    >>> u = pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4)
    >>> record = pz.plants["pl140"].measure(u, ts=1e-3)
    >>> model = pz.identify(record, operator="prandtl-ishlinskii", order=2)
    >>> actuator = pz.stand_in(model, record)
    >>> len(actuator.simulate(u))
    2000
    """
    how: dict[str, Any] = {"ts": ts, "fs": fs, "units": units, "profile": profile}
    small, large = [[_record(source, how)._core for source in sources(part)] for part in (small_signal, data)]
    with watched(progress) as watch:
        return Plant._of(_piezoid.stand_in(as_model(model)._core, (small, large), watch), "stand-in")
