"""Writes modes.json: modes under a held input that comes late, as scipy runs them, for tests/golden_dynamics.rs.

G(s) = r + sum k w^2 / (s^2 + 2 zeta w s + w^2), discretised by cont2discrete at a twentieth of the sampling period, with
the input repeated twenty times and shifted by a whole number of these steps: a delay of any twentieth of a sample without
a formula for it. The output is read just before the next input acts on it.
"""

import json
from pathlib import Path

import numpy as np
from scipy.signal import cont2discrete, lfilter

random = np.random.default_rng(20250131)
ts, fine = 5e-4, 20

cases = [
    # name, (Hz, damping, k) a mode, r, delay in twentieths of a sample
    ("one mode", [(166.3, 0.03, 27.0)], 3.0, 0),
    ("one mode, a fifth of a sample late", [(166.3, 0.03, 27.0)], 3.0, 4),
    ("two modes, late by more than a sample", [(166.3, 0.03, 27.0), (640.0, 0.06, 2.0)], 1.0, 33),
    ("logged after the input acted", [(146.7, 0.061, 25.0)], 0.0, -20),
    ("above half the sampling rate", [(166.3, 0.03, 27.0), (1042.0, 0.03, 2.4)], 0.9, 7),
]

rows = []
for name, modes, r, delay in cases:
    u = np.sign(random.standard_normal(900))
    held = np.repeat(u, fine)
    # Sample t is read at t fine - 1 + 1 steps: the input of step t fine has not acted yet.
    input = np.concatenate([np.zeros(fine), held, np.zeros(2 * fine)])
    y = r * np.concatenate([[0.0], input[:-1]])
    for hz, zeta, k in modes:
        w = 2 * np.pi * hz
        num, den, _ = cont2discrete(([k * w * w], [1.0, 2 * zeta * w, w * w]), ts / fine, method="zoh")
        y = y + lfilter(num.ravel(), den, input)
    at = fine + np.arange(len(u)) * fine - delay
    rows.append({
        "name": name,
        "ts": ts,
        "u": u.tolist(),
        "y": y[at].tolist(),
        "hz": [m[0] for m in modes],
        "damping": [m[1] for m in modes],
        "share": [m[2] / (r + sum(m[2] for m in modes)) for m in modes],
        "gain": r + sum(m[2] for m in modes),
        "delay": delay * ts / fine,
    })

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
