"""The linear block alone: difference equations and their fits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from . import _piezoid
from ._checks import whole, wholes
from ._piezoid import Arx
from ._progress import told
from ._types import Progress
from .records import Record

__all__ = ["Arx", "Fit", "fit"]


@dataclass(frozen=True)
class Fit:
    """A fitted block."""

    arx: Arx
    estimator: str
    offsets: list[float]
    """For each record, the constant in its output [output unit]."""
    residuals: dict[str, Any]
    """What one-step prediction leaves [output unit]."""
    history: list[float]
    """Best cost at the start and after each iteration, of estimators that iterate."""


def fit(
    records: Record | Iterable[Record],
    order: int | tuple[int, int, int] = 2,
    *,
    estimator: str = "least-squares",
    particles: int | None = None,
    iterations: int | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Fit:
    """Fits y = a1 y1 + ... + b0 u + b1 u1 + ... to one or more records.

    order: of the block, or (number of a, number of b, samples of delay)
    estimator: one of `pz.estimators`; `particles`, `iterations` and `seed` are of the swarm
    """
    given = [records] if isinstance(records, Record) else list(records)
    na, nb, delay = order if isinstance(order, tuple) else (order, order + 1, 0)
    orders = (whole("order", na), whole("order", nb), whole("delay", delay))
    swarm = wholes(particles=particles, iterations=iterations)
    with told(progress) as watch:
        arx, found = _piezoid.fit(
            [record._core for record in given], orders, estimator, (swarm["particles"], swarm["iterations"], whole("seed", seed)), watch
        )
    return Fit(arx, **found)
