"""Comparison of several models on the same records, and of methods on one split of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from inspect import signature
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias

from . import _piezoid
from ._keywords import known, takes
from ._options import CompareOptions
from ._piezoid import PiezoidError
from ._progress import watched
from ._types import Progress
from .model import Model, as_model
from .records import Record, as_record, sources

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

    from .records import Source, Sources

    ModelSource: TypeAlias = "Model | str | os.PathLike[str]"
    Method: TypeAlias = "ModelSource | Callable[..., Any]"


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Free runs of several models on the same records."""

    figures: dict[str, Any] = field(repr=False)
    """All figures, as the command line writes them."""
    html: str = field(repr=False)
    """A page with tables and figures."""
    svg: str | None = field(default=None, repr=False)
    """The error against the number of parameters as a drawing; None if no methods were compared on a split."""
    times: dict[str, tuple[float | None, float | None]] = field(default_factory=dict, repr=False)
    """For each method the time of its fit [s], with a search that is shared with others, and of one step of a free run
    [ns]; None where it is unknown. They differ from run to run, so no other attribute has them."""

    @property
    def best(self) -> str | None:
        """Name of the model with the smallest error over all records; None if the outputs are constant."""
        name: str | None = self.figures["best"]
        return name

    @property
    def summary(self) -> str | None:
        """The comparison in one sentence; None if the outputs are constant."""
        text: str | None = self.figures["summary"]
        return text

    @property
    def table(self) -> pd.DataFrame:
        """Rms errors in percent of the peak-to-peak of the record: one row per model, one column per record, and
        `total` if there are several and none is called so."""
        import pandas as pd

        rows = {}
        for model in self.figures["models"]:
            errors = {file["file"]: file["rms_pp_percent"] for file in model["files"]}
            total = {"total": model["total"]["rms_pp_percent"]} if len(errors) > 1 and "total" not in errors else {}
            rows[model["model"]] = errors | total
        return pd.DataFrame.from_dict(rows, orient="index", dtype=float)

    @property
    def ranking(self) -> pd.DataFrame:
        """The methods by rising error, then those that failed: error and noise floor in percent of peak-to-peak, operator,
        number of parameters, times as in `times`, and the reason of a failure."""
        import pandas as pd

        rows = {}
        for one in self.figures["models"]:
            total, (fit, step) = one["total"], self.times.get(one["model"], (None, None))
            floor = total["floor"]
            rows[one["model"]] = {
                "rms_pp_percent": total["rms_pp_percent"],
                "noise_percent": None if floor is None else floor["rms_pp_percent"],
                "operator": one["operator"],
                "parameters": one["all_parameters"],
                "fit_s": fit,
                "step_ns": step,
                "reason": None,
            }
        for failed in self.figures.get("failed", []):
            rows[failed["model"]] = {"reason": failed["reason"]}
        return pd.DataFrame.from_dict(rows, orient="index")

    def __repr__(self) -> str:
        return f"<ModelComparison: {self.summary or 'the outputs are constant'}>"


@takes(CompareOptions)
def compare(
    models: Any = None,
    data: Any = None,
    *,
    records: Mapping[str, Source] | Sources | None = None,
    methods: Mapping[str, Method] | Iterable[Method] | Method | None = None,
    operators: str | Iterable[str] | None = None,
    structures: str | Iterable[str] | None = None,
    small_signal: Sources = (),
    record: str | None = None,
    progress: Progress = None,
    **options: Unpack[CompareOptions],
) -> ModelComparison:
    """Compares free runs on the same records: of models that exist, `compare(models, data)`, or of methods that are
    fitted to one part of the records and compared on the rest, `compare(records, methods, operators=...)`.

    models, data: models and records in dicts by their names (not a record as a dict of its columns), or in lists. Files
    in lists are called by their names, models by their operators, and records by their numbers.
    record: name of the record whose loops and residuals are drawn on the page; default: the first

    It is the second form if `operators` or `structures` are given, if the second argument has a function or a model, or
    with the keywords `records` and `methods`. A method that fails has a reason in the result.

    records: training records. No method gets the end of each, a share `held_out`, on which all are compared; `data=` are
    other records for the comparison, and then nothing is held out
    methods: functions f(train) -> g. train is a list of `Record`, the training parts in the order of the records, then
    those of `small_signal`; g(u) returns the displacements for the whole input of a record, an array (n,), of which the
    held-out end counts: g sees the input before it, but never the output. g may have an attribute `parameters`, their
    number, and may be an object with a method simulate(u). A function whose first parameter is called u is a g itself,
    and so is an object with simulate(u). Models and their files are compared as they are
    operators, structures: what is identified, names as for the command `piezoid compare`: operators="all", or
    operators=["preisach", "auto"], structures=["hammerstein", "linear"]
    progress: as for `identify`. If Ctrl-C or an exception stops the work, the exception has what was compared until then
    as its attribute `compared`

    {options}

    >>> import piezoid as pz
    >>> def gain(k):
    ...     block = {"a": [0.5], "b": [0.5 * k]}
    ...     hysteresis = {"operator": "proportional", "gain": 1.0}
    ...     return pz.Model.from_dict({"piezoid": 1, "ts": 1e-3, "hysteresis": hysteresis, "linear": block})
    >>> u = pz.excite.sine(ts=1e-3, duration=1, amplitude=20, frequency=5)
    >>> measured = pz.Record(u, 2.1 * u, ts=1e-3)
    >>> compared = pz.compare({"two": gain(2), "three": gain(3)}, {"sine": measured})
    >>> compared.best
    'two'
    >>> def regression(train):
    ...     k = (train[0].u @ train[0].y) / (train[0].u @ train[0].u)
    ...     return lambda u: k * u
    >>> compared = pz.compare(measured, {"mine": regression, "double": lambda u: 2 * u, "three": gain(3)})
    >>> list(compared.ranking.index)
    ['mine', 'double', 'three']
    """
    settings = {"record": record, **known(compare, options)}
    is_contest = any(one is not None for one in (records, methods, operators, structures)) or _has_methods(data)
    if not is_contest:
        one = [models] if isinstance(models, (Model, str, os.PathLike)) else models
        cores = _named("models", () if one is None else one, as_model, lambda model, _: as_model(model).operator)
        measured = _named("data", *_records(() if data is None else data))
        return ModelComparison(*_piezoid.compare(cores, measured, settings))
    positional, validation = (models, data) if records is None else (records, data)
    if methods is None and (records is None and _has_methods(data)):
        methods, validation = data, None
    settings |= {"operators": _joined(operators), "structures": _joined(structures)}
    training = _named("records", *_records(() if positional is None else positional))
    tests = [] if validation is None else _named("data", *_records(validation))
    small = [(f"small signal {k}", as_record(one)._core) for k, one in enumerate(sources(small_signal), 1)]
    called = _called(methods)
    parts, compared = _piezoid.split((training, small, tests), [name for name, _ in called], settings)
    train = [Record._of(core) for core in [*parts, *(core for _, core in small)]]
    inputs = [core.u for core, _ in compared]
    known_models, others = [], []
    for name, method in called:
        if isinstance(method, (Model, str, os.PathLike)):
            known_models.append((name, as_model(method)._core))
        else:
            others.append((name, *_simulated(method, train, inputs)))
    with watched(progress) as watch:
        try:
            return _shown(_piezoid.contest(known_models, (training, small, tests), settings, others, watch))
        except BaseException as stopped:
            until_then = getattr(stopped, "compared", None)
            if isinstance(until_then, tuple):
                stopped.compared = _shown(until_then)  # type: ignore[attr-defined]
            raise


