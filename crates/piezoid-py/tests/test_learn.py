"""The estimator within scikit-learn."""

from __future__ import annotations

import importlib
import inspect
import pickle
import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
import sklearn
from piezoid.learn import HammersteinRegressor, stack
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.metrics import r2_score
from sklearn.model_selection import GridSearchCV, GroupKFold, LeaveOneGroupOut, cross_val_score, cross_validate
from sklearn.utils.estimator_checks import check_estimator

import piezoid as pz

TS = 1e-3
SINES = [pz.excite.rising_sine(ts=TS, duration=1, amplitude=28, frequency=f) for f in (4, 7, 11)]
TWIN = [pz.plants["pl140"].measure(u, TS, seed=seed) for seed, u in enumerate(SINES)]
PLAYS = {"operator": "prandtl-ishlinskii", "order": 2, "elements": 8}

# The fastest method, and the only one that accepts noise as a record.
PLAIN = HammersteinRegressor(TS, method="paper", operator="proportional")

CUT = "the check cuts X to one axis, as the tag one_d_array asks, then indexes two: FirstColumn runs it"

EXPECTED_FAILURES = {
    "check_dict_unchanged": CUT,
    "check_dont_overwrite_parameters": CUT,
    "check_dtype_object": CUT,
    "check_estimator_sparse_array": CUT,
    "check_f_contiguous_array_estimator": CUT,
    "check_fit2d_1feature": CUT,
    "check_fit2d_1sample": CUT,
    "check_fit2d_predict1d": CUT,
    "check_methods_sample_order_invariance": CUT,
    "check_methods_subset_invariance": CUT,
    "check_n_features_in": CUT,
    "check_n_features_in_after_fitting": CUT,
    "check_regressors_no_decision_function": CUT,
    "check_fit1d": "samples of shape (n,) are what a record is made of: they are taken, not refused",
}

EXPECTED_OF_FIRST_COLUMN = {
    "check_fit1d": EXPECTED_FAILURES["check_fit1d"],
    "check_fit2d_predict1d": "a row of X is taken for samples of shape (n,), and refused for its number of columns",
}

SHORT = "its record has 10 or 15 samples: below 16 no model with hysteresis is identified"
NOISE = "its y hardly depend on the first column of X, or as no ceramic does: no model predicts them"
UNSOUND = "its y are a few whole numbers: a sensor that sticks, which is refused"
EXPECTED_WITH_MEMORY = EXPECTED_OF_FIRST_COLUMN | {
    "check_methods_sample_order_invariance": "order in time is what a series is",
    "check_methods_subset_invariance": "a free run remembers: its parts, each run from rest, are other runs",
    "check_dtype_object": NOISE,
    "check_fit_check_is_fitted": NOISE,
    "check_fit_idempotent": NOISE,
    "check_n_features_in": NOISE,
    "check_regressor_data_not_an_array": NOISE,
    "check_regressors_train": NOISE,
    "check_estimators_nan_inf": SHORT,
    "check_fit2d_1feature": SHORT,
    "check_n_features_in_after_fitting": SHORT,
    "check_regressors_no_decision_function": SHORT,
    "check_array_api_input": UNSOUND,  # runs only if SCIPY_ARRAY_API=1
    "check_estimators_dtypes": UNSOUND,
    "check_estimators_pickle": UNSOUND,
    "check_fit_score_takes_y": UNSOUND,
    "check_pipeline_consistency": UNSOUND,
    "check_positive_only_tag_during_fit": UNSOUND,
    "check_supervised_y_2d": UNSOUND,
}


class FirstColumn(HammersteinRegressor):
    """The estimator on the first column of X only, for checks with several columns."""

    def _records(self, X: Any) -> Any:
        return [(slice(None), X[:, 0])]

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.one_d_array = False
        return tags


@pytest.mark.parametrize(
    ("regressor", "expected"),
    [
        (PLAIN, EXPECTED_FAILURES),
        (FirstColumn(**PLAIN.get_params()), EXPECTED_OF_FIRST_COLUMN),
        (FirstColumn(TS, operator="prandtl-ishlinskii", order=0, elements=4), EXPECTED_WITH_MEMORY),
    ],
    ids=["itself", "first column", "first column, with memory"],
)
def test_the_checks_of_scikit_learn_pass_but_for_those_listed(
    regressor: HammersteinRegressor, expected: dict[str, str]
) -> None:
    results = check_estimator(regressor, expected_failed_checks=expected, on_skip=None, on_fail=None)
    failed = {r["check_name"]: repr(r["exception"]) for r in results if r["status"] == "failed"}
    assert not failed
    ran = {r["check_name"] for r in results if r["status"] != "skipped"}
    still = {r["check_name"] for r in results if r["status"] == "xfail"}
    assert ran & set(expected) == still, "what passes has no place on the list"


