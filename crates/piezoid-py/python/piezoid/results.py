"""Results of models: a free run compared with a record, the voltage for a reference, the verdict."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _files, _html
from ._piezoid import PiezoidError
from ._types import Array
from .records import Record

if TYPE_CHECKING:
    import pandas as pd


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
        text: str | None = self.figures["summary"]
        return text

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
        """The errors by frequency: one row per band, with the mean frequency `at` [Hz] of its content."""
        return frame(self.figures["by_frequency"])

    @property
    def by_amplitude(self) -> pd.DataFrame:
        """The errors by amplitude of the cycles: one row per band, with the mean amplitude `at` [input unit]."""
        return frame(self.figures["by_amplitude"])

    @property
    def loops(self) -> pd.DataFrame:
        """Width, area, closure and slopes of the loops, measured and of the model."""
        import pandas as pd

        return pd.json_normalize(self.figures["loops"])

    @property
    def advice(self) -> str | None:
        """What would lower the error most, in one sentence; None near the noise, for a tiny error, and if a remark says
        it. The tests of the residuals are `figures["whiteness"]`."""
        text: str | None = self.figures["advice"]
        return text

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
class Certificate:
    """The expanded uncertainty of the displacement that a model predicts. `str(certificate)` says it in one sentence."""

    figures: dict[str, Any] = field(repr=False)
    """All results, as the command line writes them."""
    html: str = field(repr=False)
    """The page."""
    _xml: str | None = field(repr=False)
    _why: str = field(repr=False)

    @property
    def expanded(self) -> float:
        """Expanded uncertainty U, rounded up to two digits [`unit`]: the largest of all records and bands."""
        return float(self.figures["expanded"])

    @property
    def unit(self) -> str:
        """Unit of the displacement."""
        return str(self.figures["unit"])

    @property
    def k(self) -> float:
        """Coverage factor."""
        return float(self.figures["budget"]["k"])

    @property
    def correction(self) -> float | None:
        """What is added to every prediction [`unit`]; None if the mean error is a part of the uncertainty."""
        value = self.figures["correction"]
        return None if value is None else float(value)

    @property
    def within_percent(self) -> float:
        """Share of the samples of the records within U [%]."""
        return float(self.figures["within_percent"])

    @property
    def budget(self) -> pd.DataFrame:
        """The budget with the largest U: one row a source."""
        return frame(self.figures["budget"]["rows"])

    @property
    def records(self) -> pd.DataFrame:
        """The records: one row each, with its own uncertainty."""
        return frame([{name: value for name, value in one.items() if name != "rows"} for one in self.figures["records"]])

    @property
    def not_stated(self) -> list[str]:
        """Sources of uncertainty that are not stated and in no budget."""
        return list(self.figures["not_stated"])

    @property
    def remarks(self) -> list[str]:
        """Remarks."""
        return list(self.figures["remarks"])

    @property
    def dcc(self) -> str:
        """The Digital Calibration Certificate (DCC 3.3.0) as XML; it needs `date` and `country`."""
        if self._xml is None:
            raise PiezoidError(self._why)
        return self._xml

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page, or the XML if the path ends in .xml."""
        _files.write(path, self.dcc if os.fspath(path).lower().endswith(".xml") else self.html)

    def __str__(self) -> str:
        return str(self.figures["summary"])

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class Compensation:
    """The voltage for a reference, and the displacement that the model simulates with it."""

    u: Array = field(repr=False)
    """The voltages [input unit], of shape (n,)."""
    reached: Array = field(repr=False)
    """Simulated displacement: the model's free run on `u` [output unit], of shape (n,)."""
    usage: dict[str, Any] = field(repr=False)
    """Use of the limits: lowest and highest voltage, slew, current."""
    clipped: int
    """Number of samples that were clipped to a limit."""
    notes: list[str]
    """Remarks, one sentence each."""
    smoothing: dict[str, Any] | None = None
    """Where the voltage changes faster than in the training data: the duration `smooth` [s] that keeps it within their
    rates, None if none does, and the rms difference `rms` [output unit] of the path from the requested one."""

    def __repr__(self) -> str:
        low, high = (float(end(self.u)) for end in (np.min, np.max)) if len(self.u) else (float("nan"), float("nan"))
        message = "".join(f"; {note}" for note in self.notes)
        return f"<Compensation of {len(self.u)} samples: {low:.4g} to {high:.4g}, {self.clipped} clipped{message}>"


@dataclass(frozen=True)
class Verdict:
    """How good a model is, on which inputs, and what no record has proven. `str(verdict)` says it in one sentence."""

    error_percent: float
    """Rms error over peak-to-peak of the output [%]."""
    measured: str
    """How it was measured, such as "free run on held-out parts"."""
    noise_percent: float | None
    """Noise in it, over the same peak-to-peak [%]; None if it is unknown."""
    u: tuple[float, float]
    """Lowest and highest input [`unit`]."""
    unit: str
    """Unit of the input."""
    hz: tuple[float, float] | None
    """Lowest and highest frequency of large signals [Hz]; None if all inputs were constant."""
    unproven: list[str]
    """What no record has proven."""
    sentence: str = field(repr=False)
    """All of this in words."""
    worst_record: str | None = None
    """Of several validation records, the one with the largest error over its own peak-to-peak."""
    worst_percent: float | None = None
    """Its error [%]."""
    times_worse: float | None = None
    """The error of a validation over that at identification, if it is more than three times as large and neither
    noise nor a constant offset explains it."""
    left_percent: float | None = None
    """Decrease of the sum of squared errors that another step of the search promises [%]; None if the fit is at its
    minimum."""

    @classmethod
    def _of(cls, found: tuple[dict[str, Any], str]) -> Verdict:
        figures, sentence = found
        ends = {name: tuple(figures[name]) if figures[name] else None for name in ("u", "hz")}
        return cls(**(figures | ends), sentence=sentence)

    @property
    def short(self) -> str:
        """Its beginning: "good to 0.4 % of stroke"."""
        return self.sentence.split(" (")[0]

    def __str__(self) -> str:
        return self.sentence

    __repr__ = __str__


def frame(rows: list[dict[str, Any]]) -> pd.DataFrame:
    """A table of documents, one row each."""
    import pandas as pd

    return pd.DataFrame(rows)
