"""Operators and structures of piezoid beside other methods, on one split of each record, as docs/leaderboard.md.

    python3 bench/leaderboard.py [--write] [--quick] [--only TEXT]

It needs the package piezoid with sysidentpy==0.9.0, scikit-learn, scipy and pandas. The measured stack needs the folder
that PIEZOID_DATA names; without it, its part is skipped. --write writes the page, --quick takes a part of each problem, --only
takes the problems whose names contain a text and leaves the others on the page as they are.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
import piezoid as pz
from beside.baselines import METHODS

PAGE = Path(__file__).parents[1] / "docs/leaderboard.md"
BEGIN, END = "<!-- leaderboard: written by `python3 bench/leaderboard.py --write` -->\n", "<!-- end of leaderboard -->\n"
TS = 5e-4
OPERATORS = ["auto", "preisach", "prandtl-ishlinskii", "bouc-wen", "dahl"]


@dataclass
class Problem:
    """Records of one actuator."""

    name: str
    training: dict[str, pz.Record]
    data: dict[str, pz.Record] | None = None
    """Other records to compare on; None holds out the end of each training record."""
    structures: list[str] = field(default_factory=lambda: ["hammerstein", "no-creep", "linear"])
    options: dict[str, Any] = field(default_factory=dict)
    small_signal: list[pz.Record] = field(default_factory=list)


def driven(hz: float, amplitude: float, duration: float) -> np.ndarray:
    """A sine whose amplitude is modulated and that begins at rest."""
    t = np.arange(round(duration / TS)) * TS
    return np.asarray(amplitude * np.sin(2 * np.pi * hz / 11 * t) * np.sin(2 * np.pi * hz * t))


def band(duration: float, high: float) -> np.ndarray:
    """A multisine from 1 Hz on that begins at rest: a jump or the resonance would reach limits."""
    u = pz.excite.multisine(ts=TS, duration=duration, amplitude=25, frequency_low=1, frequency_high=high, seed=1)
    return u * np.minimum(1.0, np.arange(len(u)) * TS / 0.05)


def twins(quick: bool) -> Iterator[Problem]:
    """Simulated benders, from one record of 10 s, and from several records."""
    multisine = band(10, 60)
    for plant in ("pl140", "paper"):
        record = pz.plants[plant].measure(multisine, TS, seed=1)
        part = record.part(0, 4) if quick else record
        yield Problem(f"`{plant}`, a multisine of 1 to 60 Hz, its last quarter held out", {"multisine": part})
    if quick:
        return
    plant = pz.plants["pl140"]
    rising = {
        f"rising sine, {hz} Hz": plant.measure(
            pz.excite.rising_sine(ts=TS, duration=3, amplitude=20, frequency=hz), TS, seed=hz
        )
        for hz in (1, 5, 20, 80)
    }
    drives = {
        "modulated sine, 10 Hz": driven(10, 18, 2),
        "multisine, 1 to 40 Hz": 0.7 * band(2, 40),
        "modulated sine, 30 Hz": driven(30, 18, 2),
    }
    unseen = {name: plant.measure(u, TS, seed=99) for name, u in drives.items()}
    small = plant.measure(pz.excite.prbs(ts=TS, duration=2.0475, amplitude=1, order=12), TS)
    driver = {"driver_lag": 1e-4}
    yield Problem(
        "`pl140`, a PRBS and rising sines, compared on other signals",
        rising,
        unseen,
        options=driver,
        small_signal=[small],
    )


def benchmark(quick: bool) -> Problem:
    """The Bouc-Wen benchmark: a period of a multisine with noise; compared on another multisine and on a sweep."""
    fs, faster, n = 750.0, 20, 8192
    ts, plant = 1 / (fs * faster), pz.plants["bouc-wen-benchmark"]

    def record(u: np.ndarray, noise: float = 0.0) -> pz.Record:
        fine = pz.Record(u, plant.simulate(u, ts=ts), ts=ts, units=plant_units).prepare(decimate=faster)
        y = fine.y + noise * np.random.default_rng(2).standard_normal(len(fine))
        return pz.Record(fine.u, y, fine.ts, units=fine.units)

    def multisine(seed: int) -> np.ndarray:
        lines = np.arange(round(5 * n / fs), round(150 * n / fs) + 1)
        spectrum = np.zeros(n * faster // 2 + 1, complex)
        spectrum[lines] = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(lines)))
        u = np.fft.irfft(spectrum, n * faster)
        return np.tile(50 * u / u.std(), 2)

    plant_units = ("V", "um")
    t = np.arange(round((20 if quick else 180) / ts)) * ts
    sweep = 40 * np.sin(2 * np.pi * (20 * t + 0.5 * 10 / 60 * t**2))
    second = record(multisine(1), 8.0)
    training = pz.Record(second.u[n:], second.y[n:], second.ts, units=second.units)
    data = {"multisine": record(multisine(3)), "sweep": record(sweep)}
    structures = ["hammerstein", "linear", *([] if quick else ["feedback"])]
    return Problem(
        "`bouc-wen-benchmark`, a period of a multisine, compared on another and on a sweep",
        {"multisine": training}, data, structures, {"skip": n / fs},
    )


def stack() -> Problem | None:
    """A measured PICMA stack at 1 Hz."""
    folder = Path(os.environ.get("PIEZOID_DATA", "")) / "picma-p885"
    if "PIEZOID_DATA" not in os.environ or not folder.is_dir():
        print("SKIPPED: the measured stack, because PIEZOID_DATA names no folder with picma-p885", file=sys.stderr)
        return None
    sine, rising = (pz.read(folder / name, start=1.5) for name in ("model_1Hz.csv", "test_am_1Hz.csv"))
    name = "A measured stack (PICMA P-885), a sine of 1 Hz, compared on rising sines"
    return Problem(name, {"sine": sine}, {"rising": rising}, options={"offset": "free"})


def board(problem: Problem, quick: bool) -> str:
    """The table of a problem."""
    warnings.simplefilter("ignore")
    start = time.perf_counter()
    data = {} if problem.data is None else {"data": problem.data}
    found = pz.compare(
        records=problem.training, methods=METHODS, operators=OPERATORS[:2] if quick else OPERATORS,
        structures=problem.structures, small_signal=problem.small_signal, **problem.options, **data,
    )
    rows = ["| method | error [%] | noise [%] | parameters | fit [s] | step [ns] |", "|---|--:|--:|--:|--:|--:|"]
    for name, one in found.ranking.iterrows():
        if isinstance(one["reason"], str):
            rows.append(f"| {name} | {one['reason'][:90]} | | | | |")
            continue
        own = name in METHODS
        called = str(name) if own else f"piezoid, {name}" + (f" ({one['operator']})" if name == "auto" else "")
        cells = [_figure(one["rms_pp_percent"]), _figure(one["noise_percent"])]
        cells += ["" if np.isnan(one["parameters"]) else f"{one['parameters']:.0f}"]
        cells += [_figure(one["fit_s"]), f"{one['step_ns']:.0f}"]
        rows.append(f"| {called} | {' | '.join(cells)} |")
    print(f"{problem.name}: {time.perf_counter() - start:.0f} s", file=sys.stderr)
    text = f"### {problem.name}\n\n" + "\n".join(rows) + "\n"
    print(text, flush=True)
    return text


def _figure(x: float) -> str:
    return "" if x is None or np.isnan(x) else f"{x:.2g}" if x < 100 else f"{x:.0f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write docs/leaderboard.md")
    parser.add_argument("--quick", action="store_true", help="a part of each problem")
    parser.add_argument("--only", default="", help="problems whose names contain this")
    chosen = parser.parse_args()
    # A plant warns if its record reaches a limit: such a record would test that limit.
    warnings.filterwarnings("error", module="piezoid", category=UserWarning)
    problems = [*twins(chosen.quick), benchmark(chosen.quick), stack()]
    page = PAGE.read_text()
    head, rest = page[: page.index(BEGIN) + len(BEGIN)], page[page.index(END) :]
    before = [f"### {part.strip()}\n" for part in page[len(head) : page.index(END)].split("### ")[1:]]
    known = [f"### {problem.name}" for problem in problems if problem is not None]
    boards = {text.splitlines()[0]: text for text in before}
    for problem in problems:
        if problem is not None and chosen.only in problem.name:
            text = board(problem, chosen.quick)
            boards[text.splitlines()[0]] = text
            if chosen.write:
                PAGE.write_text(head + "\n" + "\n".join(boards[name] for name in known if name in boards) + "\n" + rest)


if __name__ == "__main__":
    main()
