"""Writes cubic_spline.json: not-a-knot splines as scipy makes them, for tests/golden_spline.rs.

Each curve is read at its knots, between them, and beyond both ends by up to five times the outermost interval. (Much
further, scipy itself is off: 1e-8 at ten thousand times, against rational arithmetic.)
"""

import json
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

random = np.random.default_rng(20250131)


def uneven(n, ratio):
    """n knots whose intervals differ by up to `ratio`, which the first two of them do, in random order otherwise."""
    h = ratio ** random.uniform(-1.0, 0.0, n - 1)
    if n > 2:
        h[0], h[1] = 1.0, 1.0 / ratio
    return -30.0 + np.concatenate([[0.0], np.cumsum(h)]) * 60.0 / np.sum(h)


rows = []
for n in [2, 3, 4, 5, 20]:
    grids = [
        ("even", np.linspace(-30.0, 30.0, n)),
        ("uneven", uneven(n, 10.0)),
        ("very uneven", uneven(n, 1e4)),
        ("rising by powers of two", 2.0 ** np.arange(n)),
    ]
    for grid, x in grids:
        for curve, y in [("branch", 33.3 * x + 4.0 * np.sin(0.09 * x) - 800.0), ("noise", random.standard_normal(n))]:
            spline = CubicSpline(x, y, bc_type="not-a-knot")
            middles = x[:-1] + np.diff(x) * random.uniform(0.05, 0.95, n - 1)
            beyond = np.array([0.1, 1.0, 5.0])
            at = np.concatenate([x, middles, x[0] - beyond * (x[1] - x[0]), x[-1] + beyond * (x[-1] - x[-2])])
            rows.append({
                "name": f"{n} knots, {grid}, {curve}",
                "x": x.tolist(),
                "y": y.tolist(),
                "at": at.tolist(),
                "value": spline(at).tolist(),
            })

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
