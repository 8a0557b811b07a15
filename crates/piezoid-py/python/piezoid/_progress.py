"""Progress of long work: as a bar, or passed to a function."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from ._piezoid import PiezoidError
from ._types import Progress, OnProgress


@contextmanager
def watched(progress: Progress) -> Iterator[OnProgress | None]:
    """Yields what the library calls as work advances: temporary bars, the caller's bar or function, or None."""
    if progress is None or progress is False:
        yield None
    elif progress is True or (isinstance(progress, type) and hasattr(progress, "update")):
        bars = _Bars(_tqdm() if progress is True else progress)
        try:
            yield bars
        finally:
            bars.close()
    elif hasattr(progress, "update") and hasattr(progress, "n"):
        yield partial(_advance, progress)
    elif callable(progress):
        yield _Results(progress) if hasattr(progress, "found") else progress
    else:
        raise PiezoidError(f"progress = {progress!r}: must be True, a bar of tqdm, or a function of (what, done, total)")


def _tqdm() -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError as error:
        raise PiezoidError(f"a bar needs {error.name}: pip install piezoid[progress], or give a function") from None
    return tqdm


def _advance(bar: Any, what: str, done: int, total: int) -> None:
    """Moves a bar; moves it back when the next kind of work begins."""
    bar.total = total
    if hasattr(bar, "set_description"):
        bar.set_description(what, refresh=False)
    bar.update(done - bar.n)


class _Results:
    """The caller's object, which gets what is found too."""

    def __init__(self, watch: Any) -> None:
        self.watch: Any = watch

    def __call__(self, what: str, done: int, total: int) -> None:
        self.watch(what, done, total)

    def found(self, what: str, figures: dict[str, float], core: Any, best: bool) -> None:
        from .model import Model

        self.watch.found(what, figures, None if core is None else Model._of(core), best)


class _Bars:
    """One bar per kind of work, one after the other."""

    def __init__(self, make: Any) -> None:
        self.make: Any = make
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
