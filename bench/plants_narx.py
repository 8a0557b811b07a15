#!/usr/bin/env python3
"""How near to the noise floor does SysIdentPy's polynomial NARX come on the records of plants.py?

usage: plants_narx.py [--seeds 1 2] [--only p04 p11] [--data FOLDER] [--json FILE] [--write]

Each setting is fitted to all training records but the last, at most 20 000 samples together, an equal share of each;
the one with the best free run on the last is fitted to all. Errors are those of plants.py: free run, each record with
its own constant, without the first tenth. --write puts the median ratios into the table of bench/plants/README.md. Needs
numpy, sysidentpy and piezoid.
"""

import json
import statistics
from pathlib import Path

import numpy as np
import piezoid as pz
from beside.fits import Narx, Setting, nrmse
from plants import HERE, SKIPPED, arguments, recorded, write

SAMPLES = 20_000
DIVERGED = 1e4
"""From this ratio to the floor on, a free run counts as diverged."""
SETTINGS = [Setting(1, 1, 8, 17), Setting(1, 2, 4, 16), Setting(3, 2, 2, 16), Setting(3, 3, 2, 30)]


def parts(records: list[pz.Record]) -> list[pz.Record]:
    """The first samples of each record, at most SAMPLES together."""
    return [pz.Record(r.u[:n], r.y[:n], r.ts) for r in records for n in [SAMPLES // len(records)]]


def error(model: Narx, record: pz.Record) -> float:
    """NRMSE [%] of a free run with its own constant."""
    return nrmse(record.y, model.simulate(record), int(SKIPPED * len(record)), free=True)[0]


def measured(folder: Path) -> dict:
    """The errors on the tests of a plant."""
    truth = json.loads((folder / "truth.json").read_text())["records"]
    records = {name: pz.read(folder / name) for name in sorted(truth)}
    train = [r for name, r in records.items() if name.startswith("train")]
    # A single record is judged on its last third.
    cut = [r.part(a * r.duration, b * r.duration) for r in train for a, b in [(0, 2 / 3), (2 / 3, 1)]]
    *most, held = train if len(train) > 1 else cut
    best = min(SETTINGS, key=lambda how: error(Narx(parts(most), how), held))
    model = Narx(parts(train), best)
    row = {"setting": str(best), "errors": {}, "floors": {}}
    for name in (n for n in records if n.startswith("test")):
        kind = name.removeprefix("test_").removesuffix(".csv")
        row["errors"][kind] = error(model, records[name])
        row["floors"][kind] = truth[name].get("day_nrmse_percent", truth[name]["floor_nrmse_percent"])
    row["ratio"] = statistics.median(e / row["floors"][k] for k, e in row["errors"].items())
    return row


def main() -> None:
    """Measures, and prints a table."""
    parser = arguments(__doc__)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    rows = {}
    print("| plant | setting | error [% NRMSE] by test | median ratio to the floor |\n|---|---|---|--:|")
    for name in (p.stem for p in sorted((HERE / "plants").glob("p[0-9]*.py"))):
        for seed in args.seeds if any(name.startswith(part) for part in args.only) else []:
            rows[f"{name}-{seed}"] = row = measured(recorded(name, seed, args.data))
            tests = ", ".join(f"{k} {e:.2g}" for k, e in row["errors"].items())
            print(f"| {name}-{seed} | {row['setting']} | {tests} | {row['ratio']:.1f} |", flush=True)
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    if args.write:
        cell = {name.split("_")[0]: row["ratio"] for name, row in rows.items()}
        write("SysIdentPy", {name: f"{ratio:.0f}" if ratio < DIVERGED else "diverges" for name, ratio in cell.items()})


if __name__ == "__main__":
    main()
