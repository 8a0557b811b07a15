"""Writes chirp.json: sweeps as scipy makes them, for tests/golden_excitation.rs."""

import json
from pathlib import Path

import numpy as np
from scipy.signal import chirp

ts, n = 5e-4, 200
rows = []
for method in ["linear", "logarithmic"]:
    for start, end in [(5.0, 400.0), (300.0, 10.0)]:
        u = chirp(np.arange(n) * ts, start, n * ts, end, method=method, phi=-90)
        rows.append({"method": method, "start": start, "end": end, "u": u.tolist()})

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
