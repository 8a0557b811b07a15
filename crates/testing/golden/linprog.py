"""Writes linprog.json: least absolute deviations by scipy's HiGHS, for tests/golden_linear.rs.

min sum_i t_i subject to -t_i <= y_i - a_i' x <= t_i, by the dual simplex method. Its answer is a vertex: as many rows as
there are unknowns are met exactly. The cost is summed anew over the rows at that vertex, solved for once more, so it does
not carry the solver's tolerances.
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import linprog
from scipy.signal import lfilter

random = np.random.default_rng(20250131)


def regression(n, noise):
    u = np.sign(random.standard_normal(n))
    y = lfilter([1.2, -0.4, -0.3], [1.0, -1.7424, 0.9453], u)
    y = y + noise * random.laplace(size=n)
    t = np.arange(2, n)
    return y[t], np.column_stack([y[t - 1], y[t - 2], u[t], u[t - 1], u[t - 2]])


def line(outlier):
    x = np.arange(20.0)
    y = 2.0 + 3.0 * x + random.standard_normal(20)
    y[7] += outlier
    return y, np.column_stack([np.ones(20), x])


def scaled(problem, of_y, of_columns):
    y, matrix = problem
    return y * of_y, matrix * np.array(of_columns)


problems = [
    ("the paper's regression", regression(250, 0.1)),
    ("the paper's regression with much noise", regression(120, 3.0)),
    ("a line with an outlier", line(1000.0)),
    ("the median", (random.standard_normal(31), np.ones((31, 1)))),
    ("columns in other units", scaled(regression(150, 0.1), 1e-3, [1e-3, 1e-3, 1e3, 1e3, 1e3])),
]

rows = []
for name, (y, matrix) in problems:
    n, d = matrix.shape
    size, size_y = np.abs(matrix).max(axis=0), np.abs(y).max()
    a, b = matrix / size, y / size_y
    constraints = np.block([[a, -np.eye(n)], [-a, -np.eye(n)]])
    price = np.concatenate([np.zeros(d), np.ones(n)])
    free = [(None, None)] * d + [(0, None)] * n
    answer = linprog(price, constraints, np.concatenate([b, -b]), bounds=free, method="highs-ds")
    assert answer.status == 0
    met = np.argsort(np.abs(b - a @ answer.x[:d]))[:d]
    x = np.linalg.solve(a[met], b[met])
    cost = float(np.sum(np.abs(b - a @ x))) * size_y
    assert abs(cost - answer.fun * size_y) <= 1e-9 * cost
    rows.append({"name": name, "dimension": d, "rows": np.column_stack([y, matrix]).ravel().tolist(), "cost": cost})

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
