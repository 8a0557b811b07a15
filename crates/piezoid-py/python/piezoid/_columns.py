"""Columns of a source: a file, a DataFrame, a mapping of arrays."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _files, _piezoid
from ._piezoid import PiezoidError

Profile = tuple[str, str]
"""A profile of a rig: the name of its file, and its text."""


def profile_of(path: str | os.PathLike[str] | None) -> Profile | None:
    """The profile in a file."""
    if path is None:
        return None
    try:
        return str(path), _files.read(path).decode()
    except UnicodeDecodeError:
        raise PiezoidError(f"{path}: this is no profile: it is not a text file (UTF-8)") from None


@dataclass(frozen=True)
class Columns:
    """The columns of a source."""

    core: _piezoid.Columns
    about: str = ""
    """The name of a file, with which errors begin."""
    name: str = "arrays"
    """The name of the source."""

    @contextmanager
    def named(self) -> Iterator[None]:
        """Adds the source of the columns to errors."""
        try:
            yield
        except PiezoidError as error:
            raise PiezoidError(f"{self.about}{error}") from None


def columns_of(source: Any) -> Columns:
    if isinstance(source, (str, os.PathLike)):
        path = Path(source)
        with _files.named(path):
            _files.warn_of_unfinished(path)
            return Columns(_piezoid.Columns.from_file(path), f"{path}: ", str(path))
    if hasattr(source, "columns"):
        return replace(_arrays(_frame(source)), name=type(source).__name__)
    if isinstance(source, Mapping):
        return replace(_arrays({str(name): values for name, values in source.items()}), name=type(source).__name__)
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


def _arrays(columns: dict[str, Any]) -> Columns:
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
    return Columns(_piezoid.Columns.from_arrays(vectors, others))


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
