"""Files that are whole or not there: written beside and renamed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from ._piezoid import PiezoidError


def write(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Writes a file; what stood there before stays until the new one is whole."""
    path = Path(path)
    data = content.encode() if isinstance(content, str) else content
    try:
        mode = path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask()
        handle, beside = tempfile.mkstemp(dir=path.parent, prefix=".piezoid-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.chmod(beside, mode)
            os.replace(beside, path)
        except BaseException:
            os.unlink(beside)
            raise
    except OSError as error:
        raise PiezoidError(f"cannot write {path}: {error.strerror or error}: name another place") from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def read(path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file."""
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise PiezoidError(f"{path}: there is no such file: check its name and folder") from None
    except OSError as error:
        raise PiezoidError(f"{path}: cannot be read: {error.strerror or error}") from error
