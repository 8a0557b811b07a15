"""The model as an estimator of scikit-learn: cross-validation over records, search for operator and order.

>>> import piezoid as pz
>>> from piezoid.learn import HammersteinRegressor, stack
>>> from sklearn.model_selection import LeaveOneGroupOut, cross_val_score
>>> plant, ts = pz.plants["pl140"], 1e-3
>>> sines = [pz.excite.rising_sine(ts=ts, duration=1, amplitude=28, frequency=f) for f in (4, 7, 11)]
>>> X, y, groups = stack([plant.measure(u, ts) for u in sines])
>>> X.shape, y.shape
((3000, 2), (3000,))
>>> regressor = HammersteinRegressor(ts, operator="preisach", order=2, elements=8)
>>> bool(cross_val_score(regressor, X, y, groups=groups, cv=LeaveOneGroupOut()).min() > 0.99)
True
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ._piezoid import PiezoidError
from ._types import Array, Units
from .identify import identify
from .model import Model
from .records import Record, as_records

try:
    from scipy.sparse import issparse
    from sklearn.base import BaseEstimator, RegressorMixin
    from sklearn.utils import Tags
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError as error:
    raise PiezoidError(f"piezoid.learn needs scikit-learn 1.6 or later ({error}): pip install piezoid[learn]") from None

__all__ = ["HammersteinRegressor", "stack"]

_RECORDS = ("data", "y", "ts", "fs", "units", "profile", "small_signal", "large_signal", "linear", "rich", "progress")
_SETTINGS = {name: p for name, p in inspect.signature(identify).parameters.items() if name not in _RECORDS}
"""The settings of `piezoid.identify`."""


class HammersteinRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Displacement from voltage: fit calls `piezoid.identify`, predict returns free runs.

    X: voltages, of shape (n,) or (n, 1), if all rows are one record; or of shape (n, 2), with the record number of each
    row in the second column. The rows of a record must be consecutive and in order of time. The record number is part
    of X, so that every part of scikit-learn respects the boundaries of the records: no fit and no free run crosses
    them.
    y: displacements, of shape (n,)

    ts: sampling period of all records [s]
    units: of voltages and displacements
    small_signal: records with at most this peak-to-peak input [input unit] are small-signal records for `identify`; the
    others are large-signal records. By default all records are `data`.

    All other parameters are those of `piezoid.identify`. Split by whole records (`LeaveOneGroupOut`, `GroupKFold`). A
    split within a record, as by `KFold`, leaves undetected gaps in the training data.

    model_: the `piezoid.Model`, after fit
    n_features_in_: 1, or 2 if X contains record numbers

    >>> from sklearn.model_selection import GridSearchCV, GroupKFold
    >>> search = GridSearchCV(
    ...     HammersteinRegressor(ts=5e-4), {"operator": ["preisach", "prandtl-ishlinskii"], "order": [2, 3]},
    ...     cv=GroupKFold(3))  # then search.fit(X, y, groups=groups)
    """

    model_: Model

    def __init__(
        self,
        ts: float,
        *,
        units: Units = ("V", "um"),
        small_signal: float | None = None,
        **measured: Any,
    ) -> None:
        self.ts = ts
        self.units = units
        self.small_signal = small_signal
        for name in measured.keys() - _SETTINGS.keys():
            raise TypeError(f"unexpected keyword {name!r}: settings of identify are {', '.join(_SETTINGS)}")
        for name, parameter in _SETTINGS.items():
            setattr(self, name, measured.get(name, parameter.default))

    _own = inspect.signature(__init__).parameters
    # scikit-learn reads the names of the parameters from the signature.
    __init__.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [p for p in _own.values() if p.kind is not p.VAR_KEYWORD] + list(_SETTINGS.values())
    )

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> HammersteinRegressor:
        """Identifies `model_` on the records in X and y."""
        rows, moved = validate_data(self, _columns(X), y, dtype=np.float64, y_numeric=True, ensure_min_samples=2)
        measured = self.get_params(deep=False)
        ts, units, small = measured.pop("ts"), measured.pop("units"), measured.pop("small_signal")
        records = [Record(u, moved[record], ts, units) for record, u in self._records(rows)]
        if small is None:
            self.model_ = identify(data=records, **measured)
        else:
            low = [r for r in records if np.ptp(r.u) <= small]
            high = [r for r in records if np.ptp(r.u) > small]
            self.model_ = identify(small_signal=low, large_signal=high, **measured)
        return self

    def predict(self, X: npt.ArrayLike) -> Array:
        """The free run of each record [output unit], of shape (n,); measured displacements are not used.

        The initial condition of a record is chosen from its inputs: in motion, or settled at the first input.
        """
        check_is_fitted(self, "model_")
        rows = validate_data(self, _columns(X), reset=False, dtype=np.float64)
        return np.concatenate([self.model_.simulate(u, begin="likely") for _, u in self._records(rows)])

    def _records(self, X: Array) -> list[tuple[slice, Array]]:
        """The rows and the voltages of each record."""
        if X.shape[1] == 1:
            return [(slice(None), X[:, 0])]
        if X.shape[1] > 2:
            raise PiezoidError(f"X has shape {X.shape}: give one column of voltages, and one of record numbers at most")
        number = X[:, 1]
        if len(odd := np.flatnonzero(number != np.round(number))):
            raise PiezoidError(f"row {odd[0]} of X belongs to record {number[odd[0]]:g}: number records by whole numbers")
        starts = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist()]
        known: set[float] = set()
        for row in starts:
            if number[row] in known:
                again = f"again at row {row} of X"
                raise PiezoidError(f"the rows of record {number[row]:g} are not consecutive ({again}): keep them together")
            known.add(number[row])
        rows = [slice(*ends) for ends in zip(starts, [*starts[1:], len(X)], strict=True)]
        return [(record, X[record, 0]) for record in rows]

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.one_d_array = True
        # The tests of scikit-learn compute the score on unordered rows of several columns. It is poor there.
        tags.regressor_tags.poor_score = True
        return tags


def stack(records: Iterable[Record]) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Concatenates records: X, of shape (n, 2), y, of shape (n,), and the record number of each row, of shape (n,).

    The record numbers are the `groups` of a cross-validation.
    """
    measured = as_records(records)
    if len(kinds := {(r.ts, r.units) for r in measured}) != 1:
        message = "; ".join(sorted(f"every {ts:g} s in {u} and {y}" for ts, (u, y) in kinds)) or "none"
        raise PiezoidError(f"give at least one record, all with the same sampling period and units; these are: {message}")
    groups = np.repeat(np.arange(len(measured)), [len(r) for r in measured])
    X = np.column_stack([np.concatenate([r.u for r in measured]), groups])
    return X, np.concatenate([r.y for r in measured]), groups


def _columns(X: Any) -> Any:
    """One-dimensional samples as a column; scikit-learn checks everything else."""
    if issparse(X) or getattr(X, "ndim", 1) != 1:
        return X
    X = np.asarray(X)
    return X[:, np.newaxis] if X.ndim == 1 else X
