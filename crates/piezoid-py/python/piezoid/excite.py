"""Drive signals for identification. One function per kind; `pz.excitations` lists them.

>>> from piezoid import excite
>>> u = excite.prbs(ts=5e-4, duration=2.0, amplitude=1.0)
>>> u.shape
(4000,)
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

from ._piezoid import excite as _samples
from ._types import Array
from .lists import ALL, described


class Excitation:
    """One kind of drive signal: call it with a sampling period [s], a duration [s], and the settings of the kind."""

    def __init__(self, row: dict[str, Any]) -> None:
        self.kind: str = row["name"]
        self.__name__ = self.kind.replace("-", "_")
        self.__qualname__ = f"excite.{self.__name__}"
        self.__module__ = __name__
        settings = [_setting(p) for p in row["parameters"]]
        lines = described(row["parameters"])
        self.__doc__ = "\n".join(
            [
                f"{row['summary'][:1].upper()}{row['summary'][1:]}.",
                "",
                "ts: sampling period [s]",
                "duration: length [s]; round(duration / ts) samples are made",
                *lines,
                "",
                "Returns the voltages [V], of shape (n,).",
                "",
                f"Reference: {row['reference']}",
            ]
        )
        own = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=float) for name in ("ts", "duration")]
        self.__signature__ = inspect.Signature([*own, *settings], return_annotation=Array)

    def __call__(self, *, ts: float, duration: float, **settings: float | Sequence[float]) -> Array:
        return _samples(self.kind, {"ts": ts, "duration": duration}, settings)

    def __repr__(self) -> str:
        return f"<excitation {self.__name__}{self.__signature__}>"


def _setting(row: dict[str, Any]) -> inspect.Parameter:
    default = inspect.Parameter.empty if row["required"] else row["default"]
    kind = Sequence[float] if isinstance(row["default"], list) else float
    return inspect.Parameter(row["name"], inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)


_KINDS = {row["name"].replace("-", "_"): Excitation(row) for row in ALL["excitations"]}

__all__ = [*_KINDS]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Excitation:
    try:
        return _KINDS[name]
    except KeyError:
        raise AttributeError(f"there is no excitation called {name}: known are {', '.join(_KINDS)}") from None


def __dir__() -> list[str]:
    return [*_KINDS, "Excitation"]
