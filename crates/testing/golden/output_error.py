"""Writes output_error.json: blocks by output error as scipy's least_squares finds them, for tests/golden_dynamics.rs.

The unknowns are a, b and, for each record, the constant in its output and the equations' right-hand sides at the first
samples, which stand for its past: y = lfilter(b, a, u) + lfilter(c, a, impulse) + k, with as many c as the block remembers
samples. All are searched at once, with derivatives by finite differences of three points, from the truth: nothing is
eliminated and no slope is written down.
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

random = np.random.default_rng(20250131)


def free_run(a, b, delay, c, k, u):
    den = np.concatenate([[1.0], -a])
    impulse = np.zeros(len(u))
    impulse[0] = 1.0
    return lfilter(np.concatenate([np.zeros(delay), b]), den, u) + lfilter(c, den, impulse) + k


cases = [
    # name, a, b, delay, (samples, weight, offset) a record, noise
    ("a beam, two records", [1.7424, -0.9453], [0.5, 1.2, 0.4], 0, [(220, 1.0, 5.0), (180, 1.0, -3.0)], 0.3),
    ("two samples late, weighted", [1.2, -0.7], [1.0, 0.5], 2, [(150, 2.0, 1.0), (160, 0.25, 0.0)], 0.1),
    ("two modes", [1.1, -0.9, 0.6, -0.5], [1.0, 0.5, -0.3, 0.2], 1, [(400, 1.0, 2.0)], 0.2),
    ("more b than a", [0.6], [1.0, 0.5, -0.3, 0.2], 0, [(200, 1.0, 2.0)], 0.2),
]

rows = []
for name, a, b, delay, shapes, noise in cases:
    a, b = np.array(a), np.array(b)
    m = max(len(a), len(b) + delay - 1)
    records = []
    for n, weight, offset in shapes:
        u = np.sign(random.standard_normal(n)) + 0.3 * random.standard_normal(n)
        y = free_run(a, b, delay, random.standard_normal(m), offset, u) + noise * random.standard_normal(n)
        records.append((u, y, weight))

    def residuals(x):
        theta_a, theta_b, rest = np.split(x, [len(a), len(a) + len(b)])
        initial = rest.reshape(len(records), m + 1)
        parts = [
            np.sqrt(weight) * (y - free_run(theta_a, theta_b, delay, past[:-1], past[-1], u))
            for (u, y, weight), past in zip(records, initial)
        ]
        return np.concatenate(parts)

    start = np.concatenate([a, b, np.zeros(len(records) * (m + 1))])
    found = least_squares(residuals, start, jac="3-point", method="lm", x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    rest = found.x[len(a) + len(b) :].reshape(len(records), m + 1)
    covariance = np.linalg.inv(found.jac.T @ found.jac)[: len(a) + len(b), : len(a) + len(b)]
    rows.append({
        "name": name,
        "delay": delay,
        "records": [{"u": u.tolist(), "y": y.tolist(), "weight": weight} for u, y, weight in records],
        "a": found.x[: len(a)].tolist(),
        "b": found.x[len(a) : len(a) + len(b)].tolist(),
        "offsets": rest[:, -1].tolist(),
        "cost": 2.0 * found.cost,
        "inverse_of_jj": np.diag(covariance).tolist(),
    })

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
