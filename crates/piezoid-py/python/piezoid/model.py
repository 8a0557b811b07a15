"""Models: free runs, validation on records, voltages for requested displacements."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _files, _html, _piezoid
from ._checks import whole
from ._keywords import known, takes
from ._options import CertificateOptions, CompensateOptions, InverseOptions, ValidateOptions
from ._piezoid import FeedForward, PiezoidError
from ._progress import watched
from ._types import Array, Begin, Progress, Samples, Units
from .records import as_record, as_records, read_input
from .results import Certificate, Compensation, Validation, Verdict, frame
from ._summary import summary

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

    from .records import Source, Sources

__all__ = ["Certificate", "Compensation", "FeedForward", "Model", "Validation", "Verdict", "load"]


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
        """Coefficients of past outputs, linear block: y_t = a1 y_{t-1} + ... + b0 z_t + b1 z_{t-1} + ..."""
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
        """Lowest and highest input of the training data [input unit]."""
        return self._core.input_range

    @cached_property
    def provenance(self) -> dict[str, Any]:
        """Origin: front end, version, options, seed, files with hashes, operators that were tried, parameters with
        errors, notes."""
        result = self.to_dict()["fit"]
        return result if isinstance(result, dict) else {}

    @property
    def notes(self) -> list[str]:
        """Remarks of the identification for users of the model."""
        return [str(note) for note in self._found("notes")]

    @property
    def trials(self) -> pd.DataFrame:
        """The operators that were tried, with the errors on held-out parts and in free run, and a verdict."""
        return frame(self._found("trials"))

    @property
    def parameters(self) -> pd.DataFrame:
        """Estimated parameters (shape of the operator, creep gains, modes), with standard errors."""
        return frame(self._found("parameters"))

    @property
    def verdict(self) -> Verdict | None:
        """How good the model was at its identification; None if its file has no verdict."""
        found = self._core.verdict
        return None if found is None else Verdict._of(found)

    def again(self, *files: str | os.PathLike[str], progress: Progress = None) -> Model:
        """Identifies it again, from the files that it was identified from, in any order, with its own options.

        The result equals this model, to the bit with the same version of piezoid, on every machine. A file that differs
        or is missing is named in the error, and so is a result that differs by more than rounding.
        """
        with watched(progress) as watch:
            named = [(str(path), _files.read(path)) for path in files]
            return Model._of(_piezoid.again(self._core, named, watch))

    def summary(self) -> str:
        """The model in words: what it is, how good it is and where, its parameters with standard errors, remarks.

        >>> import piezoid as pz
        >>> u = pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4)
        >>> record = pz.plants["pl140"].measure(u, ts=1e-3)
        >>> print(pz.identify(record, operator="prandtl-ishlinskii", order=2).summary().split(",")[0])
        prandtl-ishlinskii
        """
        return summary(self)

    def plot(self, *, ax: Any = None) -> Any:
        """A figure of its parts: the loops of the hysteresis, gain and phase of the linear block.

        It needs matplotlib and is `pz.plot.blocks`. `ax` are three Axes. Returns an array of the Axes.
        """
        from . import plot

        return plot.blocks(self, ax=ax)

    def _found(self, what: str) -> list[Any]:
        found = self.provenance.get(what)
        return found if isinstance(found, list) else []

    @overload
    def simulate(self, u: pd.DataFrame, *, begin: Begin = ..., input_col: str | int | None = ...) -> pd.DataFrame: ...
    @overload
    def simulate(self, u: Samples, *, begin: Begin = ...) -> Array: ...
    def simulate(self, u: Any, *, begin: Begin = "rest", input_col: str | int | None = None) -> Any:
        """The free run: displacements [output unit] of inputs `u` [input unit], both of shape (n,).

        A DataFrame gives a DataFrame with the same index and the column `y_um` (or another unit). Its input is found as
        `read` finds it, or is the column `input_col`; its times must fit to the model, if it has times.

        begin: initial condition: "rest"; "settled" at the first input, from rest, or after cycles over the whole range
        that ended with a fall ("from-above") or a rise ("from-below"), or after a decaying sine about it
        ("demagnetised"); in "motion" as in `u`; or "likely": "settled" or "motion", chosen from `u`
        """
        if not hasattr(u, "columns"):
            if input_col is not None:
                raise PiezoidError(f"input_col = {input_col!r}: names a column of a DataFrame, but u is {_kind(u)}")
            return self._core.simulate(u, begin)
        import pandas as pd

        y = self._core.simulate(read_input(u, self, input_col=input_col), begin)
        return pd.DataFrame({f"y_{self.units[1]}": y}, index=getattr(u, "index", None))

    def deviation(self, u: Samples, *, begin: Begin = "rest") -> Array:
        """The standard deviation of the free run with `u` [output unit], both of shape (n,).

        Only models with the operator gaussian-process state one: what its inducing points leave open. It does not
        contain noise, nor what the records leave open. An input beyond the training data has a larger one.

        begin: as in `simulate`
        """
        return self._core.deviation(u, begin)

    def predict(self, u: Samples, y: Samples) -> Array:
        """One-step prediction of y[t] from u up to t and measured y up to t-1; all of shape (n,)."""
        return self._core.predict(u, y)

    def hidden(self, u: Samples) -> Array:
        """The input of the linear block for `u`, from rest: the hidden variable z and its creep; both of shape (n,)."""
        return self._core.hidden(u)

    def response(self, hz: Samples) -> npt.NDArray[np.complex128]:
        """The frequency response of the linear block [output unit / input unit] at `hz` [Hz], both of shape (n,)."""
        return self._core.response(hz)

    @takes(ValidateOptions)
    def validate(self, record: Source, **options: Unpack[ValidateOptions]) -> Validation:
        """Compares its free run with a record, preferably one that was not used for identification.

        record: anything that `read` accepts

        {options}
        """
        settings, measured = known(Model.validate, options), as_record(record)
        figures, simulated = self._core._validate(measured._core, settings)
        return Validation(measured, simulated, figures)

    @takes(CertificateOptions)
    def certificate(self, records: Sources, **options: Unpack[CertificateOptions]) -> Certificate:
        """The expanded uncertainty of its predictions after the GUM, from records that it was not identified from.

        It is a statement by its user, not by an accredited laboratory: docs/certificate.md has the equations.

        records: one or several of anything that `read` accepts

        {options}

        >>> import piezoid as pz
        >>> wave = lambda hz: pz.excite.sine(ts=1e-3, duration=2, amplitude=25, frequency=hz)
        >>> measure = lambda hz: pz.plants["pl140"].measure(wave(hz), ts=1e-3)
        >>> model = pz.identify(measure(5), operator="prandtl-ishlinskii", order=2)
        >>> certificate = model.certificate([measure(4), measure(7)], sensor_calibration=0.5, date="2026-11-30")
        >>> certificate.unit, certificate.budget["source"][0]
        ('um', 'error of the model')
        """
        settings, measured = known(Model.certificate, options), as_records(records)
        return Certificate(*self._core._certificate([record._core for record in measured], settings))

    @takes(InverseOptions)
    def inverse(self, delay_samples: int = 0, **limits: Unpack[InverseOptions]) -> FeedForward:
        """The inverse, sample by sample, from requested displacement to voltage.

        The displacement follows `delay_samples` samples later; 0 means as few as the model allows, which is more than
        none if its hysteresis is in feedback: the inverse then needs the reference in advance. A value that is not
        finite is replaced by the one before, and voltages beyond the limits are clipped.

        {options}
        """
        return self._core._inverse(whole("delay_samples", delay_samples), known(Model.inverse, limits))

    @takes(CompensateOptions)
    def compensate(self, reference: Samples, **options: Unpack[CompensateOptions]) -> Array:
        """The voltages [input unit] for a requested displacement [output unit], both of shape (n,).

        They are `compensation(...).u`, with the same options.
        """
        u: Array = self._core._compensation(reference, known(Model.compensate, options), False)["u"]
        return u

    @takes(CompensateOptions)
    def compensation(self, reference: Samples, **options: Unpack[CompensateOptions]) -> Compensation:
        """The voltages for a requested displacement, of shape (n,) [output unit], and the free run with them.

        Before the first sample the actuator is assumed settled at the first value of the reference.

        {options}
        """
        return Compensation(**self._core._compensation(reference, known(Model.compensation, options), True))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._core == other._core

    def __hash__(self) -> int:
        return hash((self.ts, self.operator, self.offset, self.a.tobytes(), self.b.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        return Model, (self.to_json(),)

    def __repr__(self) -> str:
        u, y = self.units
        mode = f", {self.resonance[0]:.4g} Hz" if self.resonance else ""
        good = self.verdict.short if self.verdict else "no verdict"
        return f"<Model {self.operator}, order {len(self.a)}{mode}, {u} to {y} every {self.ts:g} s, {good}>"

    def _repr_html_(self) -> str:
        return _html.model(self)


def _plain(values: Any) -> Any:
    """Arrays as lists, for JSON."""
    if isinstance(values, (np.ndarray, np.generic)):
        return values.tolist()
    raise PiezoidError(f"a model cannot contain a {type(values).__name__}: use numbers, strings, lists and dicts")


def _kind(source: object) -> str:
    return f"a {type(source).__name__}"


def as_model(source: Any) -> Model:
    """A model; reads it if `source` is a file."""
    if isinstance(source, (str, os.PathLike)):
        return load(source)
    if not isinstance(source, Model):
        raise PiezoidError(f"model = {source!r}: must be a Model, or the file of one")
    return source


def load(path: str | os.PathLike[str]) -> Model:
    """Reads a model file."""
    with _files.named(path):
        try:
            return Model(_files.read(path).decode())
        except UnicodeDecodeError:
            raise PiezoidError("this is not a text file (it is not UTF-8)") from None
