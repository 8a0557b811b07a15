"""Fleets: thousands of actuators identified, validated and compensated, with one row of a DataFrame per actuator.

>>> import piezoid as pz
>>> u = pz.excite.rising_sine(ts=1e-3, duration=1, amplitude=28, frequency=4)
>>> twins = {f"stage {i}": pz.plants["pl140"].drawn(0.2, index=i) for i in range(3)}
>>> records = {name: twin.measure(u, ts=1e-3) for name, twin in twins.items()}
>>> table = pz.fleet.identify(records, operator="prandtl-ishlinskii", order=2)
>>> list(table.index), bool(table.error.isna().all())
(['stage 0', 'stage 1', 'stage 2'], True)

`client` selects where the work is done: in this process (None), on Dask (a `distributed.Client`), or on any
`concurrent.futures.Executor`: Python's threads and processes, loky's, mpi4py's. For Ray, three lines define one:

    class OnRay(concurrent.futures.Executor):
        def submit(self, function, *args):
            return ray.remote(function).remote(*args).future()

Jobs are sent by pickle. A record may be a file, or a function without arguments that returns the record. Both are read
where the work is done, so ten thousand records need not pass through one machine.

A failed job does not stop the others, and no job is lost: the text of its exception is the column `error` of its row. A
`PiezoidError` or `TypeError` is final. After any other failure, such as an unavailable file share or a worker that
died, the job is tried again. Dask gives the work of a dead worker to others. A pool of Python's is unusable when one of
its processes has died: the finished rows remain, and the others have an error. Results do not depend on where they were
computed, nor on how often work was lost.

A worker process should have one thread, and RAYON_NUM_THREADS=1 in its environment. Otherwise each process uses all
cores, and they slow each other down: short fits take a fifth longer with 16 threads per core. `local` starts such
workers. A process that was forked after its parent identified something uses one thread without this setting.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from concurrent import futures
from contextlib import contextmanager, suppress
from functools import partial
from inspect import signature
from math import ceil, isnan
from platform import node
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from ._checks import whole
from ._piezoid import PiezoidError
from ._keywords import known, takes
from ._options import CompensateOptions, ValidateOptions
from ._progress import watched
from ._types import Progress
from .identify import identify as _identify
from .model import Model, as_model
from .records import Record, as_records, read_reference

if TYPE_CHECKING:
    import distributed
    import pandas as pd
    from typing_extensions import Unpack

Row: TypeAlias = dict[str, Any]
"""The columns of one actuator."""

_ALWAYS = ["attempts", "seconds", "worker", "error"]
_FIGURES = ["nrmse_percent", "rms_pp_percent", "rmse", "max_abs"]
_SOURCES = ["small_signal", "large_signal", "data", "test", "linear", "rich"]

_TRAINING = [("large_signal", "rich", "data"), ("small_signal", "linear")]


class Engine(Protocol):
    """An object that does the work: a `distributed.Client` or a `concurrent.futures.Executor`."""

    def submit(self, function: Callable[..., Any], /, *args: Any) -> Any:
        """Starts `function(*args)` and returns its future."""


def identify(
    actuators: Mapping[Any, Any] | pd.Series[Any] | pd.DataFrame,
    client: Engine | None = None,
    *,
    retries: int = 2,
    chunk: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> pd.DataFrame:
    """Identifies a model of each actuator, by name; `validate` and `compensate` accept `table.model`.

    actuators: by name, the keywords of `pz.identify`: records as `small_signal`, `large_signal` or `data`, settings of
    this actuator, and `test`: records on which the errors are computed (by default the training records). A single
    record is `data`. A function without arguments may replace any of these. A DataFrame has one row per actuator, and
    these keywords as columns.
    settings: those of `pz.identify`, for all actuators
    retries, chunk, progress: see `run`

    Columns: `model` (missing after an error), `operator`, `resonance_hz` and `damping` of the linear block, its
    `dc_gain` [output unit / input unit], the largest `nrmse_percent`, `rms_pp_percent`, `rmse` and `max_abs` [output
    unit] among the records, and the columns of `run`.
    """
    signature(_identify).bind(**settings)
    job = partial(_identified, settings)
    if hasattr(actuators, "columns"):  # one row per actuator
        columns: Any = actuators
        actuators = {name: dict(row) for name, row in zip(columns.index, columns.to_dict("records"), strict=True)}
        if len(actuators) < len(columns):
            raise PiezoidError(f"{len(columns)} rows have {len(actuators)} names: give each its own")
    table = run(job, actuators, client, retries=retries, chunk=chunk, progress=progress)
    return table.reindex(columns=["model", "operator", "resonance_hz", "damping", "dc_gain", *_FIGURES, *_ALWAYS])


@takes(ValidateOptions)
def validate(
    models: Mapping[Any, Any] | pd.Series[Any],
    records: Mapping[Any, Any] | pd.Series[Any],
    client: Engine | None = None,
    *,
    retries: int = 2,
    chunk: int | None = None,
    progress: Progress = None,
    **options: Unpack[ValidateOptions],
) -> pd.DataFrame:
    """Compares each model with records of its actuator, preferably ones that were not used for identification.

    models: by name, models or their files; records: by name, one or several, or a function that returns them
    options: those of `Model.validate`; retries, chunk, progress: see `run`

    Columns: `nrmse_percent`, `rms_pp_percent`, `rmse` and `max_abs` [output unit], the largest among the records, and
    the columns of `run`. An actuator with a model but no record, or with a record but no model, has a row with an
    error.
    """
    job = partial(_validated, known(validate, options))
    table = run(job, _paired(models, records), client, retries=retries, chunk=chunk, progress=progress)
    return table.reindex(columns=[*_FIGURES, *_ALWAYS])


@takes(CompensateOptions)
def compensate(
    models: Mapping[Any, Any] | pd.Series[Any],
    references: Any,
    client: Engine | None = None,
    *,
    retries: int = 2,
    chunk: int | None = None,
    progress: Progress = None,
    **settings: Unpack[CompensateOptions],
) -> pd.DataFrame:
    """Computes the voltages for a requested displacement of each actuator.

    models: by name, models or their files
    references: one for all, of shape (n,) [output unit], a file, or a function that returns either; or a mapping of
    these by name
    settings: those of `Model.compensation`; retries, chunk, progress: see `run`

    Columns: `u` [input unit] and `reached` [output unit], of shape (n,), `clipped`, the number of samples clipped to a
    limit, `notes`, and the columns of `run`.
    """
    named = isinstance(references, Mapping) or (hasattr(references, "items") and references.dtype == object)  # a Series
    own = references if named else dict.fromkeys(dict(_items(models, "models")), references)
    job = partial(_compensated, known(compensate, settings))
    table = run(job, _paired(models, own), client, retries=retries, chunk=chunk, progress=progress)
    return table.reindex(columns=["u", "reached", "clipped", "notes", *_ALWAYS])


def run(
    function: Callable[[Any], Any],
    jobs: Mapping[Any, Any] | pd.Series[Any],
    client: Engine | None = None,
    *,
    retries: int = 2,
    chunk: int | None = None,
    progress: Progress = None,
) -> pd.DataFrame:
    """Calls `function(job)` for each job: one row per job, with the names and in the order of `jobs`.

    function: returns the columns of a row as a mapping; any other result is the column `value`
    retries: how often a failed job is repeated, as a separate task; not after a `PiezoidError` or `TypeError`
    chunk: number of jobs per task of the engine, whose overhead is about a millisecond; by default up to 16
    progress: as in `pz.identify`, called with the number of finished jobs; an exception that it raises cancels the jobs
    that have not started

    Columns in addition to those of `function` (they replace columns of the same name): `attempts`, `seconds` of the
    last one, `worker` (machine and process), and `error`, a text, missing if the job succeeded.

    >>> import piezoid as pz
    >>> table = pz.fleet.run(lambda x: {"inverse": 1 / x}, {"a": 2, "b": 0})
    >>> table.error["b"]
    'ZeroDivisionError: division by zero'
    """
    import pandas as pd

    named = dict(_items(jobs, "jobs"))
    if len(named) < len(jobs):
        raise PiezoidError(f"the names of the {len(jobs)} jobs are not all different: give each job its own name")
    whole("retries", retries)
    if chunk is not None:
        whole("chunk", chunk, least=1)
    values, rows, settled = list(named.values()), [Row() for _ in named], 0
    size = chunk or _chunk(client, len(values))
    batches = [range(len(values))[start : start + size] for start in range(0, len(values), size)]
    with watched(progress) as watch:
        for attempt in range(1, retries + 2):
            again = []
            for batch, outcomes in _done(client, function, values, batches):
                for at, (row, is_final) in zip(batch, outcomes, strict=True):
                    rows[at] = row | {"attempts": attempt}
                    if is_final or attempt > retries:
                        settled += 1
                    else:
                        again.append(range(at, at + 1))
                if watch is not None:
                    watch("fleet", settled, len(values))
            batches = again
    columns = [*dict.fromkeys(name for row in rows for name in row if name not in _ALWAYS), *_ALWAYS]
    index = pd.Index(list(named), name="actuator", tupleize_cols=False)
    return pd.DataFrame({name: [row.get(name) for row in rows] for name in columns}, index=index)


@contextmanager
def local(workers: int | None = None, **settings: Any) -> Iterator[distributed.Client]:
    """A Dask client of worker processes on this machine, with one thread each; by default one process per core.

    settings: those of `distributed.LocalCluster`

        with pz.fleet.local(4) as client:
            table = pz.fleet.identify(actuators, client)
    """
    dask = _dask()
    usual = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}, "dashboard_address": None}
    with (
        dask.LocalCluster(n_workers=workers or os.cpu_count(), **usual | settings) as cluster,
        dask.Client(cluster) as client,
    ):
        yield client


def _dask() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise PiezoidError(f"fleets on Dask need {error.name}: pip install piezoid[fleet]") from None
    return distributed


def _on_dask(client: Engine) -> bool:
    if isinstance(client, futures.Executor):
        return False
    if isinstance(client, _dask().Client):
        return True
    raise PiezoidError(f"client = {client!r}: must be a distributed.Client or a concurrent.futures.Executor")


def _chunk(client: Any, jobs: int) -> int:
    """Number of jobs per task: several tasks for each thread, so that no thread waits long for the last task."""
    if client is None:
        return 1
    threads = sum(client.nthreads().values()) if _on_dask(client) else os.cpu_count()
    return min(16, ceil(jobs / (8 * (threads or 1)))) or 1


def _done(
    client: Any, function: Callable[[Any], Any], jobs: list[Any], batches: list[range]
) -> Iterator[tuple[range, list[tuple[Row, bool]]]]:
    """Batches with the rows of their jobs, as they are finished; True marks a row that is final."""
    if client is None:
        for batch in batches:
            yield batch, _batch(function, [jobs[at] for at in batch])
        return
    submit, as_completed = client.submit, futures.as_completed
    if _on_dask(client):
        submit, as_completed = partial(client.submit, pure=False), partial(_dask().as_completed, loop=client.loop)
        try:
            client.nthreads()  # asks the scheduler: a closing client accepts tasks that are never done
        except Exception as error:
            yield from ((batch, _lost(batch, error)) for batch in batches)
            return
    running: dict[Any, range] = {}
    try:
        for batch in batches:
            try:
                running[submit(_batch, function, [jobs[at] for at in batch])] = batch
            except Exception as error:
                yield batch, _lost(batch, error)
        for future in as_completed(list(running)) if running else ():
            batch = running.pop(future)
            try:
                outcomes = future.result()
            except Exception as error:
                outcomes = _lost(batch, error)
            yield batch, outcomes
    finally:
        for future in running:
            with suppress(Exception):  # the engine may be gone
                future.cancel()


def _lost(batch: range, error: Exception) -> list[tuple[Row, bool]]:
    """Rows of a batch on which the engine failed; errors of jobs do not reach the engine."""
    return [({"error": _text(error)}, False) for _ in batch]


def _batch(function: Callable[[Any], Any], jobs: list[Any]) -> list[tuple[Row, bool]]:
    return [_row(function, job) for job in jobs]


def _row(function: Callable[[Any], Any], job: Any) -> tuple[Row, bool]:
    """The row of a job, whatever the job raises, and True if the row is final."""
    begun, row, error, is_final = perf_counter(), Row(), None, True
    try:
        result = function(job)
        row = dict(result) if isinstance(result, Mapping) else {"value": result}
    except PiezoidError as refusal:
        error = str(refusal)
    except TypeError as misuse:  # such as an unknown keyword
        error = _text(misuse)
    except KeyboardInterrupt:
        raise
    except BaseException as failure:  # a job that panics or exits must not stop the others
        error, is_final = _text(failure), False
    return row | {"seconds": perf_counter() - begun, "worker": f"{node()}/{os.getpid()}", "error": error}, is_final


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


def _identified(settings: Row, actuator: Any) -> Row:
    values = _made(actuator, "record")
    known = values if isinstance(values, Mapping) and not values.keys().isdisjoint(_SOURCES) else {"data": values}
    requested = settings | {name: _read(v) if name in _SOURCES else v for name, v in known.items() if not _is_missing(v)}
    large, small = ([r for name in names for r in requested.get(name, [])] for names in _TRAINING)
    test = requested.pop("test", None) or large or small
    model = _identify(**requested)
    resonance_hz, damping = model.resonance or (None, None)
    row = {"model": model, "operator": model.operator, "resonance_hz": resonance_hz, "damping": damping}
    return row | {"dc_gain": model.dc_gain} | _largest(model, test)


def _validated(options: Row, pair: tuple[Any, Any]) -> Row:
    return _largest(_model(pair[0]), _read(_made(pair[1], "record")), **options)


def _compensated(settings: Row, pair: tuple[Any, Any]) -> Row:
    model, reference = _model(pair[0]), _made(pair[1], "reference")
    if isinstance(reference, (str, os.PathLike)):
        reference = read_reference(reference, model)
    found = model.compensation(reference, **settings)
    return {"u": found.u, "reached": found.reached, "clipped": found.clipped, "notes": found.notes}


def _largest(model: Model, records: list[Record], **settings: Any) -> Row:
    found = [model.validate(record, **settings) for record in records]
    return {name: float(np.max([getattr(v, name) for v in found])) for name in _FIGURES}


def _paired(models: Any, others: Any) -> dict[Any, tuple[Any, Any]]:
    """Both by name, with None for a missing one."""
    left, right = dict(_items(models, "models")), dict(_items(others, "records or references"))
    return {name: (left.get(name), right.get(name)) for name in left | right}


def _items(source: Any, what: str) -> Any:
    if not hasattr(source, "items"):
        raise PiezoidError(f"a {type(source).__name__} has no names: give the {what} in a mapping from names, or a Series")
    return source.items()


def _made(source: Any, what: str) -> Any:
    """`source`, or its result if it is a function."""
    result = source() if callable(source) else source
    if _is_missing(result):
        raise PiezoidError(f"there is no {what} of this actuator: give one, or leave the actuator out")
    return result


def _is_missing(source: Any) -> bool:
    # pandas represents a missing value by NaN.
    return source is None or (isinstance(source, float) and isnan(source))


def _model(source: Any) -> Model:
    return as_model(_made(source, "model"))


def _read(source: Any) -> list[Record]:
    result = _made(source, "record")
    if isinstance(result, (list, tuple)):
        return [record for one in result for record in _read(one)]
    return as_records(result)
