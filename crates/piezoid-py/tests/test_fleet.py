"""Fleets: no actuator is lost, whatever happens to another."""

from __future__ import annotations

import os
import signal
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_all_start_methods, get_context
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import piezoid as pz

TS = 5e-4
KNOWN = {"operator": "prandtl-ishlinskii", "order": 2}


def twin(index: int) -> pz.Plant:
    return pz.plants["pl140"].drawn(0.2, seed=1, index=index)


def sine(index: int, frequency: float = 5) -> pz.Record:
    return twin(index).measure(pz.excite.rising_sine(ts=TS, duration=0.6, amplitude=28, frequency=frequency), ts=TS)


def records(index: int) -> dict[str, pz.Record]:
    small = pz.excite.prbs(ts=TS, duration=0.6, amplitude=1)
    return {"small_signal": twin(index).measure(small, ts=TS), "large_signal": sine(index)}


def unplugged() -> None:
    raise OSError("the amplifier does not answer")


def kill_own_worker(job: str) -> str:
    if job == "poison":
        os.kill(os.getpid(), signal.SIGKILL)
    return job


def fleet(n: int) -> dict[str, object]:
    return {f"stage {index}": partial(records, index) for index in range(n)}


@pytest.fixture(scope="module")
def undisturbed():
    return pz.fleet.identify(fleet(12), **KNOWN)


@pytest.fixture(scope="module")
def client():
    pytest.importorskip("distributed")
    with pz.fleet.local(2) as client:
        yield client


def test_without_an_engine_a_fleet_is_what_identify_makes_of_each(undisturbed):
    assert list(undisturbed.index) == list(fleet(12))
    assert undisturbed.error.isna().all() and (undisturbed.attempts == 1).all()
    alone = pz.identify(**records(3), **KNOWN)
    row = undisturbed.loc["stage 3"]
    assert row.model == alone
    assert row.rms_pp_percent == alone.validate(sine(3)).rms_pp_percent
    assert (row.operator, row.resonance_hz, row.damping) == ("prandtl-ishlinskii", *alone.resonance)


def test_a_worker_killed_in_the_middle_loses_nothing(client, undisturbed):
    killed = []

    def kill_one(what: str, done: int, total: int) -> None:
        if not killed and 0 < done < total:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    table = pz.fleet.identify(fleet(12), client, chunk=1, progress=kill_one, **KNOWN)
    assert killed and len(set(table.worker)) >= 2
    assert list(table.index) == list(undisturbed.index) and table.error.isna().all()
    assert list(table.model) == list(undisturbed.model)
    figures = ["resonance_hz", "damping", "dc_gain", "nrmse_percent", "rms_pp_percent", "rmse", "max_abs"]
    assert table[figures].equals(undisturbed[figures])


def test_a_job_that_kills_its_workers_fails_alone(client, monkeypatch):
    monkeypatch.setattr(client.cluster.scheduler, "allowed_failures", 1)  # Dask gives up sooner, for a shorter test
    table = pz.fleet.run(kill_own_worker, {n: n for n in ["a", "poison", "b", "c"]}, client, chunk=4)
    assert list(table.value.drop("poison")) == ["a", "b", "c"] and table.error.drop("poison").isna().all()
    assert table.error["poison"].startswith("KilledWorker") and table.attempts["poison"] == 3


@pytest.mark.parametrize("engine", ["none", "threads", "dask"])
def test_what_fails_is_a_row_that_says_why(engine, request):
    broken = records(0) | {"large_signal": pz.Record(np.zeros(500), np.zeros(500), TS)}
    actuators = {"good": records(0), "broken": broken, "unplugged": unplugged, "absent": {"data": "nowhere.csv"}, 5: sine(1)}
    client = {"none": lambda: None, "threads": partial(ThreadPoolExecutor, 2)}.get(engine)
    table = pz.fleet.identify(actuators, client() if client else request.getfixturevalue("client"), **KNOWN)
    assert list(table.index) == ["good", "broken", "unplugged", "absent", 5]
    assert list(table.error.isna()) == [True, False, False, False, True]
    assert table.error["unplugged"] == "OSError: the amplifier does not answer"
    assert table.error["absent"].startswith("nowhere.csv: there is no such file")
    assert "PiezoidError" not in table.error["broken"]
    assert dict(table.attempts) == {"good": 1, "broken": 1, "unplugged": 3, "absent": 1, 5: 1}  # PiezoidError is final
    assert table.model["good"] == pz.identify(**records(0), **KNOWN)


