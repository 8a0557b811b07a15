#!/usr/bin/env python3
"""How much of the errors that plants.py leaves would extensions of the model explain?

usage: plants_extensions.py [--seeds 1 2] [--only p04 p11] [--piezoid FILE] [--data FOLDER]

Reads the models that plants.py left in FOLDER. Each extension has terms with coefficients, which are fitted to the
errors on the training records by least squares. The table has the ratio of the errors with and without it on each test,
where it is not 1, and the gain that each training record alone would prefer.

    curve    y^2 and y^3: the sensor is curved
    softer   G (e |e|) and G e^3, e = y/g - z: the mode's frequency falls with the elastic strain e, g the static gain
    wider    G (h lg v) and G (sign u' sqrt |u'|): hysteresis h, z without its cubic in u, grows with the rate v

Needs numpy and scipy, and a command `piezoid`.
"""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from plants import SKIPPED, arguments, run
from scipy.signal import lfilter

BEGINNINGS = ["rest", "settled", "from-above", "from-below", "motion"]


def column(file: Path, name: str) -> np.ndarray:
    """A column of a CSV file, by the start of its name."""
    with file.open() as lines:
        head = next(line for line in lines if not line.startswith("#")).strip().split(",")
        k = next(k for k, title in enumerate(head) if title.startswith(name))
        return np.genfromtxt(lines, delimiter=",", usecols=k)


@dataclass
class Run:
    """A record and a model's free run on it: input, measured and simulated output, and z with creep."""

    u: np.ndarray
    y: np.ndarray
    simulated: np.ndarray
    z: np.ndarray

    def __post_init__(self) -> None:
        """Notes which samples count: the first tenth is decided by the past."""
        self.used = np.isfinite(self.y) & (np.arange(len(self.y)) >= SKIPPED * len(self.y))

    def weighted(self, x: np.ndarray) -> np.ndarray:
        """The samples that count about their mean, over peak-to-peak and the root of their number."""
        x = x[self.used]
        return (x - x.mean(axis=0)) / np.ptp(self.y[self.used]) / np.sqrt(len(x))


class Plant:
    """The free runs of the model of a plant, on all its records."""

    def __init__(self, piezoid: str, folder: Path) -> None:
        self.piezoid, self.folder = piezoid, folder
        self.model = json.loads((folder / "model.json").read_text())
        a, b = self.model["linear"]["a"], np.array(self.model["linear"]["b"])
        self.gain = b.sum() / (1 - sum(a))
        self.filter = b / self.gain, np.r_[1, -np.array(a)]
        names = sorted(json.loads((folder / "truth.json").read_text())["records"])
        with tempfile.TemporaryDirectory() as place:
            hidden = Path(place) / "hidden.json"
            kept = {k: v for k, v in self.model.items() if k not in ("identified", "fit")}
            hidden.write_text(json.dumps({**kept, "linear": {"a": [], "b": [1.0]}, "offset": 0.0}))
            self.runs = {name: self.free_run(name, hidden) for name in names}
        self.train = [r for name, r in self.runs.items() if not name.startswith("test")]
        u, z = (np.concatenate([getattr(r, name) for r in self.train]) for name in "uz")
        self.cubic = np.polyfit(u, z, 3)
        self.size = max(np.ptp(r.simulated) for r in self.train)

    def free_run(self, name: str, hidden: Path) -> Run:
        """A record, simulated from the beginning that fits best."""
        u, y = (column(self.folder / name, one) for one in "uy")
        runs = {begin: self.simulated("model.json", name, begin) for begin in BEGINNINGS}
        left = {begin: np.nanstd(y - s) for begin, s in runs.items() if s is not None}
        begin = min(left, key=left.get)
        return Run(u, y, runs[begin], self.simulated(str(hidden), name, begin))

    def simulated(self, model: str, name: str, begin: str) -> np.ndarray | None:
        """The output of a model, or None if it cannot begin so."""
        with tempfile.TemporaryDirectory() as place:
            out = str(Path(place) / "out.csv")
            words = ["simulate", "--model", model, "--input", name, "--begin", begin, "--quiet", "-o", out]
            return column(Path(out), "y") if run(self.piezoid, words, self.folder)[0] == 0 else None

    def through(self, x: np.ndarray) -> np.ndarray:
        """The response of the linear block with a static gain of 1, settled at first."""
        return lfilter(*self.filter, x - x[0]) + x[0]

    def curve(self, r: Run) -> list[np.ndarray]:
        """A curved sensor."""
        y = r.simulated - r.simulated.mean()
        return [y, y**2 / self.size, y**3 / self.size**2]

    def softer(self, r: Run) -> list[np.ndarray]:
        """A mode that softens."""
        e = r.simulated - self.gain * r.z
        e -= np.median(e)
        return [self.through(e * np.abs(e) / self.size), self.through(e**3 / self.size**2)]

    def wider(self, r: Run) -> list[np.ndarray]:
        """Hysteresis that grows with the rate."""
        h, rate = r.z - np.polyval(self.cubic, r.u), np.gradient(r.u)
        mean = lfilter([0.05], [1, -0.95], np.abs(rate)) + 1e-3 * np.ptp(rate)
        return [self.through(h * np.log10(mean / mean.mean())), self.through(np.sign(rate) * np.sqrt(np.abs(rate)))]

    def ratios(self, extension: str) -> str:
        """The errors with and without an extension on the tests."""
        terms = {id(r): np.column_stack(getattr(self, extension)(r)) for r in self.runs.values()}
        rows = np.vstack([r.weighted(terms[id(r)]) for r in self.train])
        errors = np.concatenate([r.weighted(r.y - r.simulated) for r in self.train])
        k = np.linalg.lstsq(rows, errors, rcond=1e-12)[0]

        def ratio(r: Run) -> float:
            error = r.weighted(r.y - r.simulated)
            return float(np.std(error - r.weighted(terms[id(r)]) @ k) / np.std(error))

        tests = {name[5:-4]: ratio(r) for name, r in self.runs.items() if name.startswith("test")}
        return ", ".join(f"{name} {q:.2f}" for name, q in tests.items() if abs(q - 1) > 0.005)

    def gains(self) -> str:
        """The gains that single training records would prefer [%]."""
        pairs = [(r.weighted(r.y), r.weighted(r.simulated)) for r in self.train]
        return ", ".join(f"{100 * ((s @ y) / (s @ s) - 1):.2f}" for y, s in pairs)


def main() -> None:
    """Prints the table."""
    args = arguments(__doc__).parse_args()
    print("| plant | curve | softer | wider | gains of the training records [%] |")
    print("|---|---|---|---|---|")
    for folder in sorted(p.parent for p in args.data.glob("*/model.json")):
        if any(folder.name.startswith(part) for part in args.only):
            plant = Plant(args.piezoid, folder)
            cells = [plant.ratios(name) for name in ("curve", "softer", "wider")]
            print(f"| {folder.name} | {' | '.join(cells)} | {plant.gains()} |", flush=True)


if __name__ == "__main__":
    main()
