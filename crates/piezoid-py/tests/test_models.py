"""Models: bit-identical to the library, and their properties."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import piezoid as pz
import pytest

VECTORS = sorted((Path(__file__).parents[2] / "piezoid/tests/compatibility").glob("*/operators/*.json"))


def test_there_is_a_vector_file_for_every_operator() -> None:
    assert {file.stem for file in VECTORS} == {*pz.operators, "driven"}


@pytest.mark.parametrize("file", VECTORS, ids=lambda file: f"{file.stem}-{file.parts[-3]}")
def test_every_operator_gives_the_numbers_of_its_vector_file_to_the_bit(file: Path) -> None:
    vectors = json.loads(file.read_text())
    model = pz.Model.from_dict(vectors["model"])
    inputs, outputs = (np.array(vectors["step"][part]) for part in ["inputs", "outputs"])
    for input in [inputs, list(inputs), np.repeat(inputs, 3)[::3]]:
        assert model.simulate(input).tobytes() == outputs.tobytes()
    if "ff_step" in vectors:
        r, u = (np.array(vectors["ff_step"][part]) for part in ["inputs", "outputs"])
        assert model.inverse().resume(r).tobytes() == u.tobytes()
        one_by_one = model.inverse()
        assert [one_by_one.step(v) for v in r[:50]] == u[:50].tolist()


def test_what_was_identified_says_what_it_is(model: pz.Model) -> None:
    assert model.operator == "prandtl-ishlinskii" and model.units == ("V", "um")
    assert model.resonance is not None and abs(model.resonance[0] - 166.3) < 0.1
    assert model.input_range == (-28.0, 28.0)
    assert "mode 1 frequency [Hz]" in list(model.parameters["name"])
    assert list(model.trials["operator"]) == ["prandtl-ishlinskii"]
    assert model.notes and model.notes[0].startswith("linear block: ")
    assert "166.3 Hz" in repr(model) and "prandtl-ishlinskii" in model._repr_html_()


def test_models_travel_by_file_and_pickle(model: pz.Model, tmp_path: Path) -> None:
    model.save(tmp_path / "m.json")
    for again in [pz.load(tmp_path / "m.json"), pickle.loads(pickle.dumps(model)), pz.Model(model.to_json())]:
        assert again == model and hash(again) == hash(model) and again.to_json() == model.to_json()
    by_hand = pz.Model.from_dict(model.to_dict() | {"fit": {"trials": 5, "notes": "none"}})
    assert by_hand.trials.empty and by_hand.parameters.empty and by_hand.notes == []
    changed = model.to_dict() | {"offset": 1.0}
    assert pz.Model.from_dict(changed) != model
    with pytest.raises(pz.PiezoidError, match="none.json: there is no such file"):
        pz.load(tmp_path / "none.json")
    with pytest.raises(pz.PiezoidError, match="m.json: not a model file"):
        (tmp_path / "m.json").write_text("{}")
        pz.load(tmp_path / "m.json")
    with pytest.raises(pz.PiezoidError, match="cannot write"):
        model.save(tmp_path / "no folder" / "m.json")


def test_one_step_ahead_errors_do_not_add_up(model: pz.Model, unseen: pz.Record) -> None:
    y = model.simulate(unseen.u)
    assert np.allclose(model.predict(unseen.u, y), y, atol=1e-6)
    off = y.copy()
    off[1000] += 1.0
    moved = np.flatnonzero(np.abs(model.predict(unseen.u, off) - y) > 1e-3)
    assert moved.tolist() == list(range(1001, 1001 + len(model.a)))


def test_the_linear_block_answers_at_frequencies(model: pz.Model) -> None:
    response = model.response([1e-3, 166.28])
    assert abs(abs(response[0]) / model.dc_gain - 1) < 1e-6 and abs(response[1]) > 10 * model.dc_gain


def test_validation_gives_the_figures_of_the_command_line(model: pz.Model, unseen: pz.Record) -> None:
    found = model.validate(unseen)
    error = unseen.y - found.simulated
    assert np.allclose(found.mse, np.mean(error**2)) and found.n == len(unseen)
    assert np.allclose(found.nrmse_percent, 100 * found.rmse / np.std(unseen.y))
    assert np.allclose(found.rms_pp_percent, 100 * found.rmse / np.ptp(unseen.y))
    assert {"at", "nrmse_percent", "rms_pp_percent"} <= set(found.table.columns)
    assert np.array_equal(found.residual, error) and found.rms_pp_percent < 2
    assert len(found.loops) >= 1 and "measured.width_percent" in found.loops.columns
    free = model.validate(unseen, skip=0.2, offset="free")
    assert free.start == 400 and abs(free.residual[400:].mean()) < 1e-9
    with pytest.raises(pz.PiezoidError, match="there is no such file"):
        model.validate("none.csv")
    with pytest.raises(pz.PiezoidError, match="kept or free or drift"):
        model.validate(unseen, offset="none")  # type: ignore[arg-type]
    with pytest.raises(pz.PiezoidError, match="sampled every"):
        model.validate(pz.Record(unseen.u, unseen.y, ts=7e-4))


def test_noise_and_drift_are_told_apart_from_the_error_of_the_model(model: pz.Model, unseen: pz.Record) -> None:
    seconds = np.arange(len(unseen)) * unseen.ts
    noise = np.random.default_rng(1).standard_normal(len(unseen))
    y = model.simulate(unseen.u, begin="likely") + 4.0 * seconds + 0.5 * noise
    record = pz.Record(unseen.u, y, ts=unseen.ts, units=unseen.units)
    free, rest = model.validate(record, offset="free"), model.validate(record, offset="drift")
    assert free.drift_per_s == pytest.approx(4, rel=0.05) == rest.drift_per_s
    assert free.nrmse_without_drift_percent == pytest.approx(rest.nrmse_percent, rel=1e-3)
    assert rest.floor is not None and rest.floor["rms"] == pytest.approx(0.5, rel=0.15) and rest.rmse < 0.6
    assert free.summary is not None and "of which drift" in free.summary and "noise" in repr(rest)


def test_the_voltage_for_a_reference_makes_the_twin_follow(model: pz.Model) -> None:
    r = 600 * np.sin(2 * np.pi * 5 * np.arange(2000) * model.ts)
    u = model.compensate(r, driver="pl140")
    y = pz.plants["pl140"].simulate(u, model.ts)
    assert np.std((y - r)[400:]) / np.ptp(r) < 0.01
    result = model.compensation(r, low=-25, high=25)
    assert np.abs(result.u).max() <= 25 and np.std((result.reached - r)[400:]) < 1 and result.clipped == 0
    shaped = model.compensation(np.repeat([0.0, 500.0], 1000), smooth=0.02, zvd=True)
    assert np.abs(shaped.reached[1200:] - 500).max() < 5
    with pytest.raises(pz.PiezoidError, match="cannot be reached"):
        model.compensate([2000.0] * 10)
    assert model.compensation([2000.0] * 10, clip=True).clipped > 0
    steps = np.repeat([0.0, 30.0, 0.0], 600)
    fast = model.compensation(steps)
    assert fast.smoothing is not None and fast.notes[-1].startswith(f"smooth={fast.smoothing['smooth']} keeps")
    assert model.compensation(steps, smooth=fast.smoothing["smooth"]).smoothing is None
    assert np.array_equal(model.compensate(steps), fast.u)
    with pytest.raises(pz.PiezoidError, match="capacitance"):
        model.compensate(r, driver="bd300")


def test_the_inverse_runs_sample_by_sample_and_begins_anew(model: pz.Model) -> None:
    inverse = model.inverse(4, driver="pl140")
    r = 300 * np.sin(0.03 * np.arange(500))
    first = inverse.resume(r)
    inverse.reset()
    assert np.array_equal(np.array([inverse.step(v) for v in r]), first) and inverse.delay_samples == 4
    inverse.reset(200.0)
    assert abs(inverse.step(200.0) - model.compensate([200.0] * 5)[0]) < 1e-6


def test_a_refused_sample_leaves_no_trace_and_a_saved_state_continues_to_the_bit(model: pz.Model) -> None:
    random = np.random.default_rng(7)
    r = 300 * np.sin(0.03 * np.arange(900)) + random.normal(size=900)
    refused = random.random(900) < 1 / 3
    inverse, voltages = model.inverse(4, driver="pl140"), []
    for k, (value, is_refused) in enumerate(zip(r, refused, strict=True)):
        u = inverse.plan(value)
        if not is_refused:
            inverse.commit()
            voltages.append(u)
        if k == 450:
            state = json.loads(json.dumps(inverse.save_state()))
            inverse = model.inverse(4, driver="pl140")
            inverse.restore(state)
    assert 200 < refused.sum() < 400
    assert np.array(voltages).tobytes() == model.inverse(4, driver="pl140").resume(r[~refused]).tobytes()


def test_states_of_others_and_plans_that_do_not_exist_are_refused(model: pz.Model) -> None:
    inverse = model.inverse(4)
    with pytest.raises(pz.PiezoidError, match="nothing is planned"):
        inverse.commit()
    assert inverse.plan(10.0) != inverse.plan(20.0)
    inverse.step(10.0)
    with pytest.raises(pz.PiezoidError, match="nothing is planned"):
        inverse.commit()
    state = inverse.save_state()
    other = pz.Model.from_dict(model.to_dict() | {"offset": model.offset + 1}).inverse(4)
    for wrong in [other, model.inverse(5)]:
        with pytest.raises(pz.PiezoidError, match="state of another model"):
            wrong.restore(state)
    for broken, words in [
        (state | {"numbers": state["numbers"][1:]}, "must have"),
        (state | {"numbers": [None] * len(state["numbers"])}, "save_state"),
        ({}, "save_state"),
    ]:
        before = inverse.save_state()
        with pytest.raises(pz.PiezoidError, match=words):
            inverse.restore(broken)
        assert inverse.save_state() == before


def test_settings_that_nobody_knows_are_refused_and_so_are_numbers_that_are_none(model: pz.Model) -> None:
    for wrong in [lambda: model.inverse(hihg=10.0), lambda: pz.control("pl140", model, [0.0], hihg=10.0),
                  lambda: model.inverse(zvd=True)]:  # fmt: skip
        with pytest.raises(TypeError, match="options are "):
            wrong()
    with pytest.raises(TypeError, match="options are name"):
        pz.export(model, "c", lwo=-1.0)
    for refused in [lambda: model.inverse(-1), lambda: model.compensation([0.0], iterations=-1),
                    lambda: pz.plants["paper"].simulate([0.0], seed=2**64), lambda: model.inverse(1.5)]:  # type: ignore[arg-type]  # fmt: skip
        with pytest.raises(pz.PiezoidError, match="must be a whole number"):
            refused()
    with pytest.raises(pz.PiezoidError, match="finite"):
        model.inverse().reset(float("nan"))
    assert len(model.simulate([], begin="likely")) == 0


def test_a_failing_input_tells_where(model: pz.Model) -> None:
    with pytest.raises(pz.PiezoidError, match=r"u\[3\] is inf"):
        model.simulate([0.0, 1.0, 2.0, float("inf")])
    assert isinstance(pz.PiezoidError("x"), ValueError)
    assert len(model.simulate([])) == 0


def test_a_gaussian_process_states_its_standard_deviation_and_others_refuse(model: pz.Model) -> None:
    text = next(file for file in VECTORS if file.stem == "gaussian-process").read_text()
    process = pz.Model.from_dict(json.loads(text)["model"])
    u = 20 * np.sin(0.1 * np.arange(500))
    within, beyond = process.deviation(u), process.deviation(5 * u, begin="settled")
    assert within.shape == u.shape and 0 < within.max() < beyond.max()
    with pytest.raises(pz.PiezoidError, match="gaussian-process"):
        model.deviation(u)


def test_a_model_follows_a_gain_sample_by_sample_and_along_a_record(model: pz.Model) -> None:
    u = 25 * np.sin(0.05 * np.arange(4000))
    y = 1.1 * model.simulate(u, begin="settled")
    by_sample, by_record = pz.Online(model, every=0.5), pz.Online(model, every=0.5)
    rows = [row for row in map(by_sample.step, u, y) if row is not None]
    table = by_record.follow(pz.Record(u, y, model.ts, units=model.units))
    assert list(table["gain"]) == [row["gain"] for row in rows] and len(rows) == 4
    assert by_record.model == by_sample.model and by_record.samples == len(u)
    assert by_record.parameters["gain"] == pytest.approx(1.1, abs=0.02)
    with pytest.raises(pz.PiezoidError, match="sampl"):
        by_record.follow(pz.Record(u, y, 2 * model.ts, units=model.units))
    with pytest.raises(TypeError, match="gain_memory"):
        pz.Online(model, gain_memry=20)
