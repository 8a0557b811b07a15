"""Writes lstsq.json: ARX blocks by scipy's least squares, for tests/golden_linear.rs.

The unknowns are a1.. ana, b0.. and one constant c a record; the offset of a record's output is c / (1 - a1 - ... - ana).
The columns are divided by powers of two near their lengths before scipy sees them, and the solution multiplied back: both
are exact, and without it lstsq takes columns in small units for columns of zeros.
"""

import json
from pathlib import Path

import numpy as np
from scipy.linalg import lstsq
from scipy.signal import lfilter

random = np.random.default_rng(20250131)


def record(a, b, n, offset, noise, scale_u, scale_y):
    u = np.sign(random.standard_normal(n)) + 0.2 * random.standard_normal(n)
    y = lfilter(b, np.concatenate([[1.0], -np.array(a)]), u)
    y = y + noise * np.std(y) * random.standard_normal(n) + offset * np.std(y)
    return u * scale_u, y * scale_y


def solve(records, na, nb, delay):
    history = max(na, nb + delay - 1)
    blocks, right = [], []
    for k, (u, y) in enumerate(records):
        t = np.arange(history, len(u))
        columns = [y[t - i] for i in range(1, na + 1)] + [u[t - delay - i] for i in range(nb)]
        columns += [np.full(len(t), 1.0 if j == k else 0.0) for j in range(len(records))]
        blocks.append(np.column_stack(columns))
        right.append(y[t])
    matrix, right = np.vstack(blocks), np.concatenate(right)
    size = 2.0 ** np.round(np.log2(np.linalg.norm(matrix, axis=0)))
    solution, _, rank, singular = lstsq(matrix / size, right)
    assert rank == matrix.shape[1]
    theta, constants = np.split(solution / size, [na + nb])
    return theta, constants / (1.0 - np.sum(theta[:na])), singular[0] / singular[-1]


beam = ([1.7424, -0.9453], [0.0012, -0.0004, -0.0003])
delayed = ([1.2, -0.7], [0.0, 0.0, 1.0, 0.5])
two_modes = ([1.1, -0.9, 0.6, -0.5], [1.0, 0.5, -0.3, 0.2, 0.4])
cases = [
    # name, block, na, nb, delay, (samples, offset, noise) a record, scale of u, scale of y
    ("the paper's block, one record", beam, 2, 3, 0, [(200, 0.0, 0.05)], 1.0, 1.0),
    ("with an offset", beam, 2, 3, 0, [(200, 5.0, 0.05)], 1.0, 1.0),
    ("three records of their own offsets", two_modes, 4, 5, 0, [(90, 1.0, 0.1), (70, -3.0, 0.1), (80, 20.0, 0.1)], 1.0, 1.0),
    ("a delay", delayed, 2, 2, 2, [(150, -2.0, 0.05)], 1.0, 1.0),
    ("no feedback", ([], [0.5, 0.3, -0.2]), 0, 3, 0, [(100, 1.5, 0.2)], 1.0, 1.0),
    ("a gain", ([], [33.0]), 0, 1, 0, [(50, 0.5, 0.1), (60, -0.5, 0.1)], 1.0, 1.0),
    ("metres and millivolts", beam, 2, 3, 0, [(200, 3.0, 0.05)], 1e3, 1e-3),
    ("picometres and megavolts", two_modes, 4, 5, 0, [(150, 1.0, 0.1), (120, -1.0, 0.1)], 1e-6, 1e6),
    ("lower order than the truth", two_modes, 2, 3, 0, [(200, 0.5, 0.05)], 1.0, 1.0),
]

rows = []
for name, (a, b), na, nb, delay, shapes, scale_u, scale_y in cases:
    records = [record(a, b, n, offset, noise, scale_u, scale_y) for n, offset, noise in shapes]
    theta, offsets, condition = solve(records, na, nb, delay)
    rows.append({
        "name": name,
        "na": na,
        "nb": nb,
        "delay": delay,
        "condition": float(f"{condition:.3g}"),
        "records": [{"u": u.tolist(), "y": y.tolist()} for u, y in records],
        "a": theta[:na].tolist(),
        "b": theta[na:].tolist(),
        "offsets": offsets.tolist(),
    })

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
