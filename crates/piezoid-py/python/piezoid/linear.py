"""The linear block alone: difference equations and their fits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._checks import some, whole
from ._keywords import known, takes
from ._options import SwarmOptions
from ._piezoid import Arx
from ._progress import watched
from ._types import Progress
from .records import as_records

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .records import Sources

__all__ = ["Arx", "Fit", "fit"]


@dataclass(frozen=True)
class Fit:
    """A fitted block."""

    arx: Arx
    estimator: str
    offsets: list[float]
    """For each record, the constant in its output [output unit]."""
    residuals: dict[str, Any]
    """Residuals of the one-step prediction [output unit]."""
    history: list[float]
    """Best cost at the start and after each iteration, for iterative estimators."""


@takes(SwarmOptions)
def fit(
    records: Sources,
    order: int | Sequence[int] = 2,
    *,
    estimator: str = "least-squares",
    progress: Progress = None,
    **swarm: Unpack[SwarmOptions],
) -> Fit:
    """Fits y = a1 y1 + ... + b0 u + b1 u1 + ... to one or more records, or to anything that `read` accepts.

    order: of the block, or (number of a, number of b, samples of delay)
    estimator: one of `pz.estimators`

    Options of the estimator swarm:

    {options}

    >>> import piezoid as pz
    >>> u = pz.excite.prbs(ts=5e-4, duration=2, amplitude=1)
    >>> block = pz.linear.Arx([1.7, -0.9], [0.0, 3.0, 2.5], ts=5e-4)
    >>> found = pz.linear.fit(pz.Record(u, block.simulate(u), ts=5e-4))
    >>> found.arx.a.round(6).tolist()
    [1.7, -0.9]
    """
    settings, values = known(fit, swarm), as_records(records)
    is_one = isinstance(order, str) or not isinstance(order, Sequence)
    na, nb, delay = (order, whole("order", order) + 1, 0) if is_one else some("order", order, "a, b, delay")
    orders = (whole("order", na), whole("order", nb), whole("delay", delay))
    with watched(progress) as watch:
        arx, found = _piezoid.fit([r._core for r in values], orders, estimator, settings, watch)
    return Fit(arx, **found)
