#!/usr/bin/env python3
"""How often does `piezoid validate` name a gross mistake in a record, and how often does it name one in a sound record?

usage: mistakes.py [--seeds 1 2] [--only p04 pl140] [--piezoid FILE] [--data FOLDER] [--stage FOLDER...]
                   [--measured FOLDER]

Gross mistakes are made on purpose, each in every whole record in which it can be made. The records: the simulated
plants of bench/plants, the twins of the library under PRBS, sines, staircases and triangles (also at and above the
resonance), and records of stages and measured records if their folders are given. False alarms are counted on sound
records, their halves, and every other sample of them. The mistakes know nothing of how they are found. Needs numpy and
a command `piezoid`.
"""

import json
import subprocess
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from plants import HERE, arguments, recorded

# A model that answers nothing but y = u: only what is said of the record counts.
GAIN = {"hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [1.0]}, "offset": 0.0}


@dataclass
class Record:
    """A record: its name, sampling period [s], input, output and unit of the output."""

    name: str
    ts: float
    u: np.ndarray
    y: np.ndarray
    unit: str = "um"


def read(name: str, path: Path) -> Record:
    """A record from a CSV file with a column of time."""
    t, u, y = np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
    return Record(name, float((t[-1] - t[0]) / (len(t) - 1)), u, y)


def requested(only: list[str], name: str) -> bool:
    """Whether records of a plant of this name may be among those asked for."""
    return any(part.split("/")[0] in name for part in only)


def plants(data: Path, seeds: list[int], only: list[str]) -> Iterator[Record]:
    """The records of the simulated plants, made if they are not there."""
    for script in sorted((HERE / "plants").glob("p[0-9]*.py")):
        for seed in (one for one in seeds if requested(only, f"{script.stem}-{one}")):
            folder = recorded(script.stem, seed, data)
            for path in sorted(folder.glob("*.csv")):
                if path.name.startswith(("train", "test", "small")):
                    yield read(f"{folder.name}/{path.stem}", path)


def twins(piezoid: str, folder: Path, only: list[str]) -> Iterator[Record]:
    """Records of the simulated actuators of the library."""

    def run(words: str) -> str:
        return subprocess.run([piezoid, *words.split(), "--quiet"], check=True, capture_output=True, text=True).stdout

    for plant, hz in [("paper", 147), ("pl140", 145), ("pl128", 360), ("pl122", 600), ("pl112", 1800)]:
        if not requested(only, plant):
            continue
        ts = min(5e-4, 0.1 / hz) if plant != "pl140" else 5e-4
        drives = {
            "prbs": f"prbs --amplitude 1 --duration {2000 * ts}",
            "sine": "sine --amplitude 25 --frequency 7 --duration 1",
            "fast": f"sine --amplitude 2 --frequency {0.7 * hz} --duration {3000 * ts}",
            "resonance": f"sine --amplitude 1 --frequency {hz} --duration {3000 * ts}",
            "above": f"sine --amplitude 2 --frequency {1.5 * hz} --duration {3000 * ts}",
            "rising": "rising-sine --amplitude 28 --frequency 20 --duration 1",
            "staircase": "staircase --amplitude 25 --frequency 10 --duration 1",
            "triangle": "triangle --amplitude 25 --frequency 10 --duration 1",
            "multisine": f"multisine --amplitude 10 --frequency-low 2 --frequency-high {1.5 * hz} --duration 1",
            "chirp": f"chirp --amplitude 5 --frequency-start 2 --frequency-end {2 * hz} --duration 1",
            "steps": "stepped-sine --amplitude 25 --frequency 10 --duration 1",
        }
        for name, words in drives.items():
            drive, path = folder / "drive.csv", folder / "twin.csv"
            run(f"excite {words} --ts {ts} -o {drive}")
            run(f"simulate --plant {plant} --input {drive} -o {path}")
            yield read(f"{plant}/{name}", path)


def measured(folder: Path) -> Iterator[Record]:
    """Measured records, from CSV files and from arrays of multisines [sample, channel, realisation, period]."""
    for path in sorted(folder.glob("picma*/*.csv")):
        yield read(path.stem, path)
        yield skipped(read(path.stem + "/settled", path), 300)
    for path in sorted(folder.glob("fsm/u_*.npy")):
        u, y = np.load(path), np.load(path.with_name(path.name.replace("u_", "y_", 1)))
        for channel in range(u.shape[1]):
            for realisation in range(2):
                name, pair = f"fsm/{path.stem}/{channel}{realisation}", (channel, realisation, 0)
                yield Record(name, 1 / 6400, u[:, *pair], y[:, *pair], "m")


def skipped(record: Record, n: int) -> Record:
    """The record without its first samples."""
    return replace(record, u=record.u[n:], y=record.y[n:])


def cuts(record: Record) -> Iterator[Record]:
    """The record, its halves, and every other sample of it: all sound."""
    half = len(record.u) // 2
    yield record
    yield replace(record, name=record.name + " first half", u=record.u[:half], y=record.y[:half])
    yield replace(record, name=record.name + " second half", u=record.u[half:], y=record.y[half:])
    thin = replace(record, name=record.name + " every other", ts=2 * record.ts, u=record.u[::2], y=record.y[::2])
    if not folds(record, 2):
        yield thin


def folds(record: Record, n: int) -> bool:
    """True if every n-th sample of a record with one line in its input folds this line."""
    line = tone(record)
    return line is not None and 2 * n * line > 1


def tone(record: Record) -> float | None:
    """The frequency of the input [1/sample] if it has one line, and this line is not slow drift."""
    power = np.abs(np.fft.rfft((record.u - record.u.mean()) * np.hanning(len(record.u)))) ** 2
    top = int(power.argmax())
    near = power[max(top - 3, 0) : top + 4].sum()
    return top / len(record.u) if top >= 5 and near > 0.7 * power[1:].sum() else None


def swapped(r: Record) -> Record:
    """Columns swapped."""
    return replace(r, u=r.y, y=r.u)


def scaled(factor: float):
    """The output in another unit than its name says."""
    return lambda r: replace(r, y=factor * r.y)


def volts(factor: float):
    """The input in another unit than volts."""
    return lambda r: replace(r, u=factor * r.u)


def shifted(n: int):
    """The output late by n samples; early if n is negative."""
    return lambda r: replace(r, u=r.u[n:], y=r.y[:-n]) if n > 0 else replace(r, u=r.u[:n], y=r.y[-n:])


def saturated(r: Record) -> Record:
    """A sensor that ends at 70 % of the range of the output."""
    low, high = r.y.min(), r.y.max()
    return replace(r, y=np.minimum(r.y, low + 0.7 * (high - low)))


def aliased(r: Record) -> Record | None:
    """So few samples that the line of the input is above half the sampling frequency."""
    line = tone(r)
    if line is None:
        return None
    n = round(0.7 / line)
    return replace(r, ts=n * r.ts, u=r.u[::n], y=r.y[::n]) if len(r.u) // n >= 50 else None


def servo(r: Record) -> Record | None:
    """The record of a servo: the reference is the input of the record, and the plant follows at once."""
    rng = np.random.default_rng(len(r.u))
    low, high = r.u.min(), r.u.max()
    reference, noise = (r.u - low) / (high - low), 1e-3 * rng.standard_normal(len(r.u))
    u, y, state, sum_, rate = np.empty(len(r.u)), np.empty(len(r.u)), 0.0, reference[0], rng.uniform(0.01, 0.1)
    for t in range(len(r.u)):
        y[t] = state + noise[t]
        sum_ += rate * (reference[t] - y[t])
        u[t] = sum_
        state += 0.5 * (u[t] - state)
    return replace(r, u=low + (high - low) * u, y=r.y.min() + (r.y.max() - r.y.min()) * y)


# Each mistake, and words of the finding that names it.
MISTAKES = {
    "columns swapped": (swapped, "swapped"),
    "output x 1000": (scaled(1e3), "unit"),
    "output / 1000": (scaled(1e-3), "unit"),
    "input x 1000": (volts(1e3), "unit"),
    "input / 1000": (volts(1e-3), "unit"),
    "output late by 5": (shifted(5), "after the input"),
    "output late by 20": (shifted(20), "after the input"),
    "output early by 5": (shifted(-5), "before the input"),
    "output saturated": (saturated, "saturated"),
    "input aliased": (aliased, "aliased"),
    "closed loop": (servo, "closed loop"),
}
# Words that no sound record may cause. A twin may saturate its sensor indeed.
GROSS = {words for _, words in MISTAKES.values()} - {"saturated"}


def remarks(piezoid: str, record: Record) -> list[str]:
    """The remarks of the command on a record."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savetxt(folder / "r.csv", np.c_[record.u, record.y], "%.9g", ",", header=f"u_V,y_{record.unit}", comments="")
        model = {"piezoid": 1, "ts": record.ts, "units": {"u": "V", "y": record.unit}, **GAIN}
        (folder / "m.json").write_text(json.dumps(model))
        words = f"validate r.csv --model m.json --ts {record.ts!r} --offset free --json -".split()
        done = subprocess.run([piezoid, *words], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return [done.stderr.strip()]
        return json.loads(done.stdout)["files"][0]["remarks"]


def named(piezoid: str, record: Record) -> set[str]:
    """The gross mistakes that the command names."""
    text = " ".join(remarks(piezoid, record))
    return {words for words in GROSS | {"saturated"} if words in text}


def right(record: Record) -> set[str]:
    """What may be said of a sound record: one plant is recorded in closed loop."""
    return {"closed loop"} if "p18_servo" in record.name and "open_loop" not in record.name else set()


def main() -> None:
    """Makes the mistakes, and prints a table."""
    parser = arguments(__doc__)
    parser.add_argument("--stage", type=Path, nargs="*", default=[])
    parser.add_argument("--measured", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        records = [*plants(args.data, args.seeds, args.only), *twins(args.piezoid, Path(folder), args.only)]
    for folder in args.stage:
        paths = sorted(folder.glob("[tl]*_*.csv"))
        records += [read(f"{folder.name}/{path.stem}", path) for path in paths]
    records += measured(args.measured) if args.measured else []
    records = [r for r in records if any(part in r.name for part in args.only) and np.ptp(r.u) > 0]

    def every(jobs: list[Record]) -> list[set[str]]:
        with ThreadPoolExecutor() as pool:
            return list(pool.map(lambda record: named(args.piezoid, record), jobs))

    sound = [cut for record in records for cut in cuts(record) if np.ptp(cut.u) > 0]
    alarms = [(r, found & GROSS - right(r)) for r, found in zip(sound, every(sound), strict=True)]
    print(f"{len(sound)} sound records and cuts, with false alarms: {sum(bool(found) for _, found in alarms)}")
    for record, found in alarms:
        if found:
            print(f"- {record.name}: {', '.join(sorted(found))}")
    print("\n| mistake | made in records | named | % | only another one named |\n|---|--:|--:|--:|--:|", flush=True)
    for mistake, (make, requested) in MISTAKES.items():
        damaged = [bad for bad in map(make, records) if bad is not None]
        found = every(damaged)
        count = sum(requested in words for words in found)
        other = sum(requested not in words and bool(words & GROSS) for words in found)
        print(f"| {mistake} | {len(damaged)} | {count} | {100 * count / max(len(damaged), 1):.0f} | {other} |", flush=True)


if __name__ == "__main__":
    main()
