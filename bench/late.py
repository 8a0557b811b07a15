#!/usr/bin/env python3
"""Makes all training records of a plant late, and tells whether `piezoid identify` names it.

usage: late.py [--seeds 1] [--only p01 p08] [--piezoid FILE] [--data FOLDER]

The output of every training record comes 0, 5 or 20 samples late, as if a logger had shifted the channels. Each record
loses as many rows. A note that names a late output is right at 5 and 20 samples, and a false alarm at 0. Needs numpy
and a command `piezoid`.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from plants import HERE, arguments, recorded

LATE = (0, 5, 20)
NAMED = ("later than the poles", "after the input")
"""Words of the notes on a late output."""


def noted(piezoid: str, files: list[Path], late: int) -> str:
    """The note of `identify` on records whose output comes late by so many samples; empty without one."""
    with tempfile.TemporaryDirectory() as folder:
        shifted = []
        for file in files:
            header = file.read_text().splitlines()[0]
            t, u, y = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
            rows = np.stack([t[late:], u[late:], y[: len(y) - late]], axis=1)
            shifted.append(Path(folder) / file.name)
            np.savetxt(shifted[-1], rows, delimiter=",", header=header, comments="", fmt="%.17g")
        words = ["--operator", "generalised-prandtl-ishlinskii", "-o", str(Path(folder) / "model.json"), "--quiet"]
        told = subprocess.run([piezoid, "identify", "--data", *shifted, *words], capture_output=True, text=True).stderr
    return next((line for line in told.splitlines() if any(word in line for word in NAMED)), "")


def main() -> None:
    """Prints a row a plant."""
    given = arguments(__doc__).parse_args()
    scripts = sorted((HERE / "plants").glob("p[0-9]*.py"))
    print("| plant | " + " | ".join(f"{late} samples" for late in LATE) + " |\n|---|" + "---|" * len(LATE))
    for script in (one for one in scripts if any(one.stem.startswith(part) for part in given.only)):
        for seed in given.seeds:
            files = sorted(recorded(script.stem, seed, given.data).glob("train_*.csv"))
            if files:
                notes = [noted(given.piezoid, files, late) for late in LATE]
                print(f"| {script.stem}-{seed} | " + " | ".join("named" if note else "-" for note in notes) + " |", flush=True)


if __name__ == "__main__":
    main()
