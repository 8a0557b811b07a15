"""The lists of the library by name (operators, drivers, ...): each maps names to rows with a summary and a reference.

>>> import piezoid as pz
>>> "preisach" in pz.operators
True
>>> pz.drivers["ideal"].summary
'no limits'
>>> pz.actuators["p-885.51"].figures["capacitance"]
1.5e-06
>>> pz.targets["fixed"].operators["preisach"]
['model', 'feed-forward']
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from ._piezoid import PiezoidError, lists

ALL: dict[str, list[dict[str, Any]]] = lists()
"""All lists of the library."""


def described(rows: list[dict[str, Any]]) -> list[str]:
    """The meaning of options, one line each."""

    def line(row: dict[str, Any]) -> str:
        known = row["unit"] or " or ".join(map(repr, row["choices"]))
        return f"{row['name']}: {row['help']}" + (f" [{known}]" if known else "")

    return [line(row) for row in rows]


@dataclass(frozen=True)
class Row:
    """One member of a list."""

    name: str
    summary: str
    reference: str
    properties: Mapping[str, bool] = field(default_factory=dict, repr=False)
    """For operators: `minor_loops`, `rate_independent`, `wipes_out` (it has the wiping-out property), and `learned`
    (records determine its form; `auto` leaves it out)."""
    figures: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """For drivers and actuators: the figures of the data sheet in SI units, `None` where it is not known."""
    operators: Mapping[str, list[str]] = field(default_factory=dict, repr=False)
    """For export targets: what they make for each operator, "model" and "feed-forward"."""


T = TypeVar("T")


class Rows(Mapping[str, T], Generic[T]):
    """A list by names; the error on an unknown name gives the known names."""

    def __init__(self, kind: str, rows: dict[str, T]) -> None:
        self._kind, self._rows = kind, rows

    def __getitem__(self, name: str) -> T:
        try:
            return self._rows[name]
        except KeyError:
            raise PiezoidError(f"there is no {self._kind} called `{name}`: known are {', '.join(self._rows)}") from None

    def get(self, name: str, default: Any = None) -> Any:
        return self._rows.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._rows

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def _summary(self, name: str) -> str:
        return str(getattr(self._rows[name], "summary", ""))

    def __repr__(self) -> str:
        width = max(map(len, self._rows), default=0)
        return "\n".join(f"{name:{width}}  {self._summary(name)}" for name in self._rows)


def _rows(kind: str, name: str) -> Rows[Row]:
    return Rows(kind, {row["name"]: Row(**row) for row in ALL[name]})


operators = _rows("operator", "operators")
controllers = _rows("controller", "controllers")
drivers = _rows("driver", "drivers")
actuators = _rows("actuator", "actuators")
estimators = _rows("estimator", "estimators")
excitations = Rows("excitation", {e["name"]: Row(e["name"], e["summary"], e["reference"]) for e in ALL["excitations"]})
references = _rows("reference", "references")
targets = _rows("target", "targets")
