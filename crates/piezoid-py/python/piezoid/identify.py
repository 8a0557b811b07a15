"""Identification of a model from records."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _piezoid
from ._keywords import known, takes
from ._options import IdentifyOptions
from ._piezoid import PiezoidError
from ._progress import watched
from ._types import Progress, Samples, Units
from .model import Model
from .records import Record, read, sources

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .records import Source, Sources


@takes(IdentifyOptions)
def identify(
    data: Sources | Samples = (),
    y: Samples | None = None,
    *,
    ts: float | None = None,
    fs: float | None = None,
    units: Units | Mapping[str, str] | None = None,
    profile: str | os.PathLike[str] | None = None,
    small_signal: Sources = (),
    large_signal: Sources = (),
    target: str | None = None,
    progress: Progress = None,
    linear: Sources = (),
    rich: Sources = (),
    **options: Unpack[IdentifyOptions],
) -> Model:
    """Identifies a model of the actuator from records; `model.notes` contains remarks.

    small_signal: records for the linear block (a PRBS of about 1 V); large_signal: records that exercise the hysteresis
    (rising sines at some frequencies); data: records for linear block and hysteresis together, if there is no
    small-signal record. Each is one record or several, or anything that `read` accepts: files, DataFrames.
    data, y: or the arrays of input and output, each of shape (n,) or (n, 1), with `ts` or `fs`
    ts, fs: sampling period [s] or rate [Hz] of arrays, and of files and DataFrames without times; units, profile:
    for every source that is not yet a `Record`, as for `read`
    target: the export target (`pz.targets`) that the model is for: only operators that it serves are tried
    progress: True shows a tqdm bar; your own bar is updated; a function is called as f(what, done, total). An exception
    that it raises stops the work, as Ctrl-C does: the best model until then is the attribute `model` of the exception.
    `pz.plot.search` draws the search; any object with a method found(what, figures, model, best) gets what is found:
    the operator, its errors, its model once its fit is finished (None until then), and if that is the best so far

    Options:

    {options}

    >>> import piezoid as pz
    >>> u = pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4)
    >>> model = pz.identify(pz.plants["pl140"].measure(u, ts=1e-3), operator="prandtl-ishlinskii", order=2)
    >>> model.operator
    'prandtl-ishlinskii'
    >>> record = pz.plants["pl140"].measure(u, ts=1e-3)
    >>> pz.identify(record.u, record.y, fs=1000, operator="prandtl-ishlinskii", order=2) == model
    True
    """
    settings = known(identify, options)
    if target is not None:
        settings["operator"] = _piezoid.served(target, settings.get("operator") or "auto")
    how: dict[str, Any] = {"ts": ts, "fs": fs, "units": units, "profile": profile}
    # linear and rich are the former names of small_signal and large_signal.
    named = [[*sources(small_signal), *sources(linear)], [*sources(large_signal), *sources(rich)], _data(data, y, how)]
    small, large, everything = [[_record(source, how)._core for source in part] for part in named]
    if everything and large:
        raise PiezoidError("large_signal is the same as data: give the records in one of them")
    with watched(progress) as watch:
        try:
            return Model._of(_piezoid.identify((small, large + everything), settings, watch))
        except BaseException as stopped:
            best = getattr(stopped, "model", None)
            if isinstance(best, _piezoid.Model):
                stopped.model = Model._of(best)  # type: ignore[attr-defined]
            raise


def _data(data: Any, y: Samples | None, how: dict[str, Any]) -> list[Source]:
    """The sources of `data`, or a record of the arrays `data` and `y`."""
    if y is not None:
        if how["profile"] is not None:
            raise PiezoidError("profile: says how columns are read, but u and y are arrays: leave it out")
        units = how["units"]
        return [Record(data, y, how["ts"], fs=how["fs"], **({} if units is None else {"units": units}))]
    if isinstance(data, np.ndarray) and not data.dtype.names:
        shape = data.shape
        raise PiezoidError(f"data is an array of shape {shape}: give input and output, as in identify(u, y, fs=2000)")
    return sources(data)


def _record(source: Source, how: dict[str, Any]) -> Record:
    return source if isinstance(source, Record) else read(source, **how)
