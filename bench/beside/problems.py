"""The problems compared: filters, fits, the swarm, simulations."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any

import numpy as np
import piezoid as pz
import scipy.linalg
from scipy.signal import lfilter

from . import fits, rivals
from .rivals import Array
from .table import Row, Took, counted, in_turn

TS = 5e-4
"""Sampling period of the twin [s]."""


@dataclass
class Page:
    """Contents of the page; `quick` is a short test."""

    quick: bool
    rows: list[Row] = field(default_factory=list)
    unseen: list[list[list[str]]] = field(default_factory=list)
    """Tables of errors on validation records; the first row is the head."""
    facts: list[str] = field(default_factory=list)
    """Sentences with numbers measured in this run."""

    def add(self, problem: str, other: str, measure: str, errors: tuple[float, float], *took: Took) -> None:
        """Adds one comparison: errors and times of piezoid and of the other tool."""
        self.rows.append(Row(problem, other, measure, *errors, *took))


@cache
def prbs() -> pz.Record:
    """The twin's response to a PRBS of 1 V."""
    return pz.plants["pl140"].measure(pz.excite.prbs(ts=TS, duration=2.0475, amplitude=1, order=12), TS)


def modulated(hz: float, amplitude: float, n: int) -> Array:
    """A sine whose amplitude is modulated at an incommensurate frequency."""
    turns = 2 * np.pi * hz * TS * np.arange(n)
    return np.asarray(amplitude * (0.5 + 0.5 * np.sin(turns * 2**0.5 / 9)) * np.sin(turns))


def filters(page: Page) -> None:
    """Simulation of a difference equation."""
    noise = np.random.default_rng(0).standard_normal(1_000_000)
    for order in (2, 6):
        arx = pz.linear.fit(prbs(), order, estimator="output-error").arx
        b, a = arx.b, np.r_[1.0, -arx.a]
        for n in (1, 1000, 20_000, 1_000_000):
            u = noise[:n]
            exact = lfilter(b.astype(np.longdouble), a.astype(np.longdouble), u.astype(np.longdouble))
            ours, theirs = in_turn(lambda: arx.simulate(u), lambda: lfilter(b, a, u), repeats=3 if page.quick else 15)
            errors = off(ours.result, exact), off(theirs.result, exact)
            page.add(f"filter, order {order}, {counted(n)}", "`lfilter`", "error / peak", errors, ours, theirs)
            if n == 1 and order == 2:
                page.facts.append(
                    f"A call of one sample takes {1e6 * ours.seconds:.2f} us by `Arx.simulate`: this is mainly "
                    "the overhead of a call from Python (the goal was at most 5 us)."
                )


def blocks(page: Page) -> None:
    """Fit of a difference equation."""
    record, order, repeats = prbs(), 2, 3 if page.quick else 15
    u, y = record.u, record.y

    def solved(solve: Callable[[Array, Array], Any]) -> tuple[Array, float]:
        target, rows = rivals.regression(u, y, order)
        theta = solve(rows, target)
        return theta[:5], rms(target - rows @ theta)

    def ours(estimator: str) -> tuple[Array, float]:
        fit = pz.linear.fit(record, order, estimator=estimator)
        return np.r_[fit.arx.a, fit.arx.b], fit.residuals["rms"]

    ways: dict[str, Callable[[Array, Array], Any]] = {
        "`numpy.linalg.lstsq`": lambda x, t: np.linalg.lstsq(x, t, rcond=None)[0],
        "`scipy.linalg.lstsq`, gelsy": lambda x, t: scipy.linalg.lstsq(x, t, lapack_driver="gelsy", check_finite=False)[0],
        "numpy, normal equations": lambda x, t: np.linalg.solve(x.T @ x, x.T @ t),
    }
    mine, *others = in_turn(
        lambda: ours("least-squares"), *[partial(solved, way) for way in ways.values()], repeats=repeats
    )
    for name, other in zip(ways, others):
        errors = mine.result[1], other.result[1]
        page.add("ARX of order 2, least squares", name, "one-step rms [um]", errors, mine, other)
    apart = max(float(np.abs(other.result[0] - mine.result[0]).max()) for other in others)
    page.facts.append(f"The least-squares coefficients differ from those of numpy and scipy by at most {apart:.1e}.")

    def left(run: Array) -> float:
        return rms((run - y - (run - y).mean())[order:])

    def simulated(theta: Array) -> Array:
        return np.asarray(lfilter(theta[order:], np.r_[1.0, -theta[:order]], u))

    mine, by_hand, narx = in_turn(
        lambda: ours("output-error"),
        lambda: rivals.output_error(u, y),
        lambda: fits.Narx([record], fits.Setting(1, 1, order, 2 * order + 1)),
        repeats=repeats,
    )
    best, measure = left(simulated(mine.result[0])), "free-run rms [um]"
    title = f"order 2, output error, PRBS of {counted(len(record))}"
    errors = best, left(simulated(by_hand.result))
    page.add(title, "`scipy.optimize.least_squares` on `lfilter`", measure, errors, mine, by_hand)
    errors = best, left(narx.result.simulate(record))
    page.add(title, "SysIdentPy ARX (FROLS of degree 1)", measure, errors, mine, narx)


