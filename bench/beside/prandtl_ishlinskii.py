"""Prandtl-Ishlinskii and a linear block of order 2, as users of scipy identify them.

    z = w0 u + sum of w_i p_i,    y = q^-d B(q) / A(q) z + constant,    d = 0 or 1

The plays p_i have fixed thresholds, and no weight is negative. The free run is linear in the weights, so for each block
they follow from `nnls`, and `least_squares` searches only the block (variable projection, doi:10.1137/0710036).

It does not do: asymmetric loops, drift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import piezoid as pz
from scipy.optimize import least_squares, nnls
from scipy.signal import lfilter

from . import rivals
from .fits import span
from .rivals import Array

PLAYS = 20


@dataclass(frozen=True)
class PrandtlIshlinskii:
    """Thresholds, w0 and the weights of the plays, B and A, and the constant."""

    mid: float
    r: Array
    w: Array
    b: Array
    a: Array
    offset: float = 0.0

    def simulate(self, record: pz.Record) -> Array:
        """The free run from rest at the middle of the range."""
        z = rivals.plays_by_stretch(record.u - self.mid, self.r, self.w)
        return np.asarray(self.offset + lfilter(self.b, self.a, z))


def fit(records: Sequence[pz.Record], resonance: float | None, start: int = 0) -> PrandtlIshlinskii:
    """Least squares fit of free runs from sample `start` on; for each delay from the best of four start values of the
    block; one constant per record.
    """
    half, mid = span(records)
    r = half * np.arange(1, PLAYS + 1) / (PLAYS + 1)
    inputs = [_inputs(record.u - mid, r) for record in records]
    y = np.concatenate([record.y[start:] - record.y[start:].mean() for record in records])
    ends = np.cumsum([len(record) - start for record in records])
    # The responses to u and to the plays, and y, in one array that is kept, which avoids page faults.
    rows = np.vstack([np.empty((1 + PLAYS, len(y))), y])
    ts = records[0].ts
    if resonance:
        starts = [np.log([2 * np.pi * resonance * ts, damping]) for damping in (0.01, 0.03, 0.1, 0.3)]
    else:
        starts = [np.log([speed, 1.5]) for speed in (0.03, 0.1, 0.3, 1.0)]
    # Without a visible resonance the block is two lags: a resonance would fit the harmonics of the loop.
    low = np.array([-np.inf, -np.inf if resonance else 0.0, -np.inf, -np.inf])

    def solved(theta: Array, delay: int) -> tuple[Array, Array]:
        b, a = _block(theta, delay)
        for end, x in zip(ends, inputs):
            runs = lfilter(b, a, x)[:, start:]
            np.subtract(runs, runs.mean(axis=1, keepdims=True), out=rows[:-1, end - runs.shape[1] : end])
        w = _weights(rows)
        return w, w @ rows[:-1] - y

    def left(theta: Array, delay: int) -> Array:
        return solved(theta, delay)[1]

    found = []
    for delay in (0, 1):
        first = min((np.r_[x, 0.0, 0.0] for x in starts), key=lambda x: float(np.sum(left(x, delay) ** 2)))
        found.append(least_squares(left, first, x_scale="jac", bounds=(low, np.inf), args=(delay,)))
    delay = min((0, 1), key=lambda d: found[d].cost)
    theta = found[delay].x
    model = PrandtlIshlinskii(mid, r, solved(theta, delay)[0], *_block(theta, delay))
    constants = [np.mean((record.y - model.simulate(record))[start:]) for record in records]
    return PrandtlIshlinskii(mid, r, model.w, model.b, model.a, float(np.mean(constants)))


def _inputs(u: Array, r: Array) -> Array:
    """Rows u and the plays from rest."""
    rows = np.empty((1 + len(r), len(u)))
    rows[0] = u
    for samples, plays in rivals.stretches(u, r):
        rows[1:, samples] = plays.T
    return rows


def _block(theta: Array, delay: int) -> tuple[Array, Array]:
    """B and A of gain 1 from the logs of frequency [rad per sample] and damping, and two coefficients of B."""
    speed, damping = np.exp(theta[:2])
    root = np.sqrt(damping**2 - 1 + 0j)
    a = np.poly(np.exp(speed * np.array([-damping + root, -damping - root]))).real
    return a.sum() * np.r_[np.zeros(delay), 1 - theta[2] - theta[3], theta[2:]], a


def _weights(rows: Array) -> Array:
    """w >= 0 with the least |w x - y|; the last of the rows is y, the others are x."""
    # `nnls` on the Cholesky factor of the products takes an eighth of its time on the rows. Neighbouring plays are
    # nearly collinear: rounding could make the products indefinite.
    products = rows @ rows.T
    factor = np.linalg.cholesky(products + 1e-12 * np.trace(products) * np.eye(len(rows))).T
    return np.asarray(nnls(factor[:, :-1], factor[:, -1])[0])
