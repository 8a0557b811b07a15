"""Writes lfilter.json: difference equations as scipy runs them, for tests/golden_linear.rs.

`a` and `b` are scipy's: a[0] y_t = b[0] u_t + b[1] u_{t-1} + ... - a[1] y_{t-1} - ..., with a[0] = 1. For each block the
free run from rest; the same run going on from a past that is not zero (lfiltic); the one-step prediction from a measured
output, which is the sum of two moving averages; and, where the zeros allow it, the inverse, which is lfilter with the
roles of a and b changed.
"""

import json
from pathlib import Path

import numpy as np
from scipy.signal import lfilter, lfiltic

random = np.random.default_rng(20250131)


def polynomial(modulus_and_angle, real=()):
    roots = [r * np.exp(s * 1j * phi) for r, phi in modulus_and_angle for s in (1, -1)] + list(real)
    return np.real(np.poly(roots))


modes = [(0.972, 0.461), (0.93, 1.35), (0.9, 2.4)]
blocks = [
    ("the paper's Table 2", [1.0, -1.7424, 0.9453], [0.0012, -0.0004, -0.0003]),
    ("first order", [1.0, -0.6], [2.0, 0.5]),
    ("no feedback, no memory", [1.0], [33.3]),
    ("moving average", [1.0], [0.4, -0.3, 0.2, 0.7, -0.1]),
    ("feedback only", [1.0, -1.2, 0.7], [3.0]),
    ("two samples late", [1.0, -1.7424, 0.9453], [0.0, 0.0, 3.4, 3.3]),
    ("three samples late, no feedback", [1.0], [0.0, 0.0, 0.0, -1.5]),
    ("more outputs than inputs", [1.0, -0.5, 0.3, -0.2], [1.0, 0.5]),
    ("order 4", polynomial(modes[:2]), 0.01 * polynomial([(0.8, 1.0)], [0.5, -0.7])),
    ("order 6", polynomial(modes), 1e-3 * polynomial([(0.85, 0.9), (0.8, 1.9)], [0.6, -0.95])),
    ("order 6 in nanometres a volt", polynomial(modes), 4e4 * polynomial([(0.7, 2.0)], [0.3])),
    ("a zero outside the circle", [1.0, -1.2, 0.7], [0.5, 1.2, 0.1]),
    ("an integrator", [1.0, -1.0], [0.02, 0.01]),
]

rows = []
for name, a, b in blocks:
    a, b = np.array(a, dtype=float), np.array(b, dtype=float)
    u = np.concatenate([np.sign(random.standard_normal(60)), 30.0 * random.standard_normal(60)])
    y = lfilter(b, a, u)
    measured = y + 0.05 * np.std(y) * random.standard_normal(len(y)) + 0.3 * np.max(np.abs(y))
    past_y, past_u = random.standard_normal(len(a) - 1), random.standard_normal(len(b) - 1)
    resumed, _ = lfilter(b, a, u, zi=lfiltic(b, a, past_y, past_u))
    fed_back = np.concatenate([[0.0], -a[1:]])
    row = {
        "name": name,
        "a": a.tolist(),
        "b": b.tolist(),
        "u": u.tolist(),
        "y": y.tolist(),
        "past_y_newest_first": past_y.tolist(),
        "past_u_newest_first": past_u.tolist(),
        "resumed": resumed.tolist(),
        "measured": measured.tolist(),
        "predicted": (lfilter(b, [1.0], u) + lfilter(fed_back, [1.0], measured)).tolist(),
    }
    if b[0] != 0 and np.all(np.abs(np.roots(b)) < 1):
        row["inverse"] = lfilter(a, b, measured).tolist()
    rows.append(row)

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
