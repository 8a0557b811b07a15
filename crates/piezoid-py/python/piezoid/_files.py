"""Files: read with helpful errors, and written completely or not at all."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from . import _piezoid
from ._piezoid import PiezoidError


@contextmanager
def named(path: str | os.PathLike[str]) -> Iterator[None]:
    """Adds the name of the file to the beginning of errors."""
    try:
        yield
    except PiezoidError as error:
        message = str(error)
        raise PiezoidError(message if message.startswith(str(path)) else f"{path}: {message}") from None


def write(path: str | os.PathLike[str], text: str) -> None:
    """Writes a file; an existing file stays until the new one is complete."""
    _piezoid.write(path, text.encode())


def warn_of_unfinished(path: str | os.PathLike[str]) -> None:
    """Warns of a file of a run that was ended before it had written all files of its set."""
    if why := _piezoid.unfinished(path):
        warnings.warn(why, stacklevel=4)


def read(path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file."""
    warn_of_unfinished(path)
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise PiezoidError(f"{path}: there is no such file: check its name and folder") from None
    except OSError as error:
        raise PiezoidError(f"{path}: cannot be read: {error.strerror or error}") from error
