"""Preparation of records, against scipy and against theory."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import piezoid as pz
import pytest

TS = 1e-4
T = np.arange(4000) * TS


def sine(hz: float, t: Any = T) -> Any:
    return np.sin(2 * np.pi * hz * t + 0.3)


def record(y: Any, u: Any = None) -> pz.Record:
    return pz.Record(y if u is None else u, y, ts=TS)


def test_decimation_is_scipys_filter_without_phase() -> None:
    from scipy.signal import firwin, kaiser_beta, upfirdn

    y = np.random.default_rng(1).standard_normal(4000)
    taps = firwin(2 * 29 * 5 + 1, 0.9 / 5, window=("kaiser", kaiser_beta(90)))
    padded = np.pad(y, 145, mode="reflect", reflect_type="odd")
    expected = upfirdn(taps, padded, 1, 5)[290 // 5 :][:800]
    result = record(y).prepare(decimate=5)
    assert result.ts == 5e-4 and np.abs(result.y - expected).max() < 1e-8 and np.array_equal(result.u, result.y)


def test_what_is_below_is_kept_and_what_is_above_is_gone() -> None:
    below, above = (record(sine(hz)).prepare(resample="0.4 ms") for hz in (990, 1251))
    t = np.arange(len(below)) * 4e-4
    inner = slice(30, -30)
    assert np.abs(below.y - sine(990, t))[inner].max() < 1e-3
    assert np.abs(above.y)[inner].max() < 1e-3


def test_a_period_is_resampled_as_by_fourier() -> None:
    from scipy.signal import resample

    period = sum(np.cos(2 * np.pi * k * np.arange(400) / 400 + k * k) / k for k in range(1, 79))
    result = record(np.tile(period, 10)).prepare(average=True, resample=2e-4)
    assert np.abs(result.y - resample(period, 200)).max() < 3e-4


@pytest.mark.parametrize("kind", ["mean", "line"])
def test_trends_are_scipys(kind: Any) -> None:
    from scipy.signal import detrend

    y = 3 + 7 * T + np.random.default_rng(2).standard_normal(len(T))
    result = record(y).prepare(detrend=kind)
    assert np.allclose(result.y, detrend(y, type={"mean": "constant", "line": "linear"}[kind]), rtol=0, atol=1e-12)


def test_a_late_sensor_is_aligned() -> None:
    result = record(sine(1200, T - 3.3e-4), sine(1200)).prepare(delay="330us")
    assert len(result) == 3996 and np.abs(result.y - result.u)[15:-15].max() < 1e-4


def test_the_mean_of_100_periods_has_a_tenth_of_the_noise() -> None:
    u = np.tile(np.sin(2 * np.pi * np.arange(250) / 250), 100)
    y = 3 * u + np.random.default_rng(3).normal(0, 0.5, len(u))
    result = record(y, u).prepare(average=True)
    assert len(result) == 250 and 0.04 < np.std(result.y - 3 * result.u) < 0.06
    [message] = result.history
    assert message.startswith("averaged 100 periods of 0.025 s") and 0.049 < float(message.split()[-2]) < 0.051


def test_spikes_are_replaced() -> None:
    y = 20 * sine(5)
    spiked = y.copy()
    at = [400, 1700, 3000]
    spiked[at] += [5, -3, 8]
    result = record(spiked, 30 * sine(5)).prepare(outliers=True)
    assert np.flatnonzero(result.y != spiked).tolist() == at and np.abs(result.y - y).max() < 1e-6


def test_the_steps_travel_with_the_record_and_into_the_model(rich: pz.Record, tmp_path: Path) -> None:
    result = rich.prepare(start=0.25, input_scale=2, output_scale="1e-3 mm/um", output_offset=0.01, detrend="mean")
    steps = result.history
    starts = ["cut from 0.25 s", "input scaled by 2", "output scaled by 1e-3 mm/um", "0.01 mm added", "mean of the output"]
    assert result.units == ("V", "mm") and result.u[0] == 2 * rich.u[500]
    assert len(steps) == 5 and all(step.startswith(start) for step, start in zip(steps, starts, strict=True))
    assert pickle.loads(pickle.dumps(result)).history == steps
    for name in ["r.csv", "r.npz", "r.mat"]:
        result.save(tmp_path / name)
        assert pz.read(tmp_path / name).history == steps and pz.read(tmp_path / name) == result, name
    assert str(np.load(tmp_path / "r.npz")["piezoid_history"]).splitlines() == steps
    from scipy.io import loadmat

    assert loadmat(tmp_path / "r.mat")["piezoid_history"][0].splitlines() == steps
    for source in [result, tmp_path / "r.csv"]:
        model = pz.identify(source, operator="proportional", order=1)
        assert [file["steps"] for file in model.provenance["files"]] == [steps]


@pytest.mark.parametrize(
    ("input", "message"),
    [
        ({"decimate": 0}, "decimate = 0: must be a whole number, 1 or more"),
        ({"decimate": 4000}, "decimate = 4000: the record has only 4000 samples"),
        ({"resample": 9}, "resample = 9 s: fewer than two samples would remain"),
        ({"resample": "5 V"}, "resample = 5 V: must be a positive number [s]"),
        ({"delay": 1}, "delay = 1 s: the record is only 0.4 s long"),
        ({"detrend": "cubic"}, "detrend = cubic: must be mean or line"),
        ({"average": True, "period": 0.3}, "period = 0.3 s: the record of 0.4 s has no two periods"),
        ({"period": 0.1}, "period = 0.1 s: is needed only for an average"),
        ({"start": 7}, "no sample lies from 7 s on"),
        ({"output_scale": "um"}, "output_scale = um: must be a factor"),
        ({"decimate": 2, "resample": 1}, "give either decimate or resample"),
    ],
)
def test_what_cannot_be_done_is_refused(input: dict[str, Any], message: str) -> None:
    prepare: Callable[..., pz.Record] = record(sine(50)).prepare
    with pytest.raises(pz.PiezoidError) as raised:
        prepare(**input)
    assert message in str(raised.value)