def _shown(found: tuple[Any, ...]) -> ModelComparison:
    figures, page, drawing, times = found
    return ModelComparison(figures, page, drawing, {name: (fit, step) for name, fit, step in times})


def _simulated(
    method: Any, train: list[Record], inputs: list[Any]
) -> tuple[tuple[list[Any], str | None], int | None, float | None, float | None]:
    """The free runs of a method, or the reason why there are none; its number of parameters, and its times."""
    try:
        start, fit = perf_counter(), None
        is_fit = not hasattr(method, "simulate") or isinstance(method, type)
        if is_fit and not _maps_inputs(method):
            method = method(train)
            fit = perf_counter() - start
        run = method.simulate if hasattr(method, "simulate") else method
        if not callable(run):
            raise TypeError(f"the fit returned {type(run).__name__}: return a function of u")
        start = perf_counter()
        runs = [run(u) for u in inputs]
        step = 1e9 * (perf_counter() - start) / sum(len(u) for u in inputs)
        parameters = getattr(method, "parameters", None)
        return (runs, None), None if parameters is None else int(parameters), fit, step
    except Exception as error:
        return ([], f"{type(error).__name__}: {error}"), None, None, None


def _maps_inputs(method: Any) -> bool:
    """True for a function whose first parameter is called u."""
    try:
        return next(iter(signature(method).parameters), "") == "u"
    except (TypeError, ValueError):
        return False


def _has_methods(values: Any) -> bool:
    """True if there is a function, a model or a simulator among them."""
    several = values.values() if isinstance(values, Mapping) else values if isinstance(values, (list, tuple)) else [values]
    return any(callable(one) or hasattr(one, "simulate") for one in several)


def _called(methods: Any) -> list[tuple[str, Any]]:
    """Methods with their names."""
    if methods is None:
        return []
    if isinstance(methods, Mapping):
        return [(str(name), one) for name, one in methods.items()]
    several = methods if isinstance(methods, (list, tuple)) else [methods]
    files = (str, os.PathLike)
    named = [Path(one).name if isinstance(one, files) else getattr(one, "__name__", type(one).__name__) for one in several]
    return list(zip(named, several))


def _joined(names: str | Iterable[str] | None) -> str | None:
    if names is None:
        return None
    several = [names] if isinstance(names, str) else list(names)
    if not several:
        raise PiezoidError("there are no names: leave operators and structures out, or name one")
    return ",".join(map(str, several))


def _records(values: Any) -> tuple[Any, Callable[[Any], Any], Callable[[Any, int], str]]:
    """Records for `_named`."""
    several = values if isinstance(values, Mapping) else sources(values)
    return several, as_record, lambda _, number: f"record {number}"


def _named(
    what: str, values: Mapping[str, Any] | Iterable[Any], read: Callable[[Any], Any], name: Callable[[Any, int], str]
) -> list[tuple[str, Any]]:
    """The cores of the members with their names; those of a list are called by their files, or by `name`."""
    if isinstance(values, Mapping):
        named = [(str(key), one) for key, one in values.items()]
    else:
        files = (str, os.PathLike)
        named = [(Path(one).name if isinstance(one, files) else name(one, k), one) for k, one in enumerate(values, 1)]
    if not named:
        raise _piezoid.PiezoidError(f"{what} is empty: give one at least")
    called = [key for key, _ in named]
    unique = [key if called.count(key) == 1 else f"{key} ({called[: k + 1].count(key)})" for k, key in enumerate(called)]
    return [(key, read(one)._core) for key, (_, one) in zip(unique, named)]
