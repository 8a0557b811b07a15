"""Records: input and output sampled together, from arrays, tables and files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from . import _html, _piezoid
from ._checks import called, number, some
from ._columns import columns_of, profile_of
from ._keywords import known, takes
from ._options import ColumnOptions, PrepareOptions
from ._piezoid import PiezoidError
from ._types import Array, Samples, Units

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

    from .model import Model

    Source: TypeAlias = "Record | str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame"
    Sources: TypeAlias = "Source | Iterable[Source]"


USUAL: Units = ("V", "um")
"""Default units of arrays."""


class Record:
    """Input and output of an actuator, sampled together and evenly.

    u: input, y: output, of shape (n,) or (n, 1): anything that numpy converts to such an array; all samples finite
    ts: sampling period [s], or fs: sampling rate [Hz]
    units: of input and output, such as ("V", "nm") or {"y": "nm"}; `Model.validate` converts units of length (m, mm,
    um, nm)

    >>> import piezoid as pz
    >>> record = pz.Record([0, 1, 1], [0, 20, 33], ts=5e-4)
    >>> len(record), record.duration
    (3, 0.0015)
    """

    __slots__ = ("_core", "__weakref__")

    def __init__(
        self,
        u: Samples,
        y: Samples,
        ts: float | None = None,
        units: Units | Mapping[str, str] = USUAL,
        *,
        fs: float | None = None,
    ) -> None:
        self._core = _piezoid.Record(_series(u), _series(y), _period(ts, fs), _units(units))

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

    @takes(PrepareOptions)
    def prepare(
        self,
        *,
        start: float = 0.0,
        stop: float = float("inf"),
        input_scale: float | str | None = None,
        output_scale: float | str | None = None,
        **options: Unpack[PrepareOptions],
    ) -> Record:
        """The record as it is to be identified. Its `history` has each step, and models and files keep it.

        The steps happen in this order, whatever the order of the keywords; times are in seconds, or texts such as
        "0.5 ms":

        start, stop: the part to use
        input_scale, output_scale: factors, such as 20, or "5um/V" with the new unit
        {options}

        `decimate` and `resample` pass both channels through the same zero-phase filter, which keeps signals up to
        0.8 of the new Nyquist frequency; nothing is aliased.

        >>> import numpy as np, piezoid as pz
        >>> u = np.sin(2 * np.pi * np.arange(4000) / 400)
        >>> record = pz.Record(u, 30 * u, ts=5e-5).prepare(average=True, decimate=4)
        >>> len(record), record.ts, len(record.history)
        (100, 0.0002, 2)
        """
        settings = known(Record.prepare, options)
        scales = ["" if scale is None else str(scale) for scale in (input_scale, output_scale)]
        return Record._of(self.part(start, stop)._core.scaled(*scales).prepare(settings))

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
        return _restored, (self.u, self.y, self.ts, self.units, (self.history, self._core.origin))

    def __repr__(self) -> str:
        (low, high), (bottom, top), (u, y) = _ends(self.u), _ends(self.y), self.units
        return (
            f"<Record of {len(self)} samples every {self.ts:g} s: "
            f"{low:.4g} to {high:.4g} {u}, {bottom:.4g} to {top:.4g} {y}>"
        )

    def _repr_html_(self) -> str:
        return _html.record(self)


def _restored(u: Samples, y: Samples, ts: float, units: Units, past: tuple[list[str], str]) -> Record:
    """A record with its history and its origin."""
    return Record._of(_piezoid.Record(u, y, ts, units, past))


_ENDS = {"from": "start", "to": "stop"}
"""The library's names for the ends of a part."""


def _units(units: Any, usual: Units = USUAL) -> Units:
    """Units of input and output, from a pair, or from a mapping that may leave one of them out."""
    if isinstance(units, Mapping):
        if not set(units) <= {"u", "y"}:
            raise PiezoidError(f"units = {dict(units)!r}: must name u and y, such as {{'u': 'V', 'y': 'um'}}")
        units = units.get("u", usual[0]), units.get("y", usual[1])
    u, y = some("units", units, "input, output")
    if not (isinstance(u, str) and isinstance(y, str)):
        raise PiezoidError(f"units = {units!r}: must be names, such as ('V', 'um')")
    return u, y


