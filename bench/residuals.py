#!/usr/bin/env python3
"""What a static curve of the sensor, and a gain for each record, would still explain of the errors on the plants.

usage: residuals.py [--seeds 1 2] [--only p04 p11] [--piezoid FILE] [--data FOLDER]

Reads the models that plants.py left in FOLDER. The curve is y + a y^2 + b y^3 behind the model, with a and b from the
training records by least squares. The table has the ratio of the errors with and without it on each test, and the gain
that each training record alone would prefer. Needs numpy, and a command `piezoid`.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
from plants import SKIPPED, arguments, run

BEGINNINGS = ["rest", "settled", "from-above", "from-below", "motion"]


def column(file: Path, name: str) -> np.ndarray:
    """A column of a CSV file, by the start of its name."""
    with file.open() as lines:
        head = next(line for line in lines if not line.startswith("#")).strip().split(",")
        k = next(k for k, title in enumerate(head) if title.startswith(name))
        return np.genfromtxt(lines, delimiter=",", usecols=k)


def pair(piezoid: str, folder: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The measured and the simulated output about their means, from the beginning that fits best."""
    y = column(folder / name, "y")
    used = np.isfinite(y) & (np.arange(len(y)) >= SKIPPED * len(y))
    found = []
    with tempfile.TemporaryDirectory() as place:
        for begin in BEGINNINGS:
            out = Path(place) / "z.csv"
            words = ["simulate", "--model", "model.json", "--input", name, "--begin", begin, "--quiet", "-o", str(out)]
            if run(piezoid, words, folder)[0] == 0:
                found.append(column(out, "y")[used])
    y = y[used] - y[used].mean()
    best = min((z - z.mean() for z in found), key=lambda z: np.std(y - z))
    return y, best


def main() -> None:
    """Prints the table."""
    given = arguments(__doc__).parse_args()
    print("| plant | error with the curve / without, by test | gains of the training records [%] |")
    print("|---|---|---|")
    for folder in sorted(p.parent for p in given.data.glob("*/model.json")):
        if not any(folder.name.startswith(part) for part in given.only):
            continue
        names = sorted(json.loads((folder / "truth.json").read_text())["records"])
        pairs = {n: pair(given.piezoid, folder, n) for n in names if n.startswith(("train", "test"))}
        train = [both for name, both in pairs.items() if name.startswith("train")]
        size = max(np.abs(z).max() for _, z in train)

        def curve(z: np.ndarray, size: float = size) -> np.ndarray:
            columns = np.column_stack([z, z**2 / size, z**3 / size**2])
            return columns - columns.mean(axis=0)

        rows = np.vstack([curve(z) / np.ptp(y) / np.sqrt(len(y)) for y, z in train])
        errors = np.concatenate([(y - z) / np.ptp(y) / np.sqrt(len(y)) for y, z in train])
        terms = np.linalg.lstsq(rows, errors, rcond=None)[0]
        ratio = {n: np.std(y - z - curve(z) @ terms) / np.std(y - z) for n, (y, z) in pairs.items()}
        tests = ", ".join(f"{n[5:-4]} {r:.2f}" for n, r in ratio.items() if n.startswith("test"))
        gains = ", ".join(f"{100 * ((z @ y) / (z @ z) - 1):.2f}" for y, z in train)
        print(f"| {folder.name} | {tests} | {gains} |", flush=True)


if __name__ == "__main__":
    main()
