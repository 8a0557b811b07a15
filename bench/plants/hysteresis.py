"""Operators of hysteresis, without rate. numpy only; nothing of any library."""

import numpy as np


def _segments(v):
    """indices of the turning points of a path without equal neighbours, first and last included"""
    d = np.sign(np.diff(v))
    return np.r_[0, np.flatnonzero(d[1:] != d[:-1]) + 1, len(v) - 1]


def _unique(u):
    keep = np.r_[True, np.diff(u) != 0]
    return u[keep], np.cumsum(keep) - 1


def plays(u, r, value, start=0.0, up=None, down=None, chunk=20000):
    """(generalised) plays; value(S) maps the states (n, len(r)) to z (n,). The past: rest at `start`, from the state
    of rest at 0.
    up, down: edges of the play, up(u) - r while rising, down(u) + r while falling (identity when None)"""
    up = up or (lambda x: x)
    down = down or up
    v, back = _unique(np.asarray(u, float))
    z = np.empty(len(v))
    s = np.zeros(len(r))
    s = np.clip(s, up(start) - r, down(start) + r)
    s = np.clip(s, up(v[0]) - r, down(v[0]) + r)
    z[0] = value(s[None])[0]
    if len(v) > 1:
        turn = _segments(v)
        for a, b in zip(turn[:-1], turn[1:]):
            rising = v[b] > v[a]
            for i in range(a + 1, b + 1, chunk):
                x = v[i : min(i + chunk, b + 1), None]
                S = np.maximum(s, up(x) - r) if rising else np.minimum(s, down(x) + r)
                z[i : i + len(x)] = value(S)
                s = S[-1]
    return z[back]


def everett_table(density, lo, hi, n=500):
    """E(a, b): integral of density(a, b) over the triangle b <= beta <= alpha <= a, on an (n+1)^2 grid, bilinear
    between"""
    h = (hi - lo) / n
    c = lo + h * (np.arange(n) + 0.5)
    A, Bt = np.meshgrid(c, c, indexing="ij")
    p = np.where(A > Bt, density(A, np.minimum(A, Bt)), 0.0) * h * h
    p[np.arange(n), np.arange(n)] = 0.5 * density(c, c) * h * h
    # E(a_i, b_j) = sum over alpha cells < i and beta cells >= j
    t = np.zeros((n + 1, n + 1))
    t[1:, :n] = np.cumsum(np.cumsum(p, 0)[:, ::-1], 1)[:, ::-1]
    t = np.where(np.arange(n + 1)[:, None] >= np.arange(n + 1)[None], t, 0.0)
    t = t + t.T

    def E(a, b):
        x = np.clip((np.asarray(a, float) - lo) / h, 0, n - 1e-9)
        y = np.clip((np.asarray(b, float) - lo) / h, 0, n - 1e-9)
        i = x.astype(int)
        j = y.astype(int)
        x = x - i
        y = y - j
        return (1 - x) * ((1 - y) * t[i, j] + y * t[i, j + 1]) + x * ((1 - y) * t[i + 1, j] + y * t[i + 1, j + 1])

    return E


def preisach(u, E, lo, past=()):
    """Preisach operator by its Everett function; saturated at lo, then the extremes in `past`, then u"""
    v, back = _unique(np.r_[lo, np.asarray(past, float), np.maximum(np.asarray(u, float), lo)])
    z = np.zeros(len(v))
    st = []
    turn = _segments(v) if len(v) > 1 else [0]
    for a, b in zip(turn[:-1], turn[1:]):
        st.append((v[a], z[a]))
        i = a + 1
        rising = v[b] > v[a]
        while True:
            m, zm = st[-1]
            x = v[i : b + 1]
            if len(st) < 2 or (not rising and len(st) == 2):
                k = len(x)
            else:
                M = st[-2][0]
                k = int(np.searchsorted(x, M)) if rising else int(np.searchsorted(-x, -M))
            y = x[:k]
            z[i : i + k] = zm + E(y, np.full(k, m)) if rising else zm - E(np.full(k, m), y)
            i += k
            if i > b:
                break
            st.pop()
            st.pop()
    return z[back][1 + len(past) :]


def loop(hyst, lo, hi, n=4000):
    """stroke, lowest value and width (percent of stroke, at mid voltage) of the closed loop lo..hi of a
    rate-independent operator"""
    c = 0.5 * (1 - np.cos(2 * np.pi * np.arange(3 * n + 1) / n))
    u = lo + (hi - lo) * c
    z = hyst(u)[2 * n :]
    uu = u[2 * n :]
    h = n // 2
    mid = 0.5 * (lo + hi)
    w = np.interp(mid, uu[: h + 1], z[: h + 1]) - np.interp(mid, uu[h:][::-1], z[h:][::-1])
    return np.ptp(z), z.min(), abs(w) / np.ptp(z) * 100