def test_what_comes_back_is_tried_again_until_it_is_well(tmp_path):
    def at_the_second_time() -> dict[str, pz.Record]:
        if (tmp_path / "tried").exists():
            return records(2)
        (tmp_path / "tried").touch()
        raise ConnectionError("not yet")

    table = pz.fleet.identify({"shy": at_the_second_time}, **KNOWN)
    assert table.error.isna().all() and list(table.attempts) == [2]
    (tmp_path / "tried").unlink()
    assert pz.fleet.identify({"shy": at_the_second_time}, retries=0, **KNOWN).error["shy"] == "ConnectionError: not yet"


@pytest.mark.skipif(condition="fork" not in get_all_start_methods(), reason="SKIPPED: processes do not fork here")
def test_a_forked_process_works_though_its_parent_did_before(undisturbed):
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as processes:
        table = pz.fleet.identify(fleet(4), processes, **KNOWN)
    assert list(table.model) == list(undisturbed.model[:4])


def test_a_frame_has_an_actuator_a_row():
    frame = pd.DataFrame({name: [row[name] for row in map(records, range(2))] for name in ("small_signal", "large_signal")}, index=["a", "b"])
    table = pz.fleet.identify(frame, **KNOWN)
    assert list(table.index) == ["a", "b"] and table.error.isna().all()
    with pytest.raises(pz.PiezoidError, match="2 rows have 1 names"):
        pz.fleet.identify(frame.set_axis(["a", "a"]), **KNOWN)


def test_processes_give_the_same_bits(undisturbed):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        table = pz.fleet.identify(fleet(4), processes, **KNOWN)
    assert list(table.model) == list(undisturbed.model[:4])
    assert not any(worker.endswith(f"/{os.getpid()}") for worker in table.worker)


def test_a_broken_pool_gives_rows_and_no_exception():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as processes:
        table = pz.fleet.run(kill_own_worker, {n: n for n in ["a", "poison", "b"]}, processes, chunk=1)
    assert table.error["poison"].startswith("BrokenProcessPool") and table.attempts["poison"] == 3
    assert list(table.index) == ["a", "poison", "b"]


def test_models_are_validated_and_turned_around_by_name(undisturbed, tmp_path):
    models = undisturbed.model[:3].to_dict() | {"stage 7": None}
    models["stage 0"].save(tmp_path / "0.json")
    models["stage 0"] = tmp_path / "0.json"
    unseen = {f"stage {i}": partial(sine, i, 11.0) for i in (1, 0, 4, 7)} | {"stage 2": [sine(2), partial(sine, 2, 11.0)]}
    proof = pz.fleet.validate(models, unseen, offset="free")
    assert list(proof.index) == ["stage 0", "stage 1", "stage 2", "stage 7", "stage 4"]
    assert list(proof.error.isna()) == [True, True, True, False, False]
    assert "no model" in proof.error["stage 4"] and "no model" in proof.error["stage 7"]
    two = [undisturbed.model["stage 2"].validate(sine(2, f), offset="free").max_abs for f in (5.0, 11.0)]
    assert proof.max_abs["stage 2"] == max(two)

    expected = 300 * np.sin(2 * np.pi * 5 * TS * np.arange(800))
    turned = pz.fleet.compensate(models, expected, smooth=0.01)
    assert np.array_equal(turned.u["stage 1"], models["stage 1"].compensate(expected, smooth=0.01))
    assert turned.u["stage 0"].shape == (800,) and list(turned.error.isna()) == [True, True, True, False]
    own = pz.fleet.compensate({"stage 1": models["stage 1"]}, {"stage 1": expected / 2})
    assert np.abs(own.reached["stage 1"] - expected / 2).max() < 15