def _series(samples: Any) -> Any:
    """Samples of shape (n, 1) as (n,): a column of a table, or of MATLAB."""
    shape: tuple[int, ...] = getattr(samples, "shape", ())
    if len(shape) == 2 and shape[1] == 1:
        return (samples.to_numpy() if hasattr(samples, "to_numpy") else samples).reshape(-1)
    return samples


def _period(ts: float | None, fs: float | None) -> float:
    """The sampling period [s], from a period or a rate."""
    if (ts is None) == (fs is None):
        raise PiezoidError("give either ts, the sampling period [s], or fs, the sampling rate [Hz]")
    if ts is not None:
        return number("ts", ts)
    rate = number("fs", fs)
    if not 0.0 < rate < float("inf"):
        raise PiezoidError(f"fs = {fs}: must be a positive number of Hz")
    return 1.0 / rate


def _ends(samples: Array) -> tuple[float, float]:
    return float(samples.min()), float(samples.max())


def as_record(source: Source) -> Record:
    """A record; reads it if `source` is not one yet."""
    return source if isinstance(source, Record) else read(source)


def sources(data: Sources | None) -> list[Source]:
    """One or several sources of records, as a list."""
    if data is None:
        return []
    if isinstance(data, (Record, str, os.PathLike, Mapping)) or hasattr(data, "columns"):
        return [cast("Source", data)]
    return list(data)


def as_records(data: Sources | None) -> list[Record]:
    """The records of one or several sources."""
    return [as_record(source) for source in sources(data)]


@takes(ColumnOptions)
def read(
    source: str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame,
    *,
    units: Units | Mapping[str, str] | None = None,
    profile: str | os.PathLike[str] | None = None,
    start: float = 0.0,
    stop: float = float("inf"),
    **columns: Unpack[ColumnOptions],
) -> Record:
    """Reads a record from a file of any format that piezoid knows, a DataFrame, or a mapping of arrays.

    Columns are found by name and unit: time `t_s`, input `u_V`, output `y_um`, but also `Zeit [s]`, `Drive (V)`,
    `Displacement/µm`. The record's `history` says what was guessed; two equally likely columns raise an error that names
    the keywords to choose.

    units: of input and output, such as ("V", "nm") or {"y": "nm"}, in place of `input_unit` and `output_unit`
    profile: a file that `inspect(...).save_profile` or `piezoid inspect -o` wrote; keywords override it
    start, stop: the part to read [s]

    {options}

    >>> import numpy as np, piezoid as pz
    >>> record = pz.read({"Time (ms)": np.arange(3), "Drive": [0, 1, 2], "Position (nm)": [0, 9, 20]}, input_scale=10)
    >>> record.ts, record.units, record.u
    (0.001, ('V', 'nm'), array([ 0., 10., 20.]))
    """
    settings, held, rig = known(read, columns), columns_of(source), profile_of(profile)
    # What is not cut does not stand in the history.
    settings["from"], settings["to"] = number("start", start) or None, None if number("stop", stop) == float("inf") else stop
    with held.named(), called(**_ENDS):
        record = Record._of(held.core.record(settings, rig))
    return record if units is None else Record._of(record._core.with_units(_units(units, record.units)))


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
    columns = columns_of(source)
    with columns.named():
        own, r = columns.core.reference({"ts": ts, "output_col": output_col, "time_col": time_col}, model.units[1])
        _same_sampling(model, "reference", own)
    return r


def read_input(source: Any, model: Model, *, input_col: str | int | None = None) -> Array:
    """The input of a table for a model, in its unit, of shape (n,); its sampling period must be that of the model."""
    columns = columns_of(source)
    with columns.named():
        own, u = columns.core.input({"input_col": input_col}, (model.units[0], model.ts))
        _same_sampling(model, "input", own)
    return u


def _same_sampling(model: Model, what: str, own: float) -> None:
    if abs(own - model.ts) > 1e-6 * model.ts:
        raise PiezoidError(f"the model is sampled every {model.ts:g} s but the {what} every {own:g} s: resample it")
