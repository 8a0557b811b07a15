"""From records to a model."""

from __future__ import annotations

import json
import os
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from . import _piezoid
from ._checks import called, whole, wholes
from ._piezoid import PiezoidError, __version__
from ._progress import told
from ._types import Progress
from .model import Model
from .records import as_record, sources

if TYPE_CHECKING:
    from .records import Sources


def identify(
    *,
    linear: Sources = (),
    rich: Sources = (),
    data: Sources = (),
    method: Literal["joint", "paper"] = "joint",
    operator: str = "auto",
    order: int | None = None,
    seed: int = 1,
    elements: int | None = None,
    creep: bool = True,
    driver: str | None = None,
    capacitance: float | None = None,
    driver_lag: float | None = None,
    estimator: str | None = None,
    split: Literal["line", "direction"] | None = None,
    bins: int | None = None,
    reading: Literal["held", "printed"] | None = None,
    particles: int | None = None,
    iterations: int | None = None,
    global_best: Literal["ever", "current"] | None = None,
    progress: Progress = None,
) -> Model:
    """A model of the actuator that the records show; `model.notes` says what its user should know.

    linear: small-signal records (a PRBS of about 1 V); rich: records that exercise the hysteresis (rising sines at some
        frequencies); data: records for everything, where no small-signal one was taken. Each a record or several, or
        what `read` makes records of.
    method: "joint" finds all parts together, by the free-run error; "paper" takes the paper's six steps
    operator: one of `pz.operators`; of several, separated by commas, and of all ("auto") the simplest is taken that foretells
        held-out parts as well as the best
    order: of the linear block; chosen where it is not given (2 the paper's way)
    seed: of the swarm

    The joint way alone: `elements` (thresholds, levels or knots of the operator), `creep`, and the driver that the records were
    taken with, where its limits matter: `driver` by name, `capacitance` of the load [F], `driver_lag` [s].
    The paper's way alone: `estimator` of the linear block, how a loop is `split`, averages a branch (`bins`), `reading` of held
    inputs, `particles` and `iterations` of the swarm, and its `global_best` (the best position ever, or of the current ones).

    progress: True shows a bar (tqdm), a bar of yours is moved; a function is called with what is being done, how far, and of how
        much. What it raises ends the work, as Ctrl-C does.

    >>> import piezoid as pz
    >>> u = pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4)
    >>> model = pz.identify(data=pz.plants["pl140"].measure(u, ts=1e-3), operator="prandtl-ishlinskii", order=2)
    >>> model.operator
    'prandtl-ishlinskii'
    """
    given = [sources(linear), sources(rich), sources(data)]
    small, others, everything = ([as_record(source) for source in part] for part in given)
    if everything and (small or others):
        raise PiezoidError("data is for records of everything: give either data, or linear and rich")
    others += everything
    only: dict[str, dict[str, Any]] = {
        "joint": {"elements": elements, "driver": driver, "capacitance": capacitance, "driver_lag": driver_lag},
        "paper": {"estimator": estimator, "split": split, "bins": bins, "reading": reading, "particles": particles,
                  "iterations": iterations, "global_best": global_best},
    }  # fmt: skip
    for way, settings in only.items():
        for name, value in settings.items():
            if value is not None and method in only and way != method:
                raise PiezoidError(f"{name} belongs to the method {way}: leave it out, or ask for that method")
    asked = {"operator": operator, "creep": creep} | only["joint"] | only["paper"]
    asked |= wholes(order=order, seed=seed, bins=bins, particles=particles, iterations=iterations)
    if elements is not None:
        asked["elements"] = whole("elements", elements, least=1)
    usual = {"operator": "auto", "creep": True, "seed": 1}
    said = [f"{name}={value!r}" for name, value in asked.items() if value is not None and value != usual.get(name)]
    command = f"piezoid.identify({', '.join([f'method={method!r}', *said])})"
    files = [_file(source) for part in given for source in part if isinstance(source, (str, os.PathLike))]
    made = json.dumps({"command": command, "version": __version__, "files": files, "seed": asked["seed"]})
    with told(progress) as watch, called(**{"driver.lag_s": "driver_lag"}):
        core = _piezoid.identify(([r._core for r in small], [r._core for r in others]), method, asked, made, watch)
    return Model._of(core)


def _file(path: str | os.PathLike[str]) -> dict[str, str]:
    """Name and hash of a file."""
    return {"file": Path(path).name, "sha256": sha256(Path(path).read_bytes()).hexdigest()}