def test_an_actuator_may_have_settings_and_proof_of_its_own():
    own = records(1) | {"operator": "stop", "test": partial(sine, 1, 11.0)}
    usual = records(1) | {"test": None, "data": float("nan")}  # missing values of a DataFrame
    table = pz.fleet.identify({"usual": usual, "own": own, "wrong": records(1) | {"ordre": 2}}, **KNOWN)
    assert list(table.operator[:2]) == ["prandtl-ishlinskii", "stop"]
    assert "ordre" in table.error["wrong"] and table.attempts["wrong"] == 1
    assert table.rms_pp_percent["own"] == table.model["own"].validate(sine(1, 11.0)).rms_pp_percent


def test_progress_counts_what_is_settled_and_may_end_the_work():
    message = []
    pz.fleet.run(lambda x: 1 / x, {1: 1, 2: 0, 3: 3}, progress=lambda *now: message.append(now))
    assert message[-1] == ("fleet", 3, 3) and [done for _, done, _ in message] == [1, 1, 2, 2, 3]

    def stop(*_: object) -> None:
        raise InterruptedError

    begun = time.perf_counter()
    with ThreadPoolExecutor(1) as threads, pytest.raises(InterruptedError):
        pz.fleet.run(time.sleep, dict.fromkeys(range(100), 0.05), threads, chunk=1, progress=stop)
    assert time.perf_counter() - begun < 2


def test_many_small_jobs_share_tasks():
    class Counted(ThreadPoolExecutor):
        tasks = 0

        def submit(self, *args: object, **kwargs: object) -> Future[object]:
            self.tasks += 1
            return super().submit(*args, **kwargs)

    with Counted(2) as engine:
        table = pz.fleet.run(abs, {n: -n for n in range(10_000)}, engine)
        assert engine.tasks == 625
        pz.fleet.run(abs, {n: n for n in range(10)}, engine, chunk=4)
        assert engine.tasks == 628
    assert list(table.value) == list(range(10_000))


def test_an_empty_fleet_is_an_empty_table():
    table = pz.fleet.identify({})
    assert table.empty and "model" in table.columns


def test_wrong_words_are_refused_before_any_work():
    with pytest.raises(TypeError, match="oder"):
        pz.fleet.identify(fleet(3), oder=2)
    with pytest.raises(TypeError, match="smoth"):
        pz.fleet.compensate({}, [0.0], smoth=1.0)
    with pytest.raises(pz.PiezoidError, match="client = 4"):
        pz.fleet.run(abs, {1: 1}, 4)


def test_without_dask_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(pz.PiezoidError, match=r"pip install piezoid\[fleet\]"), pz.fleet.local(2):
        pass
    assert pz.fleet.run(abs, {"a": -1}).value["a"] == 1


def test_the_readers_of_records_serve_fleets_too(tmp_path):
    sine(0).save(tmp_path / "0.csv")
    files: dict[str, Path] = {"file": tmp_path / "0.csv", "text": str(tmp_path / "0.csv"), "frame": sine(0).to_frame()}
    table = pz.fleet.identify(files, **KNOWN)
    assert table.error.isna().all() and len(set(table.model)) == 1


def test_what_would_lose_rows_or_run_nothing_is_refused() -> None:
    twice = pd.Series([1, 2], index=["a", "a"])
    with pytest.raises(pz.PiezoidError, match="the names of the 2 jobs are not all different"):
        pz.fleet.run(float, twice)
    for settings in [{"retries": -1}, {"chunk": 0}]:
        with pytest.raises(pz.PiezoidError, match="whole number"):
            pz.fleet.run(float, {"a": 1}, **settings)
