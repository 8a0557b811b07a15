"""Writes max_len_seq.json: maximal-length sequences as scipy makes them, for tests/golden_excitation.rs.

For every order from 2 to 31 the first 64 bits, started from all ones and from a register with every third bit set; up to
order 16 also the number of ones in a period and the sum of their positions, which pin the whole period down.
"""

import json
from pathlib import Path

import numpy as np
from scipy.signal import max_len_seq


def bits(sequence):
    return "".join(str(bit) for bit in sequence)


rows = []
for order in range(2, 32):
    start = np.array([bit % 3 == 0 for bit in range(order)])
    row = {
        "order": order,
        "from_ones": bits(max_len_seq(order, length=64)[0]),
        "seed": int(sum(1 << bit for bit in range(order) if start[bit])),
        "from_seed": bits(max_len_seq(order, state=start, length=64)[0]),
    }
    if order <= 16:
        positions = np.flatnonzero(max_len_seq(order)[0])
        row |= {"ones": len(positions), "sum_of_positions": int(positions.sum())}
    rows.append(row)

text = "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"
Path(__file__).with_suffix(".json").write_text(text)
