#!/usr/bin/env python3
"""How many files of other programs are read right without an option, and does the reader refuse the others?

usage: files.py [--set first|second|third] [--only csv] [--all | --list]

bench/files holds three sets of files with what is true of them; its README states how they came about. A file is read
right if u and y are those of truth.json to the bit, and the sampling period but for rounding; it may be refused if
truth.json says that it cannot be known what is what. Each file that fails is listed with its message, cut to one line.
Needs numpy and piezoid.
"""

import argparse
import json
import tarfile
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
import piezoid as pz

HERE = Path(__file__).resolve().parent / "files"
SETS = ["first", "second", "third"]
OUTCOMES = ["read right", "refused, which is right too", "refused", "read wrong"]
OUTCOMES += ["refused, as it should be", "read, though unclear"]
EXPECTED = ("read right", "refused, as it should be")
TS = 1e-9
"""Relative difference of sampling periods that is rounding of the times in a file."""


def unpacked(name: str, folder: Path) -> list[dict]:
    """Unpacks a set into a folder, and returns the list of its files."""
    with tarfile.open(HERE / f"{name}.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    return json.loads((folder / "truth.json").read_text(encoding="utf-8"))


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


def outcomes(name: str, only: str = "") -> list[tuple[dict, str, str]]:
    """Every file of a set with its outcome and the reason."""
    with tempfile.TemporaryDirectory() as folder:
        entries = [one for one in unpacked(name, Path(folder)) if one["file"].startswith(only)]
        return [(truth, *outcome(Path(folder), truth)) for truth in entries]


def listed(name: str) -> None:
    """Prints what each file of a set imitates."""
    with tempfile.TemporaryDirectory() as folder:
        for truth in unpacked(name, Path(folder)):
            print(truth["file"], truth["family"], truth.get("writer", ""), truth["expect"], truth["why"], sep="\t")


def main() -> None:
    """Reads all files, and prints a table."""
    args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    args.add_argument("--set", choices=SETS, action="append", help="default: all sets")
    args.add_argument("--only", default="", help="files whose name begins so")
    args.add_argument("--all", action="store_true", help="lists the files that are read right too")
    args.add_argument("--list", action="store_true", help="only lists the files: name, family, writer, what is expected, why")
    args = args.parse_args()
    rows: dict[str, Counter[str]] = {}
    for name in args.set or SETS:
        if args.list:
            listed(name)
            continue
        for truth, result, why in outcomes(name, args.only):
            for row in (f"{name}: {truth['family']}", name):
                rows.setdefault(row, Counter())[result] += 1
            if args.all or result not in EXPECTED:
                print(f"{name}/{truth['file']}: {result}: {' '.join(why.split())[:300]}")
    if rows:
        print(f"\n| set: family | {' | '.join(OUTCOMES)} |\n|---|{'--:|' * len(OUTCOMES)}")
    for row in sorted(rows):
        print(f"| {row} | {' | '.join(str(rows[row][kind]) for kind in OUTCOMES)} |")


if __name__ == "__main__":
    main()
