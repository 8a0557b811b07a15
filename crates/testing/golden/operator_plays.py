"""Hysteresis operators of plays, stops, sliders, kernels and relays by their definitions, sample by sample; for
operators.py.

Each function gives z for the input u and the parameters of a model file, from rest.
"""

import numpy as np
from scipy.integrate import solve_ivp

TS = 5e-4  # sampling period of the rows [s]


def plays(u, thresholds):
    p = np.zeros(len(thresholds))
    for value in u:
        p = np.maximum(value - thresholds, np.minimum(value + thresholds, p))
        yield p.copy()


def play(u, doc):
    r, w = np.array(doc["thresholds"]), np.array(doc["weights"])
    return [w[0] * value + w[1:] @ p for value, p in zip(u, plays(u, r))]


def stop(u, doc):
    """Stops by their own rule: s <- min(r, max(-r, s + change of u))."""
    r, w = np.array(doc["thresholds"]), np.array(doc["weights"])
    s, before, z = np.zeros(len(r)), 0.0, []
    for value in u:
        s = np.clip(s + value - before, -r, r)
        before = value
        z.append(w[0] * value - w[1:] @ s)
    return z


def generalised_play(u, doc):
    r, w, (low, high) = np.array(doc["thresholds"]), np.array(doc["weights"]), doc["range"]
    half, middle, n = 0.5 * (high - low), 0.5 * (low + high), 1 + len(r)

    def envelope(side):
        # The slope of g is 1 outside the range: there the two terms are constant.
        bend = np.polynomial.Polynomial([doc[f"{side}_quadratic"], doc[f"{side}_cubic"]])
        v = lambda x: np.clip((x - middle) / half, -1.0, 1.0)
        bent = lambda x: x + half * (1.0 - v(x) ** 2) * bend(v(x))
        return bent(u) - bent(0.0)

    p, z = np.zeros(len(r)), []
    for value, ascending, descending in zip(u, envelope("ascending"), envelope("descending")):
        p = np.maximum(ascending - r, np.minimum(descending + r, p))
        zones = [max(value - d, 0.0) if d > 0.0 else min(value - d, 0.0) for d in doc["dead_zones"]]
        z.append(w[0] * value + w[1:n] @ p + w[n:] @ zones)
    return z


def rate_play(u, doc):
    w, p, before, z = np.array(doc["weights"]), np.zeros(len(doc["thresholds"])), 0.0, []
    for value in u:
        r = np.array(doc["thresholds"]) + doc["growth"] * np.log(1.0 + abs(value - before) / TS / doc["rate"])
        p = np.maximum(value - r, np.minimum(value + r, p))
        before = value
        z.append(w[0] * value + w[1:] @ p)
    return z


def slider(u, r, doc):
    """One slider, as a machine of two modes in time; sliding is integrated."""
    e, before, sliding = 0.0, 0.0, 0.0
    for value in u:
        speed, left = (value - before) / TS, TS
        before, way = value, np.sign(speed)
        b = r * (1.0 + doc["rise"] * (1.0 - np.exp(-abs(speed) / doc["rate"])))
        if sliding != way:
            sliding = 0.0
        if way != 0.0 and sliding == 0.0:
            stuck = max((b - way * e) / abs(speed), 0.0)
            e, left = e + speed * min(stuck, left), left - min(stuck, left)
            sliding = way if left > 0.0 else 0.0
        if sliding != 0.0:
            run = solve_ivp(lambda t, e: (b * way - e) / doc["attraction"], (0.0, left), [e], rtol=1e-12, atol=1e-12)
            e = run.y[0, -1]
        yield e


def maxwell_slip(u, doc):
    e = [list(slider(u, r, doc)) for r in doc["thresholds"]]
    return doc["weights"][0] * u - np.array(doc["weights"][1:]) @ e


def kp(u, doc):
    levels, ridge, w = doc["levels"], doc["ridge"], doc["weights"]
    step = lambda v: min(max(0.5 + v / ridge, 0.0), 1.0)
    pairs = [(i, j) for j in range(len(levels)) for i in range(j + 1)]
    move = lambda k, v, i, j: max(step(v - levels[j]), min(step(v - levels[i]), k))
    rest = [move(0.5, 0.0, i, j) for i, j in pairs]
    k, z = list(rest), []
    for value in u:
        k = [move(kk, value, i, j) for kk, (i, j) in zip(k, pairs)]
        z.append(sum(ww * (kk - rr) for ww, kk, rr in zip(w, k, rest)))
    return z


RELAY = 0.125  # side of a square of relays that switch together: u and the levels are multiples [input unit]


def reversible(u, doc):
    """The curve through its values at the levels, which continues outside with the outermost slopes."""
    levels = np.array(doc["levels"])
    slopes = np.array(doc["reversible"]) / np.diff(levels)
    ends = np.concatenate([[-1e3], levels, [1e3]])
    rises = np.concatenate([slopes[:1], slopes, slopes[-1:]]) * np.diff(ends)
    curve = lambda x: np.interp(x, ends, np.concatenate([[0.0], np.cumsum(rises)]))
    return doc["slope"] * u + curve(u) - curve(0.0)


def preisach(u, doc):
    """Every relay by itself. Those of a small square of the plane switch together, because no input ends inside one."""
    levels, n = np.array(doc["levels"]), int(2 * 40 / RELAY)
    low = RELAY * np.arange(n) - 40.0
    cell = np.searchsorted(levels, low, side="right") - 1
    i, j = cell[:, None], cell[None, :]
    alpha, beta = low[:, None], low[None, :]
    within = (i >= 0) & (j >= 0) & (i < len(levels) - 1) & (j < len(levels) - 1) & (alpha >= beta)
    i, j = np.where(within, i, 0), np.where(within, j, 0)
    sides = np.diff(levels)
    # A square or a cell on the diagonal is a triangle.
    share = RELAY**2 * np.where(alpha == beta, 0.5, 1.0) / (sides[i] * sides[j] * np.where(i == j, 0.5, 1.0))
    weight = np.where(within, np.array(doc["weights"])[i * (i + 1) // 2 + j] * share, 0.0)
    # Demagnetised: the line alpha + beta = 0 halves the squares on it.
    middle = alpha + beta + RELAY
    up = np.where(middle < 0.0, 1.0, np.where(middle > 0.0, 0.0, 0.5))
    rest, z = np.sum(weight * up), []
    for value in u:
        up[low + RELAY <= value, :] = 1.0
        up[:, low >= value] = 0.0
        z.append(np.sum(weight * up) - rest)
    return z + reversible(u, doc)


def behind_a_driver(u, doc):
    """Plays behind v' = (u - v) / lag, |v'| <= slew; z is the mean over the sample by the trapezoidal rule."""
    lag, slew, v, through = doc["driver"]["lag_s"], doc["driver"]["slew"], 0.0, []
    for value in u:
        at = TS * np.arange(1, 5) / 4.0
        rate = lambda t, y, value: np.clip((value - y) / lag, -slew, slew)
        run = solve_ivp(rate, (0.0, TS), [v], method="DOP853", t_eval=at, rtol=1e-13, atol=1e-13, max_step=TS / 40.0,
                        args=(value,))
        v = run.y[0, -1]
        through.extend(run.y[0])
    z = np.concatenate([[0.0], play(np.array(through), doc)])
    return 0.125 * (z[0:-4:4] + 2.0 * (z[1:-3:4] + z[2:-2:4] + z[3:-1:4]) + z[4::4])
