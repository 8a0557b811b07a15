"""Progress of long work: as a bar, or told to a function."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ._piezoid import PiezoidError
from ._types import Progress, Told


@contextmanager
def told(progress: Progress) -> Iterator[Told | None]:
    """What the library calls as work advances: a bar that goes away at the end, a function of the caller, or nothing."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bars = _Bars()
        try:
            yield bars
        finally:
            bars.close()
    else:
        yield progress


class _Bars:
    """One tqdm bar for each kind of work, in turn."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError as error:
            raise PiezoidError(f"a bar needs {error.name}: pip install piezoid[progress], or give a function") from None

        self.make: Any = tqdm
        self.bar: Any = None
        self.what = ""

    def __call__(self, what: str, done: int, total: int) -> None:
        if self.bar is None or self.what != what or self.bar.total != total:
            self.close()
            self.bar, self.what = self.make(total=total, desc=what, leave=False), what
        self.bar.update(done - self.bar.n)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None
