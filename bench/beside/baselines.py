"""Other methods for `pz.compare`, as their users set them up: functions f(train) -> g, g.simulate(u).

Each tries a few settings. It is fitted to the first three quarters of each training record and runs free over the whole
record; the setting with the smallest error on the last quarter is fitted to all of the training records. No setting sees
other data. The free runs begin at the mean of the first outputs of the training records.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import piezoid as pz
from scipy.optimize import least_squares
from scipy.signal import lfilter
from sklearn.neural_network import MLPRegressor

from . import fits
from .rivals import Array

TRAINED = 0.75
"""Share of a training record to which a setting is fitted."""

MOST_STEPS = 40_000
"""Samples of the regressions: the network takes every n-th sample of longer records."""


class Searched:
    """The best of some settings, fitted to all training records."""

    def __init__(self, fit: Callable[[list[pz.Record], Any], Any], settings: Sequence[Any], train: list[pz.Record]) -> None:
        parts = [pz.Record(r.u[: _cut(r)], r.y[: _cut(r)], r.ts) for r in train]
        best = settings[0]
        if len(settings) > 1:
            best = min(settings, key=lambda setting: _error(fit, parts, train, setting))
        self.setting = best
        self.model = fit(train, best)
        self.parameters: int = self.model.parameters

    def simulate(self, u: Array) -> Array:
        """The free run."""
        return np.asarray(self.model.simulate(u))


def _cut(record: pz.Record) -> int:
    return round(TRAINED * len(record))


def _error(fit: Callable[[list[pz.Record], Any], Any], parts: list[pz.Record], train: list[pz.Record], setting: Any) -> float:
    """The mean over the records of the squared error on the last quarter over the squared peak-to-peak."""
    model = fit(parts, setting)
    errors = []
    for record in train:
        with np.errstate(all="ignore"):
            left = (model.simulate(record.u) - record.y)[_cut(record) :]
            errors.append(np.mean((left - left.mean()) ** 2) / np.ptp(record.y) ** 2)
    error = float(np.mean(errors))
    return error if np.isfinite(error) else float("inf")


def _start(train: list[pz.Record]) -> float:
    return float(np.mean([record.y[0] for record in train]))


class Polynomial:
    """A polynomial NARX of SysIdentPy: forward regression with orthogonal least squares (FROLS)."""

    settings = [
        *[fits.Setting(1, 1, lags, 2 * lags + 1) for lags in (2, 4, 8)],
        *[fits.Setting(1, 2, lags, terms) for lags, terms in ((2, 8), (2, 16), (4, 16), (4, 30))],
        *[fits.Setting(3, 1, lags, 4 * lags + 1) for lags in (2, 4)],
        *[fits.Setting(3, 2, lags, terms) for lags, terms in ((2, 8), (2, 16), (2, 30))],
        *[fits.Setting(3, 3, 2, terms) for terms in (8, 16)],
    ]

    def __init__(self, train: list[pz.Record], setting: fits.Setting) -> None:
        self.narx, self.start, self.ts = fits.Narx(train, setting), _start(train), train[0].ts
        self.parameters = setting.terms

    def simulate(self, u: Array) -> Array:
        # The tool takes the first outputs from a record: here they are the mean start.
        return np.asarray(self.narx.simulate(pz.Record(u, np.full(len(u), self.start), self.ts)))


class Network:
    """A NARX network of scikit-learn: one step ahead from lags of y and u, then in free run on its own outputs."""

    settings = [(lags, width) for lags in (2, 4, 8) for width in (8, 24)]

    def __init__(self, train: list[pz.Record], setting: tuple[int, int]) -> None:
        self.lags, width = setting
        u, y = (np.concatenate([getattr(r, name) for r in train]) for name in ("u", "y"))
        self.u, self.y, self.start = (u.mean(), u.std()), (y.mean(), y.std()), _start(train)
        step = max(1, len(u) // MOST_STEPS)
        rows = [self._rows((r.u - self.u[0]) / self.u[1], (r.y - self.y[0]) / self.y[1]) for r in train]
        x, target = np.concatenate([x for x, _ in rows])[::step], np.concatenate([t for _, t in rows])[::step]
        network = MLPRegressor(
            hidden_layer_sizes=(width,), activation="tanh", solver="lbfgs", alpha=1e-6, max_iter=500, random_state=0
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            network.fit(x, target)
        self.weights, self.biases = network.coefs_, network.intercepts_
        self.parameters = sum(w.size for w in [*self.weights, *self.biases])

    def _rows(self, u: Array, y: Array) -> tuple[Array, Array]:
        """Regressors y(t-1) ... y(t-n), u(t) ... u(t-n), and y(t)."""
        n, t = self.lags, np.arange(self.lags, len(u))
        columns = [y[t - k] for k in range(1, n + 1)] + [u[t - k] for k in range(n + 1)]
        return np.stack(columns, axis=1), y[n:]

    def simulate(self, u: Array) -> Array:
        n, scaled = self.lags, (u - self.u[0]) / self.u[1]
        y = np.full(len(u), (self.start - self.y[0]) / self.y[1])
        (hidden, out), (b1, b2) = self.weights, self.biases
        # What the inputs add to the hidden layer is known in advance.
        of_u = np.stack([np.r_[np.full(k, scaled[0]), scaled[: len(u) - k]] for k in range(n + 1)], axis=1) @ hidden[n:]
        of_y, out = np.ascontiguousarray(hidden[:n]), out[:, 0]
        for t in range(n, len(u)):
            y[t] = np.tanh(y[t - n : t][::-1] @ of_y + of_u[t] + b1) @ out + b2[0]
        return np.asarray(self.y[0] + self.y[1] * y)


class Linear:
    """A linear output-error model of order n with a constant, refined by `scipy.optimize.least_squares`."""

    settings = [1, 2, 3, 4]

    def __init__(self, train: list[pz.Record], order: int) -> None:
        offset = _start(train)
        scale = [(1 / np.ptp(r.y) / np.sqrt(len(r))) for r in train]

        def rows(r: pz.Record) -> tuple[Array, Array]:
            t, y = np.arange(order, len(r)), r.y - offset
            columns = [y[t - k] for k in range(1, order + 1)] + [r.u[t - k] for k in range(order + 1)]
            return np.stack([*columns, np.ones(len(t))], axis=1), y[order:]

        weighted = [(s * x, s * y) for s, (x, y) in zip(scale, map(rows, train))]
        x, y = np.concatenate([x for x, _ in weighted]), np.concatenate([y for _, y in weighted])
        first = np.linalg.lstsq(x, y, rcond=None)[0]
        gain = 1 - first[:order].sum()
        start = np.r_[first[:-1], offset + first[-1] / gain]
        size = np.abs(start) + 1e-6 * np.abs(start).max()

        def errors(theta: Array) -> Array:
            with np.errstate(all="ignore"):
                left = [s * (_run(theta * size, order, r.u) - r.y) for s, r in zip(scale, train)]
            return np.nan_to_num(np.clip(np.concatenate(left), -1e6, 1e6), nan=1e6)

        self.order = order
        self.theta = least_squares(errors, start / size, max_nfev=60).x * size
        self.parameters = len(self.theta)

    def simulate(self, u: Array) -> Array:
        return _run(self.theta, self.order, u)


def _run(theta: Array, order: int, u: Array) -> Array:
    """The response, settled at the mean of the input."""
    a, b = np.r_[1.0, -theta[:order]], theta[order : 2 * order + 1]
    gain = b.sum() / a.sum() if a.sum() else 0.0
    return np.asarray(lfilter(b, a, u - u[0]) + gain * u[0] + theta[-1])


def polynomial(train: list[pz.Record]) -> Searched:
    """The best polynomial NARX."""
    return Searched(Polynomial, Polynomial.settings, train)


def network(train: list[pz.Record]) -> Searched:
    """The best NARX network."""
    return Searched(Network, Network.settings, train)


def linear(train: list[pz.Record]) -> Searched:
    """The best linear output-error model."""
    return Searched(Linear, Linear.settings, train)


METHODS: dict[str, Callable[[list[pz.Record]], Searched]] = {
    "SysIdentPy, polynomial NARX": polynomial,
    "scikit-learn, NARX network": network,
    "scipy, linear output error": linear,
}
