"""Filters, fits, swarms and hysteresis as users of numpy, scipy and pyswarms write them, each as fast as possible."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares, linprog
from scipy.signal import lfilter, lfiltic

Array = npt.NDArray[Any]

PARTICLES, ITERATIONS = 50, 500
"""Settings of the paper's swarm."""


def regression(u: Array, y: Array, order: int) -> tuple[Array, Array]:
    """y[t], and for each t the row y[t-1] ... y[t-order], u[t] ... u[t-order], 1."""
    n = len(y)
    past = [x[order - lag : n - lag] for x, first in ((y, 1), (u, 0)) for lag in range(first, order + 1)]
    return y[order:], np.column_stack([*past, np.ones(n - order)])


def looped(y: Array, psi: Array) -> Callable[[Array], Array]:
    """Sum of absolute errors y - theta psi of each particle, in a loop over the particles."""
    return lambda theta: np.array([np.abs(y - x @ psi).sum() for x in theta])


def plain(y: Array, psi: Array) -> Callable[[Array], Array]:
    """The same for all particles in one product; arrays are allocated in each iteration."""
    return lambda theta: np.asarray(np.abs(y - theta @ psi).sum(axis=1))


def kept(y: Array, psi: Array) -> Callable[[Array], Array]:
    """The same in one array that is reused, which avoids page faults."""
    errors = np.empty((PARTICLES, len(y)))

    def fitness(theta: Array) -> Array:
        np.matmul(theta, psi, out=errors)
        np.subtract(y, errors, out=errors)
        np.abs(errors, out=errors)
        return np.asarray(errors.sum(axis=1))

    return fitness


COSTS = {"a loop over particles": looped, "plain arrays": plain, "arrays that are kept": kept}
"""Three ways to write the cost of a swarm with numpy."""

WEIGHTS = {"c1": 1.5, "c2": 1.5, "w": 0.65}
"""Weights of pyswarms, which are constant."""


def swarm(y: Array, psi: Array, seed: int, iterations: int = ITERATIONS, cost: str = "arrays that are kept") -> float:
    """Smallest sum of absolute errors y - theta psi by pyswarms 1.3 with one of `COSTS`; `psi` has shape (5, n)."""
    import pyswarms

    b_max = np.abs(y).max() / np.abs(psi[2:]).max()
    high = np.array([2.0, 1.0, b_max, b_max, b_max])
    np.random.seed(seed)
    search = pyswarms.single.GlobalBestPSO(PARTICLES, 5, options=WEIGHTS, bounds=(-high, high))
    least, _ = search.optimize(COSTS[cost](y, psi), iters=iterations, verbose=False)
    return float(least)


def least_absolute(y: Array, psi: Array) -> float:
    """Minimum of sum |y - psi theta|, as a linear program: theta free, excess and shortfall of each row positive."""
    from scipy.sparse import csr_array, eye_array, hstack

    rows, columns = psi.shape
    unit = eye_array(rows, format="csr")
    cost = np.r_[np.zeros(columns), np.ones(2 * rows)]
    bounds = [(None, None)] * columns + [(0, None)] * (2 * rows)
    found = linprog(cost, A_eq=hstack([csr_array(psi), unit, -unit]), b_eq=y, bounds=bounds, method="highs")
    return float(found.fun)


def output_error(u: Array, y: Array) -> Array:
    """a and b of order 2 with the least squared error of the free run; initial conditions and constant are free."""
    mean = y.mean()
    target, rows = regression(u, y - mean, 2)
    start = np.linalg.lstsq(rows, target, rcond=None)[0][:5]

    def left(theta: Array) -> Array:
        den = np.r_[1.0, -theta[:2]]
        run, _ = lfilter(theta[2:5], den, u, zi=lfiltic(theta[2:5], den, theta[5:7]))
        return np.asarray(run + theta[7] - y)

    found = least_squares(left, np.r_[start, y[1::-1] - mean, mean], x_scale="jac", method="lm")
    return np.asarray(found.x[:5])


def plays_by_sample(u: Array, r: Array, w: Array) -> Array:
    """Prandtl-Ishlinskii from rest: all plays of a sample together, the samples one by one."""
    low, high = u[:, None] - r, u[:, None] + r
    p = np.zeros((len(u) + 1, len(r)), dtype=u.dtype)
    for t in range(len(u)):
        np.minimum(high[t], p[t], out=p[t + 1])
        np.maximum(low[t], p[t + 1], out=p[t + 1])
    return np.asarray(w[0] * u + p[1:] @ w[1:])


def plays_by_stretch(u: Array, r: Array, w: Array) -> Array:
    """The same, all samples of a monotone part together."""
    z = np.empty_like(u)
    for samples, plays in stretches(u, r):
        z[samples] = plays @ w[1:]
    return np.asarray(z + w[0] * u)


def stretches(u: Array, r: Array) -> Iterator[tuple[slice, Array]]:
    """The plays from rest, a row per sample, from one reversal of the input to the next: while it rises or is held, a
    play is max(p, u - r).
    """
    way = np.sign(np.diff(u, prepend=0.0))
    # A held input, as on a staircase, is no reversal: it keeps the direction of its last step.
    way = way[np.maximum.accumulate(np.where(way != 0, np.arange(len(u)), 0))]
    turns = np.flatnonzero(np.diff(way)) + 1
    p = np.zeros(len(r), dtype=u.dtype)
    for start, end in zip([0, *turns], [*turns, len(u)]):
        stretch = u[start:end, None]
        plays = np.maximum(stretch - r, p) if way[start] > 0 else np.minimum(stretch + r, p)
        p = plays[-1]
        yield slice(start, end), plays


def bouc_wen(u: Array, beta: float, gamma: float, exp: Callable[[Any], Any] = math.exp) -> Array:
    """Exact h of h' = u' - beta |u'| h - gamma u' |h| from rest: at most two exponentials per step of the input."""
    log = math.log if exp is math.exp else np.log
    h = last = u[0] * 0
    out = []
    for now in u.tolist() if exp is math.exp else u:
        way = 1 if now > last else -1
        path, g = way * (now - last), way * h
        if g < 0:
            rate = beta - gamma
            zero = log(1 - rate * g) / rate if rate else -g
            if path < zero:
                g, path = (1 - (1 - rate * g) * exp(-rate * path)) / rate if rate else g + path, 0
            else:
                g, path = 0, path - zero
        if path > 0:
            rate = beta + gamma
            g = (1 - (1 - rate * g) * exp(-rate * path)) / rate
        h, last = way * g, now
        out.append(h)
    return np.array(out)


def bouc_wen_ivp(u: Array, ts: float, beta: float, gamma: float) -> Array:
    """The same by scipy's default solver, with a linearly interpolated input."""
    slopes = np.append(np.diff(u, prepend=0.0) / ts, 0.0).tolist()

    def law(t: float, h: Array) -> list[float]:
        slope = slopes[int(t / ts)]
        return [slope - beta * abs(slope) * h[0] - gamma * slope * abs(h[0])]

    n = len(u)
    found = solve_ivp(law, (0.0, n * ts), [0.0], t_eval=np.linspace(ts, n * ts, n), max_step=ts, rtol=1e-6, atol=1e-9)
    return np.asarray(found.y[0])
