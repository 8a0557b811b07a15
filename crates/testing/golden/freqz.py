"""Writes freqz.json: frequency responses, poles and zeros as scipy and numpy see them, for tests/golden_linear.rs.

`a` and `b` are scipy's (a[0] = 1). The roots are those of numpy.roots, brought from its 1e-10 or so to the last digit by
Newton's method in long double. Poles are listed as an engineer reads them: one of each conjugate pair, s = ln(z) / ts, by
rising natural frequency |s| / 2 pi; zeros by rising modulus.
"""

import json
from pathlib import Path

import numpy as np
from scipy.signal import freqz


def polynomial(modulus_and_angle, real=()):
    roots = [r * np.exp(s * 1j * phi) for r, phi in modulus_and_angle for s in (1, -1)] + list(real)
    return np.real(np.poly(roots))


def roots(c):
    found = np.roots(c)
    exact, slope = np.array(c, dtype=np.longdouble), np.polyder(np.array(c, dtype=np.longdouble))
    polished = found.astype(np.clongdouble)
    for _ in range(4):
        polished = polished - np.polyval(exact, polished) / np.polyval(slope, polished)
    assert np.all(np.abs(polished - found) <= 1e-9 * np.abs(found))
    return polished


def pairs(z):
    return [[float(root.real), float(root.imag)] for root in z]


blocks = [
    ("the paper's Table 2", 5e-4, [1.0, -1.7424, 0.9453], [0.0012, -0.0004, -0.0003]),
    ("first order", 1e-3, [1.0, -0.6], [2.0, 0.5]),
    ("moving average", 1.0, [1.0], [0.4, -0.3, 0.2, 0.7, -0.1]),
    ("two samples late", 5e-4, [1.0, -1.7424, 0.9453], [0.0, 0.0, 3.4, 3.3]),
    ("negative gain", 5e-4, [1.0, -1.2, 0.7], [-0.5, -0.1]),
    ("real poles of either sign", 2e-3, polynomial([], [0.9, -0.4]), [1.0, 1.5]),
    ("unstable", 1e-3, polynomial([(1.1, 0.8)]), [1.0, -2.0, 0.3]),
    ("order 4", 5e-4, polynomial([(0.972, 0.461), (0.93, 1.35)]), 0.01 * polynomial([(0.8, 1.0)], [0.5, -0.7])),
    ("order 6", 1e-4, polynomial([(0.99, 0.1), (0.95, 1.35), (0.9, 2.4)]), 7.0 * polynomial([(0.85, 0.9), (1.4, 1.9)], [0.6, -2.5])),
    ("only even powers", 5e-4, [1.0, 0.0, -0.1, 0.0, 0.6], [1.0, 0.0, 0.0, -0.5]),
]

rows = []
for name, ts, a, b in blocks:
    hz = np.concatenate([[0.0], np.geomspace(1e-3, 0.499, 30)]) / ts
    _, h = freqz(b, a, worN=hz, fs=1.0 / ts)
    poles = [z for z in roots(a) if z.imag >= 0]
    s = np.sort_complex(np.log(np.array(poles, dtype=np.clongdouble)) / np.longdouble(ts))
    s = s[np.argsort(np.abs(s), kind="stable")]
    zeros = roots(np.trim_zeros(b, "f"))
    zeros = sorted(zeros, key=lambda z: (round(float(abs(z)), 12), float(z.imag)))
    rows.append({
        "name": name,
        "ts": ts,
        "a": list(map(float, a)),
        "b": list(map(float, b)),
        "hz": hz.tolist(),
        "gain": np.abs(h).tolist(),
        "phase": np.angle(h).tolist(),
        "pole_hz": (np.abs(s) / (2 * np.pi)).astype(float).tolist(),
        "pole_damping": (-s.real / np.abs(s)).astype(float).tolist(),
        "zeros": pairs(zeros),
    })

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
