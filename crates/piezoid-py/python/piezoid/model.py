"""Models: free runs, validation on records, voltages for requested displacements."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _files, _html, _piezoid
from ._checks import whole
from ._checks import limits as checked
from ._piezoid import FeedForward, PiezoidError
from ._types import Array, Begin, Offset, Samples, Units
from .records import Record, as_record

if TYPE_CHECKING:
    import pandas as pd

    from ._checks import Limits, Settings, Unpack
    from .records import Source

__all__ = ["Compensation", "FeedForward", "Model", "Validation", "load"]


class Model:
    """A Hammerstein model: hysteresis, creep, then linear dynamics. It is immutable.

    `identify` creates one, `load` reads one. It can be pickled. Two models are equal if their numbers are equal,
    however they were identified.

    >>> import numpy as np, piezoid as pz
    >>> model = pz.Model.from_dict({
    ...     "piezoid": 1, "ts": 5e-4, "units": {"u": "V", "y": "um"}, "hysteresis": {"operator": "proportional", "gain": 1.0},
    ...     "linear": {"a": [1.7424, -0.9453], "b": [0.0, 3.0, 2.8]}, "offset": 2.0})
    >>> model.simulate(np.zeros(3))
    array([2., 2., 2.])
    """

    __slots__ = ("__dict__", "__weakref__", "_core")

    def __init__(self, text: str) -> None:
        """From the text of a model file."""
        if not isinstance(text, str):
            raise PiezoidError(
                f"Model takes the JSON text of a model, not a {type(text).__name__}: use Model.from_dict for a dict, "
                "pz.load for a file"
            )
        self._core = _piezoid.Model.from_json(text)

    @classmethod
    def _of(cls, core: _piezoid.Model) -> Model:
        model = cls.__new__(cls)
        model._core = core
        return model

    @classmethod
    def from_dict(cls, document: dict[str, Any]) -> Model:
        """From the content of a model file as a dict."""
        return cls(json.dumps(document, default=_plain))

    def to_dict(self) -> dict[str, Any]:
        """The content of its file as a dict."""
        return self._core.to_dict()

    def to_json(self) -> str:
        """The text of its file."""
        return self._core.to_json()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a model file, which all front ends of piezoid read."""
        _files.write(path, self.to_json())

    @property
    def ts(self) -> float:
        """Sampling period [s]."""
        return self._core.ts

    @property
    def units(self) -> Units:
        """Units of input and output."""
        return self._core.units

    @property
    def operator(self) -> str:
        """Name of the hysteresis operator."""
        return self._core.operator

    @property
    def a(self) -> Array:
        """Coefficients of the past outputs of the linear block: y = a1 y1 + a2 y2 + ... + b0 z + b1 z1 + ..."""
        return self._core.a

    @property
    def b(self) -> Array:
        """Coefficients of the inputs of the linear block [output unit / input unit]."""
        return self._core.b

    @property
    def offset(self) -> float:
        """Constant in the output [output unit]."""
        return self._core.offset

    @property
    def dc_gain(self) -> float:
        """Gain of the linear block at 0 Hz [output unit / input unit]."""
        return self._core.dc_gain

    @property
    def resonance(self) -> tuple[float, float] | None:
        """Frequency [Hz] and damping ratio of the resonance; None if there is none."""
        return self._core.resonance

    @property
    def input_range(self) -> tuple[float, float] | None:
        """Lowest and highest input of the identification data [input unit]."""
        return self._core.input_range

    @cached_property
    def provenance(self) -> dict[str, Any]:
        """Origin: command, version, seed, files with hashes, operators that were tried, parameters with errors,
        notes."""
        made = self.to_dict()["fit"]
        return made if isinstance(made, dict) else {}

    @property
    def notes(self) -> list[str]:
        """Remarks of the identification for users of the model."""
        return [str(note) for note in self._found("notes")]

    @property
    def trials(self) -> pd.DataFrame:
        """The operators that were tried, with the errors on held-out parts and in free run, and a verdict."""
        return _frame(self._found("trials"))

    @property
    def parameters(self) -> pd.DataFrame:
        """Estimated parameters (shape of the operator, creep gains, modes), with standard errors."""
        return _frame(self._found("parameters"))

    def _found(self, what: str) -> list[Any]:
        found = self.provenance.get(what)
        return found if isinstance(found, list) else []

    def simulate(self, u: Samples, *, begin: Begin = "rest") -> Array:
        """The free run: displacements [output unit] of inputs `u` [input unit], both of shape (n,).

        begin: initial condition: "rest"; "settled" at the first input, from rest, or after cycles over the whole range
        that ended with a fall ("from-above") or a rise ("from-below"); in "motion" as in `u`; or "likely": "settled" or
        "motion", chosen from `u`
        """
        return self._core.simulate(u, begin)

    def predict(self, u: Samples, y: Samples) -> Array:
        """One-step prediction of y[t] from u up to t and measured y up to t-1; all of shape (n,)."""
        return self._core.predict(u, y)

    def hidden(self, u: Samples) -> Array:
        """The hidden variable z: the output of hysteresis and creep for `u`, from rest; both of shape (n,)."""
        return self._core.hidden(u)

    def response(self, hz: Samples) -> npt.NDArray[np.complex128]:
        """The frequency response of the linear block [output unit / input unit] at `hz` [Hz], both of shape (n,)."""
        return self._core.response(hz)

    def validate(self, record: Source, *, skip: float = 0.0, offset: Offset = "kept") -> Validation:
        """Compares its free run with a record, preferably one that was not used for identification.

        record: anything that `read` accepts
        skip: time at the start that does not count [s]
        offset: "free" subtracts the mean error first, because sensors drift; "drift" a constant and a linear drift
        """
        measured = as_record(record)
        figures, simulated = self._core._validate(measured._core, {"skip": skip, "offset": offset})
        return Validation(measured, simulated, figures)

    def inverse(self, late: int = 0, **limits: Unpack[Limits]) -> FeedForward:
        """The inverse, sample by sample, from requested displacement to voltage.

        The displacement follows `late` samples later. A value that is not finite is replaced by the one before, and
        voltages beyond the limits are clipped. `driver`, `capacitance`, `low`, `high`, `slew`, `current` limit the
        voltage, as in `compensation`.
        """
        return self._core._inverse(whole("late", late), checked(limits))

    def compensate(self, reference: Samples, **settings: Unpack[Settings]) -> Array:
        """The voltages [input unit] for a requested displacement [output unit], both of shape (n,).

        They are `compensation(...).u`.
        """
        return self.compensation(reference, **settings).u

    def compensation(
        self,
        reference: Samples,
        *,
        driver: str | None = None,
        capacitance: float | None = None,
        low: float | None = None,
        high: float | None = None,
        slew: float | None = None,
        current: float | None = None,
        clip: bool = False,
        smooth: float | None = None,
        zvd: bool = False,
        notch: bool = False,
        sweeps: int = 0,
    ) -> Compensation:
        """The voltages for a requested displacement.

        Before the first sample the actuator is assumed settled at the first value of the reference.

        driver: one of `pz.drivers`, with the `capacitance` [F] of the load if it limits the current
        low, high: limits of the voltage [V]; slew: of its change [V/s]; current: of the driver [A]
        clip: come as close as the limits allow, instead of raising an error
        smooth: replace steps and corners by minimum-jerk moves of this length [s]
        zvd: shape the reference so that the resonance is not excited; notch: filter the reference with a notch at the
        resonance
        sweeps: maximum number of iterations that reduce the remaining error of the model's free run
        """
        settings = {
            "driver": driver, "capacitance": capacitance, "low": low, "high": high, "slew": slew, "current": current,
            "clip": clip, "smooth": smooth, "zvd": zvd, "notch": notch, "sweeps": sweeps,
        }  # fmt: skip
        u, reached, figures = self._core._compensation(reference, settings)
        return Compensation(u, reached, **figures)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._core == other._core

    def __hash__(self) -> int:
        return hash((self.ts, self.operator, self.offset, self.a.tobytes(), self.b.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        return Model, (self.to_json(),)

    def __repr__(self) -> str:
        u, y = self.units
        mode = f", {self.resonance[0]:.4g} Hz" if self.resonance else ""
        return f"<Model {self.operator}, order {len(self.a)}{mode}, {u} to {y} every {self.ts:g} s>"

    def _repr_html_(self) -> str:
        return _html.model(self)


def _plain(values: Any) -> Any:
    """Arrays as lists, for JSON."""
    if isinstance(values, (np.ndarray, np.generic)):
        return values.tolist()
    raise PiezoidError(f"a model cannot contain a {type(values).__name__}: use numbers, strings, lists and dicts")


def as_model(given: Any) -> Model:
    """A model, read if `given` is a file."""
    if isinstance(given, (str, os.PathLike)):
        return load(given)
    if not isinstance(given, Model):
        raise PiezoidError(f"model = {given!r}: must be a Model, or the file of one")
    return given


def load(path: str | os.PathLike[str]) -> Model:
    """Reads a model file."""
    with _files.named(path):
        try:
            return Model(_files.read(path).decode())
        except UnicodeDecodeError:
            raise PiezoidError("this is not a text file (it is not UTF-8)") from None


@dataclass(frozen=True, eq=False)
class Validation:
    """A free run compared with its record."""

    record: Record
    simulated: Array = field(repr=False)
    """The free run, of shape (n,) [the record's output unit]."""
    figures: dict[str, Any] = field(repr=False)
    """All results, as the command line writes them."""

    @property
    def n(self) -> int:
        """Number of samples compared."""
        return int(self.figures["metrics"]["n"])

    @property
    def mse(self) -> float:
        """Mean squared error [unit^2]."""
        return self._metric("mse")

    @property
    def rmse(self) -> float:
        """Root mean squared error [unit]."""
        return self._metric("rmse")

    @property
    def nrmse_percent(self) -> float:
        """100 rms error / standard deviation of y."""
        return self._metric("nrmse_percent")

    @property
    def rms_pp_percent(self) -> float:
        """100 rms error / peak-to-peak of y."""
        return self._metric("rms_pp_percent")

    @property
    def max_abs(self) -> float:
        """Largest absolute error [unit]."""
        return self._metric("max_abs")

    @property
    def fit_percent(self) -> float:
        """100 - nrmse_percent."""
        return self._metric("fit_percent")

    def _metric(self, name: str) -> float:
        value = self.figures["metrics"][name]
        return float("nan") if value is None else float(value)

    @property
    def summary(self) -> str | None:
        """The error in one sentence: noise, drift, and what a better model could gain; None if y is constant."""
        said: str | None = self.figures["summary"]
        return said

    @property
    def floor(self) -> dict[str, Any] | None:
        """The noise floor: `source` ("periods" or "spectrum"), `rms`, `nrmse_percent`, `reducible_nrmse_percent` (what
        a better model could gain), and more; None if it is unknown."""
        found: dict[str, Any] | None = self.figures["floor"]
        return found

    @property
    def drift_per_s(self) -> float:
        """Slope of the error over time, in the figures or removed from them [unit / s]."""
        return float(self.figures["drift_per_s"])

    @property
    def nrmse_without_drift_percent(self) -> float:
        """100 rms error without this drift / standard deviation of y."""
        value = self.figures["nrmse_without_drift_percent"]
        return float("nan") if value is None else float(value)

    @property
    def residual(self) -> Array:
        """Residuals: y minus the free run, of shape (n,)."""
        left: Array = self.record.y - self.simulated
        return left

    @property
    def start(self) -> int:
        """First sample that counts."""
        return int(self.figures["start"])

    @property
    def table(self) -> pd.DataFrame:
        """The errors by frequency: one row per band, with its middle `at` [Hz]."""
        return _frame(self.figures["by_frequency"])

    @property
    def by_amplitude(self) -> pd.DataFrame:
        """The errors by amplitude of the cycles: one row per band, with its middle `at` [input unit]."""
        return _frame(self.figures["by_amplitude"])

    @property
    def loops(self) -> pd.DataFrame:
        """Width, area, closure and slopes of the loops, measured and of the model."""
        import pandas as pd

        return pd.json_normalize(self.figures["loops"])

    @property
    def remarks(self) -> list[str]:
        """Remarks on the figures."""
        return list(self.figures["remarks"])

    @property
    def unproven(self) -> list[str]:
        """Properties of the model that this record does not test."""
        return list(self.figures["unproven"])

    def __repr__(self) -> str:
        noise = f" (noise {self.floor['nrmse_percent']:.2g} %)" if self.floor else ""
        return (
            f"<Validation: nrmse {self.nrmse_percent:.4g} %{noise}, rms/pp {self.rms_pp_percent:.4g} %, "
            f"{self.n} samples>"
        )

    def _repr_html_(self) -> str:
        return _html.validation(self)


@dataclass(frozen=True, eq=False)
class Compensation:
    """The voltage for a reference, and the displacement that the model predicts."""

    u: Array = field(repr=False)
    """The voltages [input unit], of shape (n,)."""
    reached: Array = field(repr=False)
    """Predicted displacement: the model's free run on `u` [output unit], of shape (n,)."""
    usage: dict[str, Any] = field(repr=False)
    """Use of the limits: lowest and highest voltage, slew, current."""
    clipped: int
    """Number of samples that were clipped to a limit."""
    notes: list[str]
    """Remarks, one sentence each."""

    def __repr__(self) -> str:
        low, high = (float(end(self.u)) for end in (np.min, np.max)) if len(self.u) else (float("nan"), float("nan"))
        told = "".join(f"; {note}" for note in self.notes)
        return f"<Compensation of {len(self.u)} samples: {low:.4g} to {high:.4g}, {self.clipped} clipped{told}>"


def _frame(rows: list[dict[str, Any]]) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame(rows)
