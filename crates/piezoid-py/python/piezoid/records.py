"""Records: input and output sampled together, from arrays, tables and files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from . import _files, _html, _piezoid
from ._checks import called, number, some
from ._piezoid import PiezoidError
from ._types import Array, Samples, Units

if TYPE_CHECKING:
    import pandas as pd

    from .model import Model

    Source: TypeAlias = "Record | str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame"
    Sources: TypeAlias = "Source | Iterable[Source]"


class Record:
    """Input and output of an actuator, sampled together and evenly.

    u: input, of shape (n,); y: output, of shape (n,), anything that numpy converts to such an array; all samples finite
    ts: sampling period [s]
    units: of input and output; units of length (m, mm, um, nm) are converted automatically

    >>> import piezoid as pz
    >>> record = pz.Record([0, 1, 1], [0, 20, 33], ts=5e-4)
    >>> len(record), record.duration
    (3, 0.0015)
    """

    __slots__ = ("_core", "__weakref__")

    def __init__(self, u: Samples, y: Samples, ts: float, units: Units = ("V", "um")) -> None:
        self._core = _piezoid.Record(u, y, number("ts", ts), _units(units))

    @classmethod
    def _of(cls, core: _piezoid.Record) -> Record:
        record = cls.__new__(cls)
        record._core = core
        return record

    @property
    def ts(self) -> float:
        """Sampling period [s]."""
        return self._core.ts

    @property
    def u(self) -> Array:
        """Input, of shape (n,); read-only."""
        return self._core.u

    @property
    def y(self) -> Array:
        """Output, of shape (n,); read-only."""
        return self._core.y

    @property
    def t(self) -> Array:
        """Times [s], of shape (n,), from 0."""
        return np.arange(len(self), dtype=np.float64) * self.ts

    @property
    def units(self) -> Units:
        """Units of input and output."""
        return self._core.units

    @property
    def history(self) -> list[str]:
        """How the record was made: the columns that were guessed, scales, cuts, the steps of `prepare`."""
        return self._core.history

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self._core.duration

    def part(self, start: float = 0.0, stop: float = float("inf")) -> Record:
        """The part from `start` to `stop` [s], counted from the first sample."""
        with called(**_ENDS):
            return Record._of(self._core.part(number("start", start), number("stop", stop)))

    def prepare(
        self,
        *,
        start: float = 0.0,
        stop: float = float("inf"),
        input_scale: float | str | None = None,
        output_scale: float | str | None = None,
        input_offset: float = 0.0,
        output_offset: float = 0.0,
        outliers: bool = False,
        detrend: Literal["mean", "line"] | None = None,
        average: bool = False,
        period: float | str | None = None,
        delay: float | str | None = None,
        decimate: int | None = None,
        resample: float | str | None = None,
    ) -> Record:
        """The record as it is to be identified. Its `history` tells each step, and models and files keep it.

        The steps happen in this order, whatever the order of the keywords; times are in seconds, or texts such as
        "0.5 ms":

        start, stop: the part to use
        input_scale, output_scale: factors, such as 20, or "5um/V" with the new unit
        input_offset, output_offset: added after the scale, in its unit
        outliers: replace single spikes of y by interpolation
        detrend: subtract the mean or a straight line from y
        average: the mean of all periods, one period long; `period`, if it is not found in the input
        delay: y is shifted earlier by it against u, later if it is negative
        decimate: keep one of so many samples; resample: a new sampling period. Both channels pass the same filter
        without phase, which keeps signals up to 0.8 of the new Nyquist frequency; nothing above it folds back

        >>> import numpy as np, piezoid as pz
        >>> u = np.sin(2 * np.pi * np.arange(4000) / 400)
        >>> record = pz.Record(u, 30 * u, ts=5e-5).prepare(average=True, decimate=4)
        >>> len(record), record.ts, len(record.history)
        (100, 0.0002, 2)
        """
        given = {
            "input_offset": input_offset,
            "output_offset": output_offset,
            "outliers": outliers,
            "detrend": detrend,
            "average": average,
            "period": period,
            "delay": delay,
            "decimate": decimate,
            "resample": resample,
        }
        scales = ["" if scale is None else str(scale) for scale in (input_scale, output_scale)]
        return Record._of(self.part(start, stop)._core.scaled(*scales).prepare(given))

    def output_in(self, unit: str) -> Record:
        """The same record with its output in another unit of length."""
        return Record._of(self._core.output_in(unit))

    def to_frame(self) -> pd.DataFrame:
        """A DataFrame with the columns `u_V` and `y_um` (or other units), and the times as its index `t_s`."""
        import pandas as pd

        columns = {f"u_{self.units[0]}": self.u, f"y_{self.units[1]}": self.y}
        return pd.DataFrame(columns, index=pd.Index(self.t, name="t_s"))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file that `read` and the command line accept: CSV, or `.npz` or `.mat` by the extension."""
        self._core.save(path)

    def __len__(self) -> int:
        return len(self._core)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._core == other._core

    def __hash__(self) -> int:
        u, y = (samples + 0.0 for samples in (self.u, self.y))  # -0.0 equals 0.0
        return hash((self.ts, self.units, u.tobytes(), y.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.u, self.y, self.ts, self.units, self.history)

    def __repr__(self) -> str:
        (low, high), (bottom, top), (u, y) = _ends(self.u), _ends(self.y), self.units
        return (
            f"<Record of {len(self)} samples every {self.ts:g} s: "
            f"{low:.4g} to {high:.4g} {u}, {bottom:.4g} to {top:.4g} {y}>"
        )

    def _repr_html_(self) -> str:
        return _html.record(self)


def _restored(u: Samples, y: Samples, ts: float, units: Units, history: list[str]) -> Record:
    """A record with its history."""
    return Record._of(_piezoid.Record(u, y, ts, units, history))


_ENDS = {"from": "start", "to": "stop"}
"""The library's names for the ends of a part."""


def _units(units: Any) -> Units:
    u, y = some("units", units, "input, output")
    if not (isinstance(u, str) and isinstance(y, str)):
        raise PiezoidError(f"units = {units!r}: must be names, such as ('V', 'um')")
    return u, y


def _ends(samples: Array) -> tuple[float, float]:
    return float(samples.min()), float(samples.max())


def as_record(source: Source) -> Record:
    """A record; reads it if `source` is not one yet."""
    return source if isinstance(source, Record) else read(source)


def sources(given: Sources | None) -> list[Source]:
    """One or several sources of records, as a list."""
    if given is None:
        return []
    if isinstance(given, (Record, str, os.PathLike, Mapping)) or hasattr(given, "columns"):
        return [cast("Source", given)]
    return list(given)


def as_records(given: Sources | None) -> list[Record]:
    """The records of one or several sources."""
    return [as_record(source) for source in sources(given)]


def read(
    source: str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame,
    *,
    ts: float | None = None,
    fs: float | None = None,
    input_col: str | int | None = None,
    output_col: str | int | None = None,
    time_col: str | int | None = None,
    input_unit: str | None = None,
    output_unit: str | None = None,
    time_unit: str | None = None,
    input_scale: float | str | None = None,
    output_scale: float | str | None = None,
    units: Units | None = None,
    start: float = 0.0,
    stop: float = float("inf"),
) -> Record:
    """Reads a record from a file of any format that piezoid knows, a DataFrame, or a mapping of arrays.

    Columns are found by name and unit: time `t_s`, input `u_V`, output `y_um`, but also `Zeit [s]`, `Drive (V)`,
    `Displacement/µm`. The record's `history` tells what was guessed; two equally likely columns raise an error that names
    the keywords to choose.

    ts, fs: sampling period [s] or rate [Hz], for sources without times
    input_col, output_col, time_col: names or numbers (from 1) of the columns
    input_unit, output_unit, time_unit: units that the names do not contain, or contain wrongly
    input_scale: factor of the input, such as 20 for an amplifier whose input was recorded
    output_scale: factor of the output, such as "5um/V" for a sensor
    units: of input and output, in place of `input_unit` and `output_unit`
    start, stop: the part to read [s]

    >>> import numpy as np, piezoid as pz
    >>> record = pz.read({"Time (ms)": np.arange(3), "Drive": [0, 1, 2], "Position (nm)": [0, 9, 20]}, input_scale=10)
    >>> record.ts, record.units, record.u
    (0.001, ('V', 'nm'), array([ 0., 10., 20.]))
    """
    columns = _columns(source)
    # What is not cut does not stand in the history.
    ends = {"from": number("start", start) or None, "to": None if number("stop", stop) == float("inf") else stop}
    given = {
        "ts": ts,
        "fs": fs,
        "input_col": input_col,
        "output_col": output_col,
        "time_col": time_col,
        "input_unit": input_unit,
        "output_unit": output_unit,
        "time_unit": time_unit,
        "input_scale": input_scale,
        "output_scale": output_scale,
        **ends,
    }
    with columns.named(), called(**_ENDS):
        record = Record._of(columns.core.record(given))
    return record if units is None else _restored(record.u, record.y, record.ts, _units(units), record.history)


def read_reference(
    source: str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame,
    model: Model,
    *,
    ts: float | None = None,
    output_col: str | None = None,
    time_col: str | None = None,
) -> Array:
    """Reads a requested displacement for a model, in its unit, of shape (n,), from any source that `read` accepts.

    It is the column `r_*`, or else `y_*`. Its sampling period must be that of the model.
    """
    columns = _columns(source)
    with columns.named():
        own, r = columns.core.reference({"ts": ts, "output_col": output_col, "time_col": time_col}, model.units[1])
        if abs(own - model.ts) > 1e-6 * model.ts:
            raise PiezoidError(f"the model is sampled every {model.ts:g} s but the reference every {own:g} s: resample it")
    return r


@dataclass(frozen=True)
class _Columns:
    """The columns of a source."""

    core: _piezoid.Columns
    about: str = ""
    """The name of a file, with which errors begin."""

    @contextmanager
    def named(self) -> Iterator[None]:
        """Adds the source of the columns to errors."""
        try:
            yield
        except PiezoidError as error:
            raise PiezoidError(f"{self.about}{error}") from None


def _columns(source: Any) -> _Columns:
    if isinstance(source, (str, os.PathLike)):
        path = Path(source)
        with _files.named(path):
            return _Columns(_piezoid.Columns.from_file(str(path), _files.read(path)), f"{path}: ")
    if hasattr(source, "columns"):
        return _arrays(_frame(source))
    if isinstance(source, Mapping):
        return _arrays({str(name): values for name, values in source.items()})
    if isinstance(source, np.ndarray) and source.dtype.names:
        return _arrays({field: source[field] for field in source.dtype.names})
    raise PiezoidError(
        f"an object of type {type(source).__name__} cannot be read as a record: give a file, a DataFrame, a mapping of "
        "arrays, or an array with named fields"
    )


def _frame(frame: Any) -> dict[str, Any]:
    """The columns of a DataFrame of pandas or a similar package; times and a named index are columns too."""
    columns = {str(name): frame[name].to_numpy() for name in frame.columns}
    index: Any = getattr(frame, "index", None)
    if hasattr(index, "total_seconds"):  # time differences
        columns.setdefault("t_s", index.total_seconds().to_numpy())
    elif hasattr(index, "tz"):  # points in time
        columns.setdefault("t_s", (index - index.min()).total_seconds().to_numpy())
    elif getattr(index, "name", None) is not None:
        columns.setdefault(str(index.name), index.to_numpy())
    return columns


def _arrays(columns: dict[str, Any]) -> _Columns:
    """The vectors among named arrays, including those within structures."""
    vectors: list[tuple[str, Any]] = []
    others: list[tuple[str, str]] = []
    for name, values in _flat(columns):
        if isinstance(values, np.ma.MaskedArray):
            raise PiezoidError(f"{name} is a masked array: fill it, or leave the masked samples out")
        array = _numbers(name, values)
        if array.size > 0 and array.size == max(array.shape, default=0) and array.dtype.kind in "fiub":
            # Vectors of MATLAB are matrices of one row or column.
            vectors.append((name, array.ravel()))
        elif array.size != 1:
            others.append((name, f"of shape {array.shape}, {array.dtype}"))
    return _Columns(_piezoid.Columns.from_arrays(vectors, others))


def _numbers(name: str, values: Any) -> npt.NDArray[Any]:
    """An array; objects are converted to numbers if possible, and points in time to seconds."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise PiezoidError(f"{name} is no array: {error}") from None
    if array.dtype.kind == "O":
        with suppress(TypeError, ValueError):
            return array.astype(np.float64)
    if array.dtype.kind in "mM" and array.size:
        seconds: npt.NDArray[Any] = (array - array.min()) / np.timedelta64(1, "s")
        return seconds
    return array


def _flat(columns: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and arrays; for a structure from a MATLAB file, as scipy reads it, its fields."""
    for name, values in columns.items():
        if name.startswith("__"):  # scipy's information on the file
            continue
        if isinstance(values, Mapping):
            yield from _flat(values)
        elif hasattr(values, "_fieldnames"):
            yield from _flat({field: getattr(values, field) for field in values._fieldnames})
        elif isinstance(values, np.ndarray) and values.dtype.names and values.size == 1:
            yield from _flat({field: values[field].item() for field in values.dtype.names})
        else:
            yield str(name), values
