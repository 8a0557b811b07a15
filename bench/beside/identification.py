"""Identification from records, side by side: on a twin, and on a measured stack if its data are available."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import piezoid as pz

from . import fits, prandtl_ishlinskii
from .problems import TS, Page, modulated, prbs
from .rivals import Array
from .table import Took, counted, figure, in_turn


@dataclass(frozen=True)
class Bench:
    """Training records, the record on which settings are selected, and validation records."""

    name: str
    small: list[pz.Record]
    train: list[pz.Record]
    held: pz.Record
    unseen: dict[str, pz.Record]
    start: int = 0
    """Settling samples at the start of a record."""
    free: bool = False
    """True if the sensor drifts: the mean error is removed."""
    whole: list[pz.Record] = field(default_factory=list)
    """The record of which `train` and `held` are parts, if there is one."""

    @property
    def all(self) -> list[pz.Record]:
        """The large-signal records to identify from."""
        return self.whole or [*self.train, self.held]


def twin() -> Bench:
    """`pl140` with its noise."""
    plant = pz.plants["pl140"]

    def rising(hz: float, amplitude: float, duration: float) -> pz.Record:
        u = pz.excite.rising_sine(ts=TS, duration=duration, amplitude=amplitude, frequency=hz)
        return plant.measure(u, TS, seed=int(hz))

    multisine = pz.excite.multisine(ts=TS, duration=2, amplitude=25, frequency_low=3, frequency_high=40, seed=1)
    drives = {
        "staircase, 10 Hz": pz.excite.staircase(ts=TS, duration=2, amplitude=25, frequency=10),
        # All inputs start at rest: a jump would reach the current limit of the driver.
        "multisine, 3 to 40 Hz": multisine * np.minimum(1.0, np.arange(len(multisine)) * TS / 0.05),
        "modulated sine, 30 Hz": modulated(30, 25, 4000),
    }
    unseen = {name: plant.measure(u, TS, seed=99) for name, u in drives.items()}
    train = [rising(1, 28, 4), rising(20, 28, 2), rising(80, 20, 2)]
    return Bench("twin", [prbs()], train, rising(5, 28, 2), unseen)


def measured() -> Bench | None:
    """A PICMA stack at 1 Hz, if PIEZOID_DATA names its folder."""
    folder = Path(os.environ.get("PIEZOID_DATA", "")) / "picma-p885"
    if "PIEZOID_DATA" not in os.environ or not folder.is_dir():
        return None
    record, growing = (pz.read(folder / name, start=1.5) for name in ("model_1Hz.csv", "test_am_1Hz.csv"))
    parts = record.part(0, 27), record.part(27)
    return Bench("stack", [], [parts[0]], parts[1], {"rising sine, 1 Hz": growing}, 300, True, [record])


def identification(page: Page, bench: Bench) -> None:
    """Models of the records, and their free runs on validation records."""
    everything = [*bench.small, *bench.all]
    settings, once = (fits.SETTINGS[:2], 1) if page.quick else (fits.SETTINGS, 3)

    def ours(operator: str) -> pz.Model:
        arguments: dict[str, Any] = {"linear": bench.small, "rich": bench.all} if bench.small else {"data": bench.all}
        return pz.identify(**arguments, operator=operator)

    def searched() -> tuple[fits.Setting, fits.Narx]:
        best = fits.search([*bench.small, *bench.train], bench.held, settings, bench.start, bench.free)
        return best, fits.Narx(everything, best)

    def by_hand(fit: Callable[..., Any]) -> Any:
        return fit(everything, fits.peak(bench.small[0]) if bench.small else None, bench.start)

    plays_by_hand = partial(by_hand, prandtl_ishlinskii.fit)
    chosen = partial(ours, "prandtl-ishlinskii" if page.quick else "auto")
    auto, search, plays_once = in_turn(chosen, searched, plays_by_hand, repeats=1)
    best, narx = search.result
    play, single, plays = in_turn(
        partial(ours, "prandtl-ishlinskii"), lambda: fits.Narx(everything, best), plays_by_hand, repeats=once
    )
    wen, hand = in_turn(partial(ours, "bouc-wen"), partial(by_hand, fits.bouc_wen), repeats=once)

    page.unseen.append([[bench.name, *bench.unseen]])
    runs: dict[str, list[tuple[float, float]]] = {}

    def figures(run: Callable[[pz.Record], Array]) -> list[tuple[float, float]]:
        return [fits.nrmse(record.y, run(record), bench.start, bench.free) for record in bench.unseen.values()]

    def proven(name: str, run: Callable[[pz.Record], Array]) -> str:
        if name not in runs:
            runs[name] = figures(run)
            cells = [f"{figure(a)} / {figure(b)}" if a < 1e9 else "diverges" for a, b in runs[name]]
            page.unseen[-1].append([name, *cells])
        return name

    def far(model: fits.Narx) -> float:
        return max(figures(model.simulate))[0]

    def compared(what: str, mine: Took, theirs: Took, other: str, rival: str, run: Callable[[pz.Record], Array]) -> None:
        model: pz.Model = mine.result
        name = f"{model.operator}, {what}"
        ours = runs[proven(f"piezoid, {name}", lambda record: model.validate(record).simulated)]
        errors = max(ours)[0], max(runs[rival])[0]
        page.add(f"{bench.name}: {name}", other, "worst nrmse [%]", errors, mine, theirs)
        for (record, one), mine_of, theirs_of in zip(bench.unseen.items(), ours, runs[rival]):
            took = in_turn(partial(model.simulate, one.u), partial(run, one), repeats=3)
            title = f"{bench.name}: {name}; {record}, {counted(len(one))}"
            page.add(title, rival, "nrmse [%]", (mine_of[0], theirs_of[0]), *took)

    if not page.quick:
        hindsight = min((fits.Narx(everything, how) for how in settings), key=far)
        proven("SysIdentPy, best in hindsight", hindsight.simulate)
    of_narx, by_name = proven("SysIdentPy", narx.simulate), proven("Bouc-Wen by hand", hand.result.simulate)
    of_plays = proven("Prandtl-Ishlinskii by hand", plays.result.simulate)
    compared("chosen", auto, search, "SysIdentPy, settings searched", of_narx, narx.simulate)
    compared("chosen", auto, plays_once, f"{of_plays}, `least_squares`", of_plays, plays.result.simulate)
    compared("given", play, single, "SysIdentPy, one setting", of_narx, narx.simulate)
    compared("given", play, plays, f"{of_plays}, `least_squares`", of_plays, plays.result.simulate)
    compared("given", wen, hand, "Bouc-Wen by hand, `least_squares`", by_name, hand.result.simulate)
    page.facts.append(f"Setting of SysIdentPy that was selected on the {bench.name} (input terms; degree, lags, terms): {best}.")
