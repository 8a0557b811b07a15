"""Hysteresis operators of branches and those that records determine, by their definitions in numpy and scipy; for
operators.py.

Each function gives z for the input u and the parameters of a model file, from rest.
"""

import numpy as np
from operator_equations import along
from operator_plays import TS, play, plays
from scipy.interpolate import CubicSpline
from scipy.spatial.distance import cdist
from scipy.special import expit


def branch(doc):
    """The spline, and outside it straight lines with the slope from its first to its last knot."""
    knots, z = np.array(doc["u"]), np.array(doc["z"])
    spline, slope = CubicSpline(knots, z), (z[-1] - z[0]) / (knots[-1] - knots[0])
    inside = lambda u: np.clip(u, knots[0], knots[-1])
    return lambda u: spline(inside(u)) + slope * (u - inside(u))


def directions(u, reading):
    """Rising 1, falling -1; while the input is held the last one, or as printed falling; 0 until it first moves."""
    way = np.sign(np.diff(u, prepend=0.0))
    if reading == "printed":
        return np.where(way > 0.0, 1.0, -1.0)
    moved = np.maximum.accumulate(np.where(way != 0.0, np.arange(len(u)), -1))
    return np.where(moved >= 0, way[moved], 0.0)


def on_branches(u, way, doc):
    a, d = branch(doc["ascending"])(u), branch(doc["descending"])(u)
    return np.where(way > 0.0, a, np.where(way < 0.0, d, 0.5 * (a + d)))


def two_branch(u, doc):
    return on_branches(u, directions(u, doc["reading"]), doc)


def reversals(u, least):
    """Samples at which a reversal is known, with the sample at which it was: the last one of the extreme before the
    input came back by more than `least`. Sample -1 is the rest before the first."""
    found, turn, way = [], -1, 0.0
    u = np.concatenate([[0.0], u])
    for t in range(1, len(u)):
        leg = u[turn + 1 : t + 1]
        way = way or np.sign(leg[-1] - leg[0])
        extreme = max(way * leg)
        if extreme - way * u[t] > least:
            turn += np.flatnonzero(way * leg == extreme)[-1]
            found.append((t - 1, turn))
            way = -way
    return found


def periods(u, least):
    """The period [samples] of each sample: of the last two half periods, or the present one if that is longer."""
    found = reversals(u, least)
    for t in range(len(u)):
        turns = [-1] + [turn for known, turn in found if known <= t]
        yield max(turns[-1] - turns[-3], t - turns[-1]) if len(turns) > 2 else np.inf


def rate_scheduled(u, doc):
    way, pairs = directions(u, doc["reading"]), doc["pairs"]
    ends = np.ravel([pair["branches"][side]["u"] for pair in pairs for side in ["ascending", "descending"]])
    octaves = np.log([pair["frequency_hz"] for pair in pairs])
    f = 1.0 / (TS * np.array(list(periods(u, (max(ends) - min(ends)) / 50.0))))
    each = np.array([on_branches(u, way, pair["branches"]) for pair in pairs])
    return [np.interp(np.log(max(f, 1e-9)), octaves, z) for f, z in zip(f, each.T)]


def narx(u, doc):
    """The equations of h_j and d_j, with v in the middle of each path, as the definition says."""
    size = max(abs(doc["range"][0]), abs(doc["range"][1]))
    v = np.clip(u / size, -1.0, 1.0)
    middle = 0.5 * (v + np.concatenate([[0.0], v[:-1]]))
    alike = np.polynomial.Polynomial([1.0, doc["rate_slope"], doc["rate_bend"]])
    by_way = np.polynomial.Polynomial([doc["rise"], doc["rise_slope"], doc["rise_bend"]])
    f, k, g = np.split(doc["weights"], np.cumsum([len(doc["reversible"]), len(doc["moved"])]))

    def part(j, travelled):
        y, out = 0.0, []
        for path, m in zip(np.diff(u, prepend=0.0), middle):
            rate = lambda way: doc["rate"] * max(alike(m) + way * by_way(m), 0.05)
            pull = lambda way: m**j * (way if travelled else 1.0)
            y = along([path], lambda _, y, way: pull(way) - way * rate(way) * y, start=(y,))[0]
            out.append(y)
        return np.array(out)

    z = sum(f * (u if i == 1 else size * v**i) for f, i in zip(f, doc["reversible"]))
    z = z - sum(k * part(j, False) for k, j in zip(k, doc["moved"]))
    return z + sum(g * part(j, True) for g, j in zip(g, doc["travelled"]))


def relative(p, doc):
    low, high = doc["range"]
    return (np.asarray(p) - 0.5 * (low + high)) / (0.5 * (high - low))


def with_input(u, thresholds):
    """One row per sample: u and its plays."""
    return np.column_stack([u, list(plays(u, np.array(thresholds)))])


def neural(u, doc):
    p, n, half = with_input(u, doc["thresholds"]), 1 + len(doc["thresholds"]), 0.5 * np.ptp(doc["range"])
    linear, units = np.split(np.array(doc["weights"]), [n])
    z, rest = p @ linear, relative(0.0, doc)
    for slope, by_input, bias, c in zip(doc["slopes"], doc["inputs"], doc["biases"], units.reshape(-1, n)):
        at_rest = expit(slope * rest + by_input * rest + bias)
        z = z + half * (expit(slope * relative(p, doc) + by_input * relative(u, doc)[:, None] + bias) - at_rest) @ c
    return z


def gaussian_process(u, doc):
    n, half = 1 + len(doc["thresholds"]), 0.5 * np.ptp(doc["range"])
    lengths = np.array([doc["length_input"]] + len(doc["memory"]) * [doc["length_plays"]])
    linear, a = np.split(np.array(doc["weights"]), [n])
    points = np.array(doc["points"]) / lengths
    kernel = lambda x: np.exp(-0.5 * cdist(np.atleast_2d(x) / lengths, points, "sqeuclidean"))
    x, rest = relative(with_input(u, doc["memory"]), doc), relative(np.zeros(len(lengths)), doc)
    return play(u, {**doc, "weights": linear}) + half * (kernel(x) - kernel(rest)) @ a
