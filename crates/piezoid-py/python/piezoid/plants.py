"""Simulated actuators: twins with driver, hysteresis, creep, beam and sensor, and stand-ins for measured ones."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._piezoid import PiezoidError
from ._checks import called, number, whole
from ._keywords import known, takes
from ._options import SimulateOptions
from ._types import Array, Samples
from .lists import ALL, Rows
from .records import Record

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Plant:
    """A simulated actuator: a twin with its driver and sensor, from volts to micrometres, or a `stand_in`.

    The voltages of benders are relative to the middle of the supply; other actuators have those of their data sheets.

    >>> import piezoid as pz
    >>> record = pz.plants["paper"].measure([30.0] * 200, ts=5e-4)
    >>> bool(record.y[-1] > 900)
    True
    """

    def __init__(self, values: Mapping[str, Any] | str, name: str = "plant") -> None:
        """From its parameters: a dict, as `to_dict` returns it, or a JSON text."""
        try:
            self._core = _piezoid.Plant.from_json(values if isinstance(values, str) else json.dumps(values))
        except (PiezoidError, TypeError) as error:
            message = str(error).split("; start from")[0]
            remedy = "start from pz.plants['pl140'].to_dict()"
            raise PiezoidError(f"these are not the parameters of a plant: {message}; {remedy}") from None
        self.name = name

    @takes(SimulateOptions)
    def simulate(self, u: Samples, ts: float | None = None, **options: Unpack[SimulateOptions]) -> Array:
        """Sensor readings [um] for the voltages `u` [V], both of shape (n,), sampled every `ts` [s].

        `ts` is 0.5 ms by default; a stand-in has the sampling period and the units of its records. A `UserWarning` names the limits that were reached.

        {options}
        """
        return self._run(u, ts, known(Plant.simulate, options))[0]

    @takes(SimulateOptions)
    def measure(self, u: Samples, ts: float | None = None, **options: Unpack[SimulateOptions]) -> Record:
        """The same as a record."""
        y, ts = self._run(u, ts, known(Plant.measure, options))
        return Record(u, y, ts, units=self._core.units)

    def _run(self, u: Samples, ts: float | None, options: dict[str, Any]) -> tuple[Array, float]:
        ts = number("ts", ts) if ts is not None else self._core.ts or 5e-4
        y, reached = self._core._measured(u, ts, options)
        if reached is not None:
            warnings.warn(f"{self.name}: {reached}", stacklevel=3)
        return y, ts

    def drawn(self, tolerance: float = 0.2, *, seed: int = 0, index: int = 0) -> Plant:
        """A random plant whose parameters differ from these by up to the fraction `tolerance`.

        This corresponds to the tolerance of a catalogue. `seed` and `index` select it. The draws of a stand-in differ in
        gain by up to `tolerance`, and have the spread of its records.
        """
        with called(share="tolerance"):
            core = self._core.drawn(number("tolerance", tolerance), whole("seed", seed), whole("index", index))
        return Plant._of(core, f"{self.name}-{index}")

    @classmethod
    def _of(cls, core: _piezoid.Plant, name: str) -> Plant:
        result = cls.__new__(cls)
        result._core, result.name = core, name
        return result

    def __str__(self) -> str:
        return self._core.sentence or repr(self)

    def to_dict(self) -> dict[str, Any]:
        """Its parameters as a dict, from which `Plant` makes another plant."""
        values: dict[str, Any] = json.loads(self._core.to_json())
        return values

    def __reduce__(self) -> tuple[Any, ...]:
        return Plant, (self._core.to_json(), self.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and self._core == other._core

    def __hash__(self) -> int:
        return hash(self._core.to_json())

    def __repr__(self) -> str:
        return f"<Plant {self.name}>"


class _Presets(Rows[Plant]):
    """Plants by name."""

    def __init__(self) -> None:
        self._summaries = {row["name"]: row["summary"] for row in ALL["plants"]}
        super().__init__("plant", {name: _preset(name) for name in self._summaries})

    def _summary(self, name: str) -> str:
        return str(self._summaries[name])


def _preset(name: str) -> Plant:
    return Plant._of(_piezoid.Plant.named(name), name)


plants: Rows[Plant] = _Presets()
"""The available plants."""