def swarms(page: Page) -> None:
    """The paper's estimator, and the exact optimum."""
    record, iterations, seeds = prbs(), 20 if page.quick else rivals.ITERATIONS, range(1, 3 if page.quick else 22)
    offset = pz.linear.fit(record, 2).offsets[0]
    y, rows = rivals.regression(record.u, record.y - offset, 2)
    rows = rows[:, :5]
    psi = np.ascontiguousarray(rows.T)

    def ours(estimator: str, seed: int = 0) -> float:
        fit = pz.linear.fit(
            record, 2, estimator=estimator, particles=rivals.PARTICLES, iterations=iterations, seed=seed
        )
        return float(fit.residuals["sum_abs"])

    exact = in_turn(
        lambda: ours("least-absolute"), lambda: rivals.least_absolute(y, rows), repeats=1 if page.quick else 3
    )
    least = min(took.result for took in exact)
    for cost in rivals.COSTS:
        ours("swarm"), rivals.swarm(y, psi, 0, 2, cost)  # warm-up

    def theirs(seed: int) -> list[Callable[[], float]]:
        return [partial(rivals.swarm, y, psi, seed, iterations, cost) for cost in rivals.COSTS]

    rounds = [in_turn(partial(ours, "swarm", seed), *theirs(seed), repeats=1) for seed in seeds]
    mine, *others = [Took([took.result for took in side], [took.seconds for took in side]) for side in zip(*rounds)]
    measure = "sum of absolute errors above the minimum [um]"
    for cost, other in zip(rivals.COSTS, others):
        for name, of in [("median", statistics.median), ("worst", max)]:
            errors = of(mine.result) - least, of(other.result) - least
            title = f"swarm, least absolute error, {name} of {len(seeds)} seeds"
            page.add(title, f"pyswarms 1.3, cost in {cost}", measure, errors, mine, other)
    errors = exact[0].result - least, exact[1].result - least
    page.add("least absolute error, exact", "`linprog`, HiGHS", measure, errors, *exact)
    page.facts.append(f"The minimum of the sum of absolute errors, to which the rows \"swarm\" refer, is {least:.4f} um.")


def model(operator: str, **law: Any) -> pz.Model:
    """A hysteresis law followed by a block of order 2."""
    arx = pz.linear.fit(prbs(), 2, estimator="output-error").arx
    return pz.Model.from_dict(
        {
            "piezoid": 1, "ts": TS, "units": {"u": "V", "y": "um"}, "offset": 0.0,
            "hysteresis": {"operator": operator, "range": [-30.0, 30.0], **law},
            "linear": {"a": arx.a.tolist(), "b": arx.b.tolist()},
        }
    )  # fmt: skip


def beamed(of: pz.Model, z: Array) -> Array:
    """The response of the linear block of a model to `z`, in the precision of `z`."""
    return np.asarray(lfilter(of.b.astype(z.dtype), np.r_[1.0, -of.a].astype(z.dtype), z))


def plays(page: Page) -> None:
    """Simulation of a sum of plays."""
    r, w = 0.95 * np.arange(1.0, 31.0), np.r_[1.0, 0.03 + 0.01 * np.cos(np.arange(30))]
    ours = model("prandtl-ishlinskii", thresholds=r.tolist(), weights=w.tolist())
    u = modulated(20, 28, 2000 if page.quick else 20_000)
    exact = beamed(ours, rivals.plays_by_stretch(*[x.astype(np.longdouble) for x in (u, r, w)]))
    mine, *others = in_turn(
        lambda: ours.simulate(u),
        lambda: beamed(ours, rivals.plays_by_stretch(u, r, w)),
        lambda: beamed(ours, rivals.plays_by_sample(u, r, w)),
        repeats=3 if page.quick else 9,
    )
    for name, other in zip(["numpy, all samples of a monotone part together", "numpy, plays at once"], others):
        errors = off(mine.result, exact), off(other.result, exact)
        page.add(f"30 plays and order 2, {counted(len(u))}", name, "error / peak", errors, mine, other)


def bouc_wen(page: Page) -> None:
    """Simulation of a differential equation of hysteresis."""
    beta, ratio, w = 0.02, 0.25, (1.4, 0.5)
    ours = model("bouc-wen", beta=beta, gamma_over_beta=ratio, weights=w)
    long = modulated(20, 28, 2000 if page.quick else 20_000)
    ways: list[tuple[str, Array, Callable[[Array], Array]]] = [
        ("Python, the exact exponentials", long, lambda u: rivals.bouc_wen(u, beta, ratio * beta)),
        ("`solve_ivp`, RK45", long[: len(long) // 5], lambda u: rivals.bouc_wen_ivp(u, TS, beta, ratio * beta)),
    ]
    for name, u, way in ways:
        h = rivals.bouc_wen(u.astype(np.longdouble), beta, ratio * beta, np.exp)
        exact = beamed(ours, w[0] * u - w[1] * h)
        mine, other = in_turn(
            lambda: ours.simulate(u), lambda: beamed(ours, w[0] * u - w[1] * way(u)), repeats=3
        )
        errors = off(mine.result, exact), off(other.result, exact)
        page.add(f"Bouc-Wen and order 2, {counted(len(u))}", name, "error / peak", errors, mine, other)


def off(run: Array, exact: Array) -> float:
    """The largest error, divided by the peak."""
    return float(np.abs(run - exact).max() / np.abs(exact).max())


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))