def test_it_finds_the_model_that_identify_finds_to_the_bit() -> None:
    X, y, _ = stack(TWIN)
    regressor = HammersteinRegressor(TS, **PLAYS).fit(X, y)
    assert regressor.model_ == pz.identify(data=TWIN, **PLAYS)
    assert regressor.model_.to_json() == pz.identify(data=TWIN, **PLAYS).to_json()


def test_small_signal_records_are_told_by_what_their_inputs_span() -> None:
    small = pz.plants["pl140"].measure(pz.excite.prbs(ts=TS, duration=1, amplitude=1), TS)
    X, y, _ = stack([TWIN[0], small, TWIN[1]])
    regressor = HammersteinRegressor(TS, small_signal=5, **PLAYS).fit(X, y)
    assert regressor.model_ == pz.identify(small_signal=small, large_signal=TWIN[:2], **PLAYS)


def test_every_setting_of_identify_is_a_parameter_with_the_same_default() -> None:
    def settings(f: Any) -> dict[str, Any]:
        return {name: p.default for name, p in inspect.signature(f).parameters.items()}

    own = settings(HammersteinRegressor)
    assert [own.pop(name) for name in ("ts", "units", "small_signal")] == [inspect.Parameter.empty, ("V", "um"), None]
    of_a_call = ("small_signal", "large_signal", "linear", "rich", "data", "y", "ts", "fs", "units", "profile", "progress")
    assert own == {name: default for name, default in settings(pz.identify).items() if name not in of_a_call}


def test_predict_runs_each_record_freely_and_never_across_a_seam() -> None:
    X, y, groups = stack(TWIN)
    regressor = HammersteinRegressor(TS, **PLAYS).fit(X, y)
    apart = np.concatenate([regressor.model_.simulate(r.u) for r in TWIN])
    np.testing.assert_array_equal(regressor.predict(X), apart)
    assert not np.array_equal(regressor.model_.simulate(X[:, 0]), apart)
    # Another order of the records, and record numbers that fit did not see, change nothing.
    back = np.concatenate([np.flatnonzero(groups == g) for g in (2, 0, 1)])
    np.testing.assert_array_equal(regressor.predict(X[back] + [0, 7]), apart[back])
    assert regressor.score(X, y) == r2_score(y, apart)


def test_voltages_alone_are_one_record_with_or_without_a_second_axis() -> None:
    u, y = TWIN[0].u, TWIN[0].y
    flat = HammersteinRegressor(TS, **PLAYS).fit(u, y)
    assert flat.n_features_in_ == 1
    assert flat.model_ == HammersteinRegressor(TS, **PLAYS).fit(u[:, np.newaxis], y).model_
    np.testing.assert_array_equal(flat.predict(list(u)), flat.model_.simulate(u))
    with pytest.raises(ValueError, match="Reshape your data"):
        flat.predict(1.0)


def test_rows_that_are_no_records_are_refused_with_their_place() -> None:
    X, y, _ = stack(TWIN)
    with pytest.raises(pz.PiezoidError, match="again at row 2500 of X"):
        clone(PLAIN).fit(np.roll(X, -500, axis=0), y)
    half = X.copy()
    half[7, 1] = 0.5
    with pytest.raises(pz.PiezoidError, match="row 7 of X belongs to record 0.5"):
        clone(PLAIN).fit(half, y)
    with pytest.raises(pz.PiezoidError, match=r"X has shape \(3000, 3\)"):
        clone(PLAIN).fit(np.column_stack([X, X[:, 1]]), y)


def test_columns_of_a_frame_keep_their_names() -> None:
    X, y, _ = stack(TWIN)
    frame = pd.DataFrame(X, columns=["u_V", "record"])
    regressor = clone(PLAIN).fit(frame, pd.Series(y))
    assert list(regressor.feature_names_in_) == ["u_V", "record"]
    with pytest.raises(ValueError, match="feature names"):
        regressor.predict(frame[["record", "u_V"]])


