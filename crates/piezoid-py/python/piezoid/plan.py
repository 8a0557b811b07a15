"""The drives of an identification, within the limits of a driver."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._keywords import known, takes
from ._options import PlanOptions
from ._types import Array
from .model import Model, as_model
from .plants import Plant as Actuator
from .plants import plants

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Plan(dict[str, Array]):
    """The voltages [V] by the names of their records, `small`, `rise1` to `rise3`, `creep` and `path`; shape (n,).

    ts: sampling period [s]; page: the page in Markdown; notes: what was shortened or reduced, and what to watch;
    advice: the record that would lower the error of prediction of the model most, or that none would lower it by much,
    `None` without a model; uncertainty: the same in figures, with its `parameters`, the one that adds most first;
    rehearsal: displacement, rate and vibration of each drive on a simulated actuator, `None` without one
    """

    def __init__(
        self,
        drives: dict[str, Array],
        ts: float,
        page: str,
        notes: list[str],
        advice: str | None,
        uncertainty: dict[str, Any] | None,
        rehearsal: dict[str, Any] | None,
    ) -> None:
        super().__init__(drives)
        self.ts, self.page, self.notes, self.advice, self.uncertainty = ts, page, notes, advice, uncertainty
        self.rehearsal = rehearsal

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {u.size} samples, {u.min():.4g} to {u.max():.4g} V" for name, u in self.items())


@takes(PlanOptions)
def plan(
    folder: str | os.PathLike[str] | None = None,
    *,
    model: Model | str | os.PathLike[str] | None = None,
    plant: Actuator | str | None = None,
    **options: Unpack[PlanOptions],
) -> Plan:
    """Plans the records of an identification: returns the drives, and writes them and `plan.md` to `folder` if given.

    model: a first model; the plan then has its sampling period, and `advice`
    plant: a `stand_in`, or a twin by name, on which the drives are played; the plan then has a `rehearsal`, and without a
    range that of the records of the stand-in

    Options:

    {options}

    >>> import piezoid as pz
    >>> plan = pz.plan(range=(0, 100), bandwidth=20, driver="e-610", capacitance=1.5e-6)
    >>> plan.ts, plan["small"].size
    (0.002, 4608)
    """
    first = None if model is None else as_model(model)._core
    actuator = plants[plant] if isinstance(plant, str) else plant
    played = None if actuator is None else (actuator.name, actuator._core)
    return Plan(**_piezoid.plan(known(plan, options), first, played, folder))
