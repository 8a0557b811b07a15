"""Inputs: functions of t (s), or arrays at fs."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfilt


def tri(t, f):
    """triangle -1..1, from -1 upward at t = 0"""
    x = np.mod(f * t, 1.0)
    return 1 - 4 * np.abs(x - 0.5)


def ramp01(t, t0, t1):
    return np.clip((t - t0) / (t1 - t0), 0, 1)


def multisine(t, period, freqs, rng, amp=None):
    """random phases; each frequency is rounded to a line of the period; scaled to peak 1 over one period of 4096*4
    points"""
    k = np.unique(np.round(np.asarray(freqs) * period).astype(int))
    k = k[k > 0]
    a = np.ones(len(k)) if amp is None else amp(k / period)
    ph = rng.uniform(0, 2 * np.pi, len(k))

    def x(tt):
        y = np.zeros(len(tt))
        for kk, aa, p in zip(k, a, ph):
            y += aa * np.cos(2 * np.pi * kk / period * tt + p)
        return y

    top = np.abs(x(np.arange(16384) * period / 16384)).max()
    return x(t) / top


def random_walk(rng, n, smooth, taper=0):
    x = np.cumsum(rng.standard_normal(n))
    x -= np.linspace(x[0], x[-1], n)
    b = np.ones(smooth) / smooth
    x = lfilter(b, 1, lfilter(b, 1, x))
    return x / np.abs(x).max()


def noise_band(rng, n, fs, f, order=4):
    x = sosfilt(butter(order, f, fs=fs, output="sos"), rng.standard_normal(n + 2000))[2000:]
    return x / np.abs(x).max()


def zigzag(rng, seconds, fs, lo, hi, leg=(0.01, 0.1), start=0.0, hold=0.0, smooth=True, min_swing=0.03):
    """random turning points joined by straight or cosine legs of random duration; with probability `hold` a pause
    follows"""
    n = int(seconds * fs)
    out = []
    v = start
    m = 0
    while m < n:
        w = rng.uniform(lo, hi) if rng.random() < 0.5 else np.clip(v + rng.normal(0, 0.2) * (hi - lo), lo, hi)
        if abs(w - v) < min_swing * (hi - lo):
            continue
        k = max(2, int(np.exp(rng.uniform(np.log(leg[0]), np.log(leg[1]))) * fs))
        x = np.arange(1, k + 1) / k
        out.append(v + (w - v) * (0.5 - 0.5 * np.cos(np.pi * x) if smooth else x))
        m += k
        v = w
        if rng.random() < hold:
            k = int(rng.uniform(0.3, 1.5) * leg[1] * fs)
            out.append(np.full(k, v))
            m += k
    return np.concatenate(out)[:n]


def steps(rng, seconds, fs, lo, hi, hold=(0.005, 0.1)):
    n = int(seconds * fs)
    out = []
    m = 0
    while m < n:
        k = max(1, int(np.exp(rng.uniform(*np.log(hold))) * fs))
        out.append(np.full(k, rng.uniform(lo, hi)))
        m += k
    return np.concatenate(out)[:n]


def prbs(n, bits=11, clock=1):
    reg = [1] * bits
    tap = {7: 6, 9: 5, 10: 7, 11: 9, 12: None}[bits]
    seq = []
    for _ in range(2**bits - 1):
        seq.append(reg[-1])
        reg = [reg[-1] ^ reg[tap - 1]] + reg[:-1]
    s = np.repeat(2.0 * np.array(seq) - 1, clock)
    return np.tile(s, n // len(s) + 1)[:n]
