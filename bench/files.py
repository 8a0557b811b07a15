#!/usr/bin/env python3
"""Reads files as other programs write them (bench/files), and counts how many are read right without an option.

usage: files.py [--set first|second|third] [--data FOLDER] [--only csv] [--all]

The first set was there while the readers were written; the second and the third were written by people who had not
seen them, and read for the first time after that.

A file is read right if u and y are those of truth.json to the bit, and the sampling period but for rounding; it may be
refused if truth.json says that it cannot be known what is what. Each file that fails is listed with its message, cut to
one line. Needs what bench/files/make.py needs (scipy, h5py, npTDMS, pandas, pyarrow, openpyxl, hdf5storage, asammdf),
and piezoid.
"""

import argparse
import collections
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import piezoid as pz

HERE = Path(__file__).resolve().parent
TS = 1e-9
"""Relative difference of sampling periods that is rounding of the times in a file."""


def numbers(values: list[float | None]) -> np.ndarray:
    """A channel, with NaN for a cell without a number."""
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def outcome(folder: Path, truth: dict) -> tuple[str, str]:
    """What became of a file, and why if it failed."""
    try:
        record = pz.read(str(folder / truth["file"]))
    except Exception as why:  # any refusal counts, whatever its kind
        if truth["expect"] == "refuse":
            return "refused, as it should be", ""
        return ("refused, which is right too" if "refuse" in (truth.get("also_ok") or "") else "refused"), str(why)
    if truth["expect"] == "refuse":
        return "read, though unclear", truth["why"]
    for name in "uy":
        if not np.array_equal(np.ravel(getattr(record, name)), numbers(truth[name]), equal_nan=True):
            return "read wrong", f"{name} differs"
    if truth["ts"] and abs(record.ts / truth["ts"] - 1) > TS:
        return "read wrong", f"ts is {record.ts}, not {truth['ts']}"
    return "read right", ""


def main() -> None:
    """Reads all files, and prints a table."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--set", choices=["first", "second", "third"], default="first")
    words.add_argument("--data", type=Path, help="folder of the files; they are written if they are not there")
    words.add_argument("--only", default="", help="files whose name begins so")
    words.add_argument("--all", action="store_true", help="lists the files that are read right too")
    given = words.parse_args()
    data = given.data or HERE.parent / "target" / "files" / given.set
    if not (data / "truth.json").exists():
        script = {"first": "make.py", "second": "second/make.py", "third": "third/make.py"}[given.set]
        subprocess.run([sys.executable, HERE / "files" / script, data], check=True)
    entries = json.loads((data / "truth.json").read_text())
    counts: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    for truth in (one for one in entries if one["file"].startswith(given.only)):
        became, why = outcome(data, truth)
        counts[truth["family"]][became] += 1
        if given.all or became not in ("read right", "refused, as it should be"):
            print(f"{truth['file']}: {became}: {' '.join(why.split())[:300]}")
    counts["all"] = sum(counts.values(), collections.Counter())
    kinds = ["read right", "refused, as it should be", "refused, which is right too", "refused", "read, though unclear", "read wrong"]
    print(f"\n| family | {' | '.join(kinds)} |\n|---|{'--:|' * len(kinds)}")
    for family, count in counts.items():
        print(f"| {family} | {' | '.join(str(count[kind]) for kind in kinds)} |")


if __name__ == "__main__":
    main()
