"""Models of hysteresis as users of SysIdentPy and scipy identify them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import piezoid as pz
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

from .rivals import Array


def nrmse(y: Array, run: Array, start: int = 0, free: bool = False) -> tuple[float, float]:
    """100 rms error / standard deviation and / peak-to-peak, from sample `start` on; `free` removes the mean error."""
    with np.errstate(all="ignore"):
        left, y = (run - y)[start:], y[start:]
        rms = float(np.sqrt(np.mean((left - left.mean() * free) ** 2)))
    rms = rms if np.isfinite(rms) else float("inf")
    return 100 * rms / float(y.std()), 100 * rms / float(np.ptp(y))


@dataclass(frozen=True)
class Setting:
    """Settings of SysIdentPy."""

    inputs: int
    """1: u; 3: u, its step and the sign of the step, as usual for hysteresis."""
    degree: int
    lags: int
    terms: int

    def __str__(self) -> str:
        arguments = "u" if self.inputs == 1 else "u, du, sign du"
        return f"{arguments}; degree {self.degree}, {self.lags} lags, {self.terms} terms"


SETTINGS = [
    *[Setting(1, 1, lags, 2 * lags + 1) for lags in (2, 4, 8, 16)],
    *[Setting(1, 2, lags, terms) for lags in (2, 4, 8) for terms in (8, 16, 30)],
    *[Setting(1, 3, 2, terms) for terms in (8, 16, 30)],
    *[Setting(3, 1, lags, 4 * lags + 1) for lags in (2, 4, 8)],
    *[Setting(3, 2, lags, terms) for lags in (2, 4, 8) for terms in (8, 16, 30)],
    *[Setting(3, 3, 2, terms) for terms in (8, 16, 30)],
]
"""The settings that the search tries."""


class Narx:
    """A polynomial NARX, fitted by forward regression (FROLS) to concatenated records, scaled to their range."""

    def __init__(self, records: Sequence[pz.Record], how: Setting) -> None:
        u, y = (np.concatenate([getattr(r, name) for r in records]) for name in ("u", "y"))
        self._u, self._y = _scale(u), _scale(y)
        self._step = max(float(np.abs(np.diff(r.u)).max()) for r in records)
        self._inputs = how.inputs
        self._core = FROLS(
            ylag=how.lags,
            xlag=how.lags if how.inputs == 1 else [list(range(1, how.lags + 1))] * how.inputs,
            order_selection=False,
            n_terms=how.terms,
            estimator=LeastSquares(),
            basis_function=Polynomial(degree=how.degree),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._core.fit(X=np.concatenate([self._given(r.u) for r in records]), y=_scaled(y, self._y)[:, None])

    def _given(self, u: Array) -> Array:
        step = np.diff(u, prepend=u[0])
        return np.stack([_scaled(u, self._u), step / self._step, np.sign(step)][: self._inputs], axis=1)

    def simulate(self, record: pz.Record) -> Array:
        """The free run from the record's first samples."""
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            run = self._core.predict(X=self._given(record.u), y=_scaled(record.y, self._y)[:, None])
        return np.asarray(self._y[0] + self._y[1] * run[:, 0])


def _scale(x: Array) -> tuple[float, float]:
    return float(x.max() + x.min()) / 2, float(np.ptp(x)) / 2


def _scaled(x: Array, by: tuple[float, float]) -> Array:
    return (x - by[0]) / by[1]


def search(
    train: Sequence[pz.Record], held: pz.Record, settings: Sequence[Setting], start: int, free: bool
) -> Setting:
    """Returns the setting with the best free run on `held`."""
    return min(settings, key=lambda how: nrmse(held.y, Narx(train, how).simulate(held), start, free)[0])


@dataclass(frozen=True)
class BoucWen:
    """gain (u - d h), h' = u' - beta |u'| h - gamma u' |h|, then a resonance, or a lag if none is visible."""

    ts: float
    half: float
    """Scale of u."""
    mid: float
    theta: Array
    """log gain, d, log beta, gamma / beta, log of frequency [Hz] or 1 / lag [1/s], damping."""
    offset: float = 0.0

    def simulate(self, record: pz.Record) -> Array:
        """The free run from rest at the middle of the range."""
        gain, d, beta, ratio, speed, damping = self.theta
        u = (record.u - self.mid) / self.half
        z = np.exp(gain) * (u - d * _steps(u, np.exp(beta), ratio * np.exp(beta)))
        if np.isnan(damping):
            keep = np.exp(-self.ts * np.exp(speed))
            return np.asarray(self.offset + lfilter([1 - keep], [1, -keep], z))
        w = 2 * np.pi * np.exp(speed)
        num, den, _ = cont2discrete(([w**2], [1, 2 * damping * w, w**2]), self.ts)
        return np.asarray(self.offset + lfilter(num[0], den, z))


def _steps(u: Array, beta: float, gamma: float) -> Array:
    """The law by Euler's method, one step per sample."""
    h, out = 0.0, []
    for du in np.diff(u, prepend=0.0).tolist():
        h += du - beta * abs(du) * h - gamma * du * abs(h)
        out.append(h)
    return np.array(out)


def bouc_wen(records: Sequence[pz.Record], resonance: float | None, start: int = 0) -> BoucWen:
    """Least squares fit of free runs from sample `start` on; two start values of beta, one constant per record."""
    half, mid = span(records)
    gain = max(float(np.ptp(r.y)) for r in records) / 2
    # Without a resonance the search starts with a lag of 10 ms, and there is no damping.
    speed, damping = (np.log(resonance), [0.03]) if resonance else (np.log(100.0), [])

    def model(theta: Array, offset: float = 0.0) -> BoucWen:
        return BoucWen(records[0].ts, half, mid, np.append(theta, np.nan)[:6], offset)

    def runs(theta: Array) -> list[Array]:
        with np.errstate(all="ignore"):
            return [(model(theta).simulate(r) - r.y)[start:] for r in records]

    def left(theta: Array) -> Array:
        centred = np.concatenate([run - run.mean() for run in runs(theta)])
        return np.where(np.isfinite(centred), centred, 1e6)

    starts = [np.array([np.log(gain), 0.2, np.log(beta), 0.0, speed, *damping]) for beta in (0.7, 3.0)]
    found = min((least_squares(left, x, x_scale="jac", max_nfev=60) for x in starts), key=lambda f: f.cost)
    return model(found.x, -float(np.mean([run.mean() for run in runs(found.x)])))


def span(records: Sequence[pz.Record]) -> tuple[float, float]:
    """Half the range of the inputs, and its middle."""
    mids = [r.u.max() + r.u.min() for r in records]
    return max(float(np.ptp(r.u)) for r in records) / 2, float(np.mean(mids)) / 2


def peak(record: pz.Record) -> float:
    """Frequency of the largest response in the small-signal record [Hz]."""
    u, y = (np.fft.rfft(x - x.mean()) for x in (record.u, record.y))
    hz = np.fft.rfftfreq(len(record), record.ts)
    return float(hz[1 + np.argmax(np.abs(y[1:]) * (np.abs(u[1:]) > np.abs(u).max() / 10) / np.abs(u[1:]))])

