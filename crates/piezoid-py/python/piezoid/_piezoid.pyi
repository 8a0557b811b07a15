import os
from collections.abc import Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

from ._types import Array, Samples, Told

__version__: str


class PiezoidError(ValueError):
    """Invalid input: what is wrong, the value, where, and what to do."""

@final
class Record:
    def __new__(
        cls, u: Samples, y: Samples, ts: float, units: tuple[str, str] = ..., history: Sequence[str] = ...
    ) -> Record: ...
    @property
    def ts(self) -> float: ...
    @property
    def u(self) -> Array: ...
    @property
    def y(self) -> Array: ...
    @property
    def units(self) -> tuple[str, str]: ...
    @property
    def history(self) -> list[str]: ...
    @property
    def duration(self) -> float: ...
    def part(self, start: float, stop: float) -> Record: ...
    def scaled(self, input: str, output: str) -> Record: ...
    def prepare(self, given: dict[str, Any]) -> Record: ...
    def output_in(self, unit: str) -> Record: ...
    def save(self, path: str | os.PathLike[str]) -> None: ...
    def __len__(self) -> int: ...

@final
class Columns:
    @staticmethod
    def from_file(name: str, bytes: bytes) -> Columns: ...
    @staticmethod
    def from_arrays(columns: Sequence[tuple[str, Samples]], others: Sequence[tuple[str, str]]) -> Columns: ...
    @property
    def names(self) -> list[str]: ...
    def record(self, given: dict[str, Any]) -> Record: ...
    def reference(self, given: dict[str, Any], unit: str) -> tuple[float, Array]: ...

@final
class Model:
    @staticmethod
    def from_json(text: str) -> Model: ...
    def to_json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    @property
    def ts(self) -> float: ...
    @property
    def units(self) -> tuple[str, str]: ...
    @property
    def operator(self) -> str: ...
    @property
    def offset(self) -> float: ...
    @property
    def a(self) -> Array: ...
    @property
    def b(self) -> Array: ...
    @property
    def dc_gain(self) -> float: ...
    @property
    def resonance(self) -> tuple[float, float] | None: ...
    @property
    def input_range(self) -> tuple[float, float] | None: ...
    def response(self, hz: Samples) -> npt.NDArray[np.complex128]: ...
    def simulate(self, u: Samples, begin: str = "rest") -> Array: ...
    def predict(self, u: Samples, y: Samples) -> Array: ...
    def hidden(self, u: Samples) -> Array: ...
    def _validate(self, record: Record, given: dict[str, Any]) -> tuple[dict[str, Any], Array]: ...
    def _inverse(self, late: int, settings: dict[str, Any]) -> FeedForward: ...
    def _compensation(self, reference: Samples, settings: dict[str, Any]) -> tuple[Array, Array, dict[str, Any]]: ...

@final
class FeedForward:
    """The inverse of a model, sample by sample; it keeps its state between calls."""

    @property
    def late(self) -> int:
        """Samples by which the displacement follows the reference."""

    @property
    def ts(self) -> float:
        """Sampling period [s]."""

    def step(self, r: float) -> float:
        """The voltage for this sample of the reference."""

    def resume(self, reference: Samples) -> Array:
        """The voltages for the next samples of the reference, from the present state; both of shape (n,)."""

    def reset(self, reference: float | None = None) -> None:
        """Resets the state: at rest, or settled at `reference`."""

@final
class Plant:
    @staticmethod
    def named(name: str) -> Plant: ...
    @staticmethod
    def from_json(text: str) -> Plant: ...
    def to_json(self) -> str: ...
    def drawn(self, tolerance: float, seed: int, index: int) -> Plant: ...
    def _measured(self, u: Samples, ts: float, given: dict[str, Any]) -> tuple[Array, str | None]: ...

@final
class Arx:
    """y = a1 y1 + a2 y2 + ... + b0 u + b1 u1 + ..."""

    def __new__(cls, a: Samples, b: Samples, ts: float) -> Arx: ...
    @property
    def ts(self) -> float:
        """Sampling period [s]."""

    @property
    def a(self) -> Array:
        """Coefficients of past outputs."""

    @property
    def b(self) -> Array:
        """Coefficients of inputs."""

    @property
    def dc_gain(self) -> float:
        """Gain at 0 Hz."""

    @property
    def is_stable(self) -> bool:
        """True if all poles lie inside the unit circle."""

    @property
    def poles(self) -> list[dict[str, Any]]:
        """Frequency `hz` and `damping` of each pole, one per conjugate pair."""

    @property
    def zeros(self) -> list[dict[str, Any]]:
        """Zeros in the z plane."""

    def simulate(self, u: Samples) -> Array:
        """The free run from rest; both of shape (n,)."""

    def predict(self, u: Samples, y: Samples) -> Array:
        """Prediction one step ahead from measured outputs; all of shape (n,)."""

def identify(
    records: tuple[list[Record], list[Record]],
    given: dict[str, Any],
    made: tuple[str, str],
    progress: Told | None,
) -> Model: ...
def identify_options() -> list[dict[str, Any]]: ...
def fit(
    records: list[Record],
    orders: tuple[int, int, int],
    by: str,
    swarm: dict[str, Any],
    progress: Told | None,
) -> tuple[Arx, dict[str, Any]]: ...
def lists() -> dict[str, list[dict[str, Any]]]: ...
def excite(name: str, common: dict[str, Any], own: dict[str, Any]) -> Array: ...
def plan(
    given: dict[str, Any], model: Model | None, folder: str | os.PathLike[str] | None
) -> tuple[list[tuple[str, Array]], float, str, list[str], str | None]: ...
def plan_options() -> list[dict[str, Any]]: ...
def follow(name: str, ts: float, n: int, peak: float, hz: float) -> Array: ...
def control(
    plant: tuple[str, Plant],
    model: Model,
    references: list[tuple[str, Samples]],
    given: dict[str, Any],
    progress: Told | None,
) -> tuple[dict[str, Any], list[dict[str, Any]], str]: ...
def export(
    model: Model,
    target: str,
    given: dict[str, Any],
    reference: Samples | None,
    folder: str | os.PathLike[str] | None,
) -> tuple[list[tuple[str, bytes]], list[str]]: ...
def export_options() -> list[dict[str, Any]]: ...
def write(path: str | os.PathLike[str], content: bytes) -> None: ...
def study(
    given: dict[str, Any], progress: Told | None
) -> tuple[dict[str, Any], list[tuple[str, str]], str, str]: ...
