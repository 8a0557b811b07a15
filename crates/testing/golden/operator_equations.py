"""Hysteresis operators that are differential equations, along the straight path from sample to sample by scipy's
solve_ivp, split where their right side has a kink; for operators.py.

Each function gives z for the input u and the parameters of a model file, from rest.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline


def along(u, rate, kink=None, start=(0.0,)):
    """The first of the states y after each sample, for dy/du = rate(u, y, way); kink(u, y, way) is 0 where a leg is
    split."""
    before, y, out = 0.0, np.array(start), []
    for value in u:
        way, at = np.sign(value - before), before
        while at != value:
            f = lambda s, y: way * np.array(rate(at + way * s, y, way))
            events = None
            if kink is not None:
                events = lambda s, y: kink(at + way * s, y, way)
                events.terminal, events.direction = True, 0
            run = solve_ivp(f, (0.0, abs(value - at)), y, method="DOP853", rtol=1e-13, atol=1e-14, events=events)
            y, moved = run.y[:, -1], run.t[-1]
            at = value if run.status == 0 else at + way * moved
            if run.status == 1:
                # Off the kink by a hair first, so that it is not met again at once.
                hair = min(1e-9, abs(value - at))
                y = y + way * np.array(rate(at, y, way)) * hair
                at = value if hair == abs(value - at) else at + way * hair
        before = value
        out.append(y[0])
    return np.array(out)


def bouc_wen(u, doc):
    beta, gamma = doc["beta"], doc["beta"] * doc["gamma_over_beta"]
    h = along(u, lambda u, h, way: 1.0 - way * beta * h - gamma * abs(h), kink=lambda u, h, way: h[0])
    return doc["weights"][0] * u - doc["weights"][1] * h


def asymmetric_bouc_wen(u, doc):
    beta, gamma = doc["beta"], doc["beta"] * doc["gamma_over_beta"]
    loading = lambda way: (beta + gamma) * (1.0 + way * doc["loading_skew"])
    unloading = lambda way: (beta - gamma) * (1.0 + way * doc["unloading_skew"])
    rate = lambda u, h, way: 1.0 - way * h * (loading(way) if way * h[0] > 0.0 else unloading(way))
    h = along(u, rate, kink=lambda u, h, way: h[0])
    return doc["weights"][0] * u - doc["weights"][1] * h


def baber_noori(u, doc):
    beta, gamma = doc["beta"], doc["beta"] * doc["gamma_over_beta"]

    def rate(u, y, way):
        h, e = y
        nu, eta = (1.0 + doc[loss] * max(e, 0.0) for loss in ["strength_loss", "stiffness_loss"])
        bound = 1.0 / (nu * (beta + gamma))
        pinching = 1.0 - doc["pinch"] * np.exp(-((h / (doc["pinch_width"] * bound)) ** 2))
        return [pinching * (1.0 - nu * (way * beta * h + gamma * abs(h))) / eta, h]

    h = along(u, rate, kink=lambda u, y, way: y[0], start=(0.0, 0.0))
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


def jiles_atherton(u, doc):
    a, k, coupling, w = doc["a"], doc["k"], doc["coupling"], doc["weights"]
    half = 0.5 * (doc["range"][1] - doc["range"][0])

    def anhysteretic(v):
        x = v / a
        # Near 0 the difference of two large numbers; its series instead.
        small = np.abs(x) < 0.05
        safe = np.where(small, 1.0, x)
        return np.where(small, x / 3 - x**3 / 45 + 2 * x**5 / 945 - x**7 / 4725, 1.0 / np.tanh(safe) - 1.0 / safe)

    ahead = lambda u, h, way: way * (anhysteretic(u + coupling * k * h) - h)

    def rate(u, h, way):
        g = ahead(u, h, way)
        return np.maximum(g, 0.0) / (k * np.maximum(1.0 - coupling * g, 0.25))

    h = along(u, rate, kink=lambda u, h, way: ahead(u, h[0], way))
    return w[0] * u + half * (w[1] * anhysteretic(u + coupling * k * h) + w[2] * h)


def tellinen(u, doc):
    a, d = (CubicSpline(doc[side]["u"], doc[side]["z"]) for side in ["ascending", "descending"])

    def rate(u, z, way):
        gap = d(u) - a(u)
        return (d(u) - z) / gap * a(u, 1) if way > 0 else (z - a(u)) / gap * d(u, 1)

    # Within the loop, where the equation has no end of steepness.
    return along(u, rate, start=(0.5 * (a(0.0) + d(0.0)),))
