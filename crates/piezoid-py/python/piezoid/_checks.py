"""Checks of settings before they are passed on."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from ._piezoid import PiezoidError


def number(name: str, value: Any) -> float:
    """Converts `value` to a number."""
    if not isinstance(value, str):
        with suppress(TypeError, ValueError):
            return float(value)
    raise PiezoidError(f"{name} = {value!r}: must be a number")


def some(name: str, value: Any, what: str) -> tuple[Any, ...]:
    """`value` as a tuple with as many members as `what` names, such as "low, high"; a list is accepted too."""
    count = what.count(",") + 1
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != count:
        raise PiezoidError(f"{name} = {value!r}: must be ({what})")
    return tuple(value)


@contextmanager
def called(**names: str) -> Iterator[None]:
    """Renames settings of the library in its errors to their names here."""
    try:
        yield
    except PiezoidError as error:
        name, value, rule = getattr(error, "setting", ("", "", ""))
        if name in names:
            raise PiezoidError(f"{names[name]} = {value}: {rule}") from None
        raise


def whole(name: str, value: Any, least: int = 0) -> int:
    """A whole number from `least` to 2^63 - 1."""
    try:
        number = operator.index(value)
    except TypeError:
        raise PiezoidError(f"{name} = {value!r}: must be a whole number") from None
    if not least <= number < 2**63:
        raise PiezoidError(f"{name} = {number}: must be a whole number from {least} to 2^63 - 1")
    return number