def test_a_clone_has_the_settings_and_not_the_model() -> None:
    X, y, _ = stack(TWIN)
    regressor = HammersteinRegressor(TS, units=("V", "nm"), seed=3, **PLAYS).fit(X, y)
    copy = clone(regressor)
    assert copy.get_params() == regressor.get_params()
    with pytest.raises(NotFittedError):
        copy.predict(X)
    assert copy.fit(X, y).model_ == regressor.model_
    assert regressor.model_.units == ("V", "nm")


def test_a_pickled_estimator_is_the_same_one() -> None:
    X, y, _ = stack(TWIN)
    regressor = HammersteinRegressor(TS, **PLAYS).fit(X, y)
    loaded = pickle.loads(pickle.dumps(regressor))
    assert loaded.model_ == regressor.model_
    assert loaded.get_params() == regressor.get_params()
    np.testing.assert_array_equal(loaded.predict(X), regressor.predict(X))


def test_cross_validation_leaves_out_records_and_scores_as_by_hand() -> None:
    X, y, groups = stack(TWIN)
    regressor = HammersteinRegressor(TS, operator="preisach", order=2, elements=8)
    scores = cross_val_score(regressor, X, y, groups=groups, cv=LeaveOneGroupOut())
    for out, score in enumerate(scores):
        model = pz.identify(data=[r for i, r in enumerate(TWIN) if i != out], operator="preisach", order=2, elements=8)
        assert score == r2_score(TWIN[out].y, model.simulate(TWIN[out].u))
    assert scores.min() > 0.99


def test_cross_validation_is_the_same_with_metadata_routing() -> None:
    X, y, groups = stack(TWIN)
    plain = cross_validate(PLAIN, X, y, groups=groups, cv=LeaveOneGroupOut())["test_score"]
    with sklearn.config_context(enable_metadata_routing=True):
        routed = cross_validate(PLAIN, X, y, params={"groups": groups}, cv=LeaveOneGroupOut())["test_score"]
    np.testing.assert_array_equal(plain, routed)


@cache
def searched() -> tuple[GridSearchCV, list[pz.Record]]:
    """A grid search on records that prandtl-ishlinskii of order 2 made, and these records.

    Their sines alone do not excite the second pole: a fast signal of 2 V is added, which begins after the actuator was
    at rest.
    """
    made_by = pz.identify(data=TWIN, **PLAYS)
    rng = np.random.default_rng(1)
    inputs = [u + rng.choice([-2.0, 2.0], len(u)) * (np.arange(len(u)) >= 20) for u in SINES]
    noisy = [pz.Record(u, made_by.simulate(u) + rng.normal(0, 0.5, len(u)), TS) for u in inputs]
    X, y, groups = stack(noisy)
    grid = {"operator": ["proportional", "prandtl-ishlinskii", "bouc-wen"], "order": [1, 2]}
    search = GridSearchCV(HammersteinRegressor(TS, elements=8), grid, cv=GroupKFold(3), error_score="raise")
    return search.fit(X, y, groups=groups), noisy


def test_a_grid_search_finds_the_operator_that_made_the_data() -> None:
    search, noisy = searched()
    assert search.best_params_["operator"] == "prandtl-ishlinskii"
    assert search.best_estimator_.model_ == pz.identify(data=noisy, elements=8, **search.best_params_)


def test_a_grid_search_finds_the_order_that_made_the_data() -> None:
    search, noisy = searched()
    assert search.best_params_ == {"operator": "prandtl-ishlinskii", "order": 2}
    assert search.best_estimator_.model_ == pz.identify(data=noisy, **PLAYS)


def test_records_that_differ_in_kind_are_not_stacked() -> None:
    with pytest.raises(pz.PiezoidError, match="every 0.001 s in V and um; every 0.002 s in V and um"):
        stack([TWIN[0], pz.Record(TWIN[0].u, TWIN[0].y, 2e-3)])
    with pytest.raises(pz.PiezoidError, match="these are: none"):
        stack([])


def test_without_scikit_learn_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "piezoid.learn")
    monkeypatch.setitem(sys.modules, "sklearn.base", None)
    with pytest.raises(pz.PiezoidError, match=r"pip install piezoid\[learn\]"):
        importlib.import_module("piezoid.learn")


def test_scikit_learn_is_imported_only_when_it_is_asked_for() -> None:
    code = "import sys, piezoid as pz; assert 'sklearn' not in sys.modules; pz.learn.HammersteinRegressor(1e-3)"
    subprocess.run([sys.executable, "-c", code], check=True)
