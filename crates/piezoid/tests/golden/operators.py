"""Writes operators.json: hysteresis operators run by their definitions, for tests/golden_operators.rs.

Each row has an operator with its parameters as a model file holds them, an input, and z. Sums of plays, stops and kernels follow the
definition sample by sample; differential equations are integrated along the straight path from sample to sample by
scipy's solve_ivp, split where their right side has a kink.
"""

import json
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

random = np.random.default_rng(20250301)


def wander(low, high, n):
    """Loops in loops from rest, with steps of all sizes and some samples held."""
    t = np.arange(n)
    u = 0.5 * (low + high) + 0.5 * (high - low) * (0.55 * np.sin(0.31 * t) + 0.45 * np.sin(0.083 * t + 0.5))
    u[20:24] = u[19]
    u[40] = 0.9 * low + 0.1 * high
    return u


def rounded(values):
    return np.round(values, 6)


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


def along(u, rate, kink=None, h=0.0):
    """h after each sample for dh/du = rate(u, h, way); `kink` is where a leg is split."""
    before, out = 0.0, []
    for value in u:
        way, at = np.sign(value - before), before
        while at != value:
            events = None
            if kink is not None:
                events = lambda s, y: kink(y[0], way)
                events.terminal, events.direction = True, 0
            f = lambda s, y: [way * rate(at + way * s, y[0], way)]
            # Off the kink by a hair first, so that it is not met again at once.
            run = solve_ivp(f, (0.0, abs(value - at)), [h], method="DOP853", rtol=1e-13, atol=1e-14, events=events)
            h, moved = run.y[0, -1], run.t[-1]
            at = value if run.status == 0 else at + way * moved
            if run.status == 1:
                hair = min(1e-9, abs(value - at))
                h += way * rate(at, h, way) * hair
                at = value if hair == abs(value - at) else at + way * hair
        before = value
        out.append(h)
    return np.array(out)


def bouc_wen(u, doc):
    beta, gamma = doc["beta"], doc["beta"] * doc["gamma_over_beta"]
    h = along(u, lambda u, h, way: 1.0 - way * beta * h - gamma * abs(h), kink=lambda h, way: h)
    return doc["weights"][0] * u - doc["weights"][1] * h


def dahl(u, doc):
    c, i = doc["breakaway"], doc["exponent"]
    h = along(u, lambda u, h, way: abs(1.0 - way * h / c) ** i)
    return doc["weights"][0] * u - doc["weights"][1] * h


def duhem(u, doc):
    """h' = alpha |u'| (f(u) - h) + u' g(u) itself, with k = f' - g."""
    n, alpha, w = doc["degree"], doc["alpha"], np.array(doc["weights"])
    scale = max(abs(doc["range"][0]), abs(doc["range"][1]))
    f = np.polynomial.Polynomial(np.concatenate([[0.0], w[:n] * scale ** (1.0 - np.arange(1, n + 1))]))
    k = np.polynomial.Polynomial(w[n:] / scale ** np.arange(n))
    g = f.deriv() - k
    return along(u, lambda u, h, way: way * alpha * (f(u) - h) + g(u))


def tellinen(u, doc):
    a, d = (CubicSpline(doc[side]["u"], doc[side]["z"]) for side in ["ascending", "descending"])

    def rate(u, z, way):
        gap = d(u) - a(u)
        return (d(u) - z) / gap * a(u, 1) if way > 0 else (z - a(u)) / gap * d(u, 1)

    # Within the loop, where the equation has no end of steepness.
    return along(u, rate, h=0.5 * (a(0.0) + d(0.0)))


knots = np.linspace(-30.0, 30.0, 7)
loop = lambda way: (knots + 0.1 * knots**2 / 30.0 + way * 3.0 * (1.0 - knots**2 / 900.0)).tolist()
bipolar, unipolar = rounded(wander(-30.0, 30.0, 120)), rounded(wander(0.0, 100.0, 120))
inner = rounded(0.8 * bipolar)
levels = (-30.0 + 10.0 * (np.arange(6) + 0.5)).tolist()
cases = [
    (play, bipolar, {"operator": "prandtl-ishlinskii", "range": [-30.0, 30.0],
                     "thresholds": [0.5, 2.0, 5.0, 11.0, 20.0], "weights": [0.7, 0.1, 0.2, 0.05, 0.1, 0.3]}),
    (play, unipolar, {"operator": "prandtl-ishlinskii", "range": [0.0, 100.0],
                      "thresholds": [float(r) for r in range(1, 40, 2)],
                      "weights": random.uniform(0.0, 0.1, 21).tolist()}),
    (stop, bipolar, {"operator": "stop", "range": [-30.0, 30.0],
                     "thresholds": [0.5, 2.0, 5.0, 11.0, 20.0], "weights": [1.2, 0.1, 0.2, 0.05, 0.1, 0.3]}),
    (kp, bipolar, {"operator": "krasnoselskii-pokrovskii", "range": [-30.0, 30.0], "levels": levels, "ridge": 7.0,
                   "weights": random.uniform(0.0, 1.0, 21).tolist()}),
    (bouc_wen, bipolar, {"operator": "bouc-wen", "range": [-30.0, 30.0], "beta": 0.02, "gamma_over_beta": 0.25,
                         "weights": [1.4, 0.5]}),
    (bouc_wen, unipolar, {"operator": "bouc-wen", "range": [0.0, 100.0], "beta": 0.05, "gamma_over_beta": -0.6,
                          "weights": [1.4, 0.5]}),
    (bouc_wen, bipolar, {"operator": "bouc-wen", "range": [-30.0, 30.0], "beta": 0.1, "gamma_over_beta": 1.7,
                         "weights": [1.4, 0.5]}),
    (dahl, bipolar, {"operator": "dahl", "range": [-30.0, 30.0], "breakaway": 20.0, "exponent": 1.0,
                     "weights": [1.4, 0.5]}),
    (dahl, bipolar, {"operator": "dahl", "range": [-30.0, 30.0], "breakaway": 15.0, "exponent": 2.3,
                     "weights": [1.4, 0.5]}),
    (duhem, bipolar, {"operator": "duhem", "range": [-30.0, 30.0], "degree": 3, "alpha": 0.05,
                      "weights": [1.1, 0.1, -0.1, 0.4, 0.05, -0.1]}),
    (duhem, unipolar, {"operator": "duhem", "range": [0.0, 100.0], "degree": 4, "alpha": 0.2,
                       "weights": [1.1, 0.1, -0.1, 0.2, 0.4, 0.05, -0.1, 0.3]}),
    (tellinen, inner, {"operator": "tellinen", "ascending": {"u": knots.tolist(), "z": loop(-1.0)},
                       "descending": {"u": knots.tolist(), "z": loop(1.0)}}),
]
rows = [
    {"operator": doc.pop("operator"), "params": doc, "u": u.tolist(), "z": np.asarray(model(u, doc)).tolist()}
    for model, u, doc in cases
]
text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
