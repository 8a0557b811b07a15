"""Linear parts, exact for an input that is held over the fine step: lags, modes, creep, delay."""

import numpy as np
from scipy.signal import cont2discrete, lfilter


def _steady(b, a, z):
    b, a = np.atleast_1d(b), np.atleast_1d(a)
    return lfilter(b, a, z - z[0]) + z[0] * b.sum() / a.sum()


def lag(z, tau, T):
    e = -np.expm1(-T / tau)
    return z[0] + lfilter([e], [1, e - 1], z - z[0])


def lag2(z, f, zeta, T):
    """second-order low pass or mode of unit static gain; started at rest"""
    w = 2 * np.pi * f
    b, a, _ = cont2discrete(([w * w], [1, 2 * zeta * w, w * w]), T)
    return z[0] + lfilter(b[0], a, z - z[0])


def modes(z, table, T, residual=0.0):
    """sum of share * mode + residual * z; table: (f_Hz, zeta, share)"""
    y = residual * z
    for f, zeta, share in table:
        y = y + share * lag2(z, f, zeta, T)
    return y


def creep_log(z, g, T, lo=1e-3, hi=1e2, n=40):
    """g of the step more per decade of time, from lo to hi seconds"""
    taus = np.logspace(np.log10(lo), np.log10(hi), n)
    gap = np.log10(taus[1] / taus[0])
    return z + g * gap * sum(lag(z, t, T) for t in taus)


def creep_lags(z, taus, gains, T):
    return z + sum(g * lag(z, t, T) for t, g in zip(taus, gains))


def delay(z, n):
    return np.r_[np.full(n, z[0]), z[:-n]] if n else z
