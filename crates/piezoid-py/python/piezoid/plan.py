"""The drives of an identification, within the limits of a driver."""

from __future__ import annotations

import os
from typing import Any

from . import _piezoid
from ._types import Array
from .lists import described
from .model import Model, as_model


class Plan(dict[str, Array]):
    """The voltages [V] by the names of their records, `small`, `rise1` to `rise3`, `creep` and `path`; shape (n,).

    ts: sampling period [s]; page: the page in Markdown; notes: what was shortened or reduced, and what to watch;
    advice: the record that would lower the largest uncertainty of the model most, `None` without a model
    """

    def __init__(self, made: tuple[list[tuple[str, Array]], float, str, list[str], str | None]) -> None:
        drives, self.ts, self.page, self.notes, self.advice = made
        super().__init__(drives)

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {u.size} samples, {u.min():.4g} to {u.max():.4g} V" for name, u in self.items())


def plan(
    folder: str | os.PathLike[str] | None = None,
    *,
    model: Model | str | os.PathLike[str] | None = None,
    **options: Any,
) -> Plan:
    """Plans the records of an identification: returns the drives, and writes them and `plan.md` to `folder` if given.

    model: a first model; the plan has its sampling period, and an advice

    Options:

    {options}

    >>> import piezoid as pz
    >>> plan = pz.plan(range=(0, 100), bandwidth=20, driver="e-610", capacitance=1.5e-6)
    >>> plan.ts, plan["small"].size
    (0.002, 4608)
    """
    for name in options:
        if name not in _OPTIONS:
            raise TypeError(f"unexpected keyword {name!r}: options are {', '.join(_OPTIONS)}")
    return Plan(_piezoid.plan(options, None if model is None else as_model(model)._core, folder))


_ROWS = _piezoid.plan_options()
_OPTIONS = [row["name"] for row in _ROWS]
plan.__doc__ = (plan.__doc__ or "").replace("{options}", "\n    ".join(described(_ROWS)))
