#!/usr/bin/env python3
"""How near to the noise floor does `piezoid identify` come on plants that share nothing with the library (bench/plants)?

usage: plants.py [--seeds 1 2] [--only p04 p11] [--piezoid FILE] [--data FOLDER] [--json FILE] [--write]
                 [--options --operator NAME ...]

Each plant is recorded (if FOLDER does not have its records yet), identified from its training records, and validated on
its test records: free run, each record with its own constant, without the first tenth of the record, in which the past
decides. The floor is noise, quantisation and hum. On `day` the plant has another gain, creep and offset; the floor is
the error of the true plant of the training day. --write puts the median ratios of seed 1 into the table of
bench/plants/README.md. Needs numpy and scipy, and a command `piezoid`.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from pathlib import Path

import page

HERE = Path(__file__).resolve().parent
SKIPPED = 0.1
PAGE = HERE / "plants" / "README.md"
PI = "prandtl-ishlinskii"
COLUMNS = {"": "piezoid", f"--operator {PI}": "PI alone", f"--operator generalised-{PI}": "generalised PI alone"}
"""The columns of the table of results, by the options of identify."""


def run(piezoid: str, words: list[str], folder: Path) -> tuple[int, str]:
    """The command in a folder: its exit status and what it wrote on stderr."""
    done = subprocess.run([piezoid, *words], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def recorded(name: str, seed: int, data: Path) -> Path:
    """The folder with the records of a plant, made if it is not there."""
    folder = data / f"{name}-{seed}"
    if not (folder / "truth.json").exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, HERE / "plants" / f"{name}.py", folder, str(seed)], check=True)
    return folder


def measured(piezoid: str, folder: Path, options: list[str]) -> dict:
    """Identification and validation of one plant."""
    truth = json.loads((folder / "truth.json").read_text())["records"]
    names = sorted(truth)
    small = [n for n in names if n.startswith("small")]
    train = [n for n in names if n.startswith("train")]
    words = [*train, *(["--small-signal", *small] if small else [])]
    start = time.perf_counter()
    status, printed = run(
        piezoid, ["identify", *words, *options, "--quiet", "-o", "model.json", "--json", "fit.json"], folder
    )
    row = {"seconds": time.perf_counter() - start, "notes": printed, "errors": {}, "floors": {}}
    if status != 0:
        return row
    model = json.loads((folder / "model.json").read_text())
    row["operator"] = model["hysteresis"]["operator"]
    row["order"] = len(model["linear"]["a"])
    for name in (n for n in names if n.startswith("test")):
        skip = SKIPPED * truth[name]["seconds"]
        words = ["validate", name, "--model", "model.json", "--offset", "free", "--skip", f"{skip:g}"]
        status, _ = run(piezoid, [*words, "--json", "test.json", "--quiet"], folder)
        figures = json.loads((folder / "test.json").read_text())["total"] if status == 0 else {}
        kind = name.removeprefix("test_").removesuffix(".csv")
        row["errors"][kind] = figures.get("nrmse_percent", float("inf"))
        row["floors"][kind] = truth[name].get("day_nrmse_percent", truth[name]["floor_nrmse_percent"])
    return row


def ratio(row: dict) -> float:
    """The median over the tests of error over floor; infinite if there is no model."""
    ratios = [error / row["floors"][kind] for kind, error in row["errors"].items()]
    return statistics.median(ratios) if ratios else float("inf")


def write(column: str, cells: dict[str, str]) -> None:
    """Replaces cells in a column of the table of results, by the plant."""
    text = PAGE.read_text(encoding="utf-8")
    head, rule, *lines = page.split(text, "results")[1].splitlines()
    k = [title.strip() for title in head.split("|")].index(column)
    for n, row in enumerate(line.split("|") for line in lines):
        row[k] = f" {cells.get(row[1].strip(), row[k].strip())} "
        lines[n] = "|".join(row)
    PAGE.write_text(page.replaced(text, "results", "\n".join([head, rule, *lines])), encoding="utf-8")


def arguments(description: str | None) -> argparse.ArgumentParser:
    """The arguments of a program that uses the records of the plants."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--only", nargs="+", default=[""])
    parser.add_argument("--piezoid", default="piezoid")
    parser.add_argument("--data", type=Path, default=HERE.parent / "target" / "plants")
    return parser


def main() -> None:
    """Measures, and prints a table."""
    parser = arguments(__doc__)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--options", nargs=argparse.REMAINDER, default=[], help="further options of identify, last")
    args = parser.parse_args()
    column = COLUMNS.get(" ".join(args.options))
    if args.write and (column is None or args.seeds != [1]):
        parser.error(f"the table has seed 1, and columns for these options: {list(COLUMNS)}")
    names = [p.stem for p in sorted((HERE / "plants").glob("p[0-9]*.py"))]
    rows = {}
    print("| plant | operator | order | error / floor [% NRMSE] by test | median ratio | time [s] |")
    print("|---|---|--:|---|--:|--:|")
    for name in (n for n in names if any(n.startswith(part) for part in args.only)):
        for seed in args.seeds:
            row = measured(args.piezoid, recorded(name, seed, args.data), args.options)
            rows[f"{name}-{seed}"] = row
            row["ratio"] = ratio(row)
            tests = ", ".join(f"{k} {e:.2g} / {row['floors'][k]:.2g}" for k, e in row["errors"].items())
            tests = tests or row["notes"].strip().splitlines()[-1]
            block = f"{row.get('operator', '-')} | {row.get('order', '-')}"
            print(f"| {name}-{seed} | {block} | {tests} | {row['ratio']:.1f} | {row['seconds']:.0f} |", flush=True)
    every = [row["ratio"] for row in rows.values()]
    print(f"\nMedian ratio over {len(every)} plants: {statistics.median(every):.2f}; largest: {max(every):.1f}.")
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    if args.write:
        write(column, {name.split("_")[0]: f"{row['ratio']:.1f}" for name, row in rows.items()})
    if args.write and column == "piezoid":
        write("operator taken", {name.split("_")[0]: row["operator"] for name, row in rows.items() if "operator" in row})


if __name__ == "__main__":
    main()
