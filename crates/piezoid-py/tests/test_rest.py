"""Drive signals, twins, lists, control, export, the study."""

from __future__ import annotations

import inspect
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import piezoid as pz
import pytest


def test_a_plan_is_within_its_limits_and_written_to_a_folder(tmp_path: Path) -> None:
    result = pz.plan(tmp_path, range=(0, 120), bandwidth=50, driver="e-610", actuator="p-885.51")
    assert set(result) >= {"small", "rise1", "rise2", "rise3", "creep", "path"}
    assert all(u.min() >= 0 and u.max() <= 120 for u in result.values())
    assert "piezoid identify" in result.page and (tmp_path / "plan.md").read_text() == result.page
    assert result.advice is None and result.uncertainty is None
    with pytest.raises(pz.PiezoidError, match="range"):
        pz.plan(bandwidth=50)


def test_moves_are_timed_on_model_and_twin_and_along_a_measured_path(model: pz.Model) -> None:
    path = np.repeat([0.0, 200.0, -100.0], 800)
    found = pz.timing(model, path, tolerance="3um", smooth=0.02, driver="pl140", plant="pl140")
    assert list(dict.fromkeys(found.steps["run"])) == list(found.displacements)
    assert found.path.shape == found.u.shape == path.shape and found.tolerance == 3.0
    first = found.steps[found.steps["run"] == "model, compensated"]
    assert len(first) == 2 and first["settling_s"].max() < 0.021
    assert {"step", "flyback"} == set(found.fastest["purpose"]) and "ms" in repr(found)
    scan = 100 * np.sin(2 * np.pi * 10 * np.arange(1200) * model.ts)
    delayed = pz.timing(model, scan, measured=np.roll(scan, 4)).scans.set_index("run").loc["measured"]
    assert delayed["lag_s"] == pytest.approx(4 * model.ts, rel=1e-3)
    with pytest.raises(pz.PiezoidError, match="tolerance"):
        pz.timing(model, tolerance="3 V")
    with pytest.raises(pz.PiezoidError, match="equally long"):
        pz.timing(model, scan, measured=scan[:9])


def test_every_excitation_is_a_function_that_says_what_it_takes() -> None:
    assert {name.replace("-", "_") for name in pz.excitations} == set(pz.excite.__all__)
    for name in pz.excite.__all__:
        kind = getattr(pz.excite, name)
        needed = [p.name for p in inspect.signature(kind).parameters.values() if p.default is p.empty]
        values = {"amplitude": 5.0, "frequency": 5.0, "frequency_start": 1.0, "frequency_end": 50.0, "ts": 1e-3}
        input = {n: values.get(n, 10.0) for n in needed if n != "duration"}
        u = kind(duration=1.0, **input)
        assert u.shape == (1000,) and 0 < np.abs(u).max() <= 5.0 * 3, name
        assert "[V]" in (kind.__doc__ or "") and "Reference" in (kind.__doc__ or "")
    with pytest.raises(AttributeError, match="known are prbs"):
        pz.excite.noise  # noqa: B018
    with pytest.raises(pz.PiezoidError, match="did you mean `amplitude`"):
        pz.excite.sine(ts=1e-3, duration=1, amplitud=3, frequency=5)
    with pytest.raises(pz.PiezoidError, match="clock_divider"):
        pz.excite.prbs(ts=1e-3, duration=1, ampl=3)


def test_lists_answer_by_name_and_say_what_there_is() -> None:
    assert "preisach" in pz.operators and pz.targets["c"].summary.startswith("a header")
    assert "prandtl-ishlinskii" in repr(pz.operators) and len(pz.plants) == 12
    stack, driver = pz.actuators["p-885.51"], pz.drivers["pdu150cl"]
    assert stack.summary.startswith("PI P-885.51, stack: 15 um") and stack.figures["stroke_at"] == [0, 100]
    assert driver.figures["current"] == 0.3 and driver.figures["capacitance"] is None and driver.reference
    with pytest.raises(pz.PiezoidError, match="no operator called `x`: known are proportional"):
        pz.operators["x"]


def test_twins_are_what_the_command_line_measures_on_and_may_be_changed() -> None:
    plant = pz.plants["pl140"]
    u = pz.excite.sine(ts=5e-4, duration=0.2, amplitude=20, frequency=10)
    assert np.array_equal(plant.simulate(u), plant.simulate(u, seed=1))
    assert not np.array_equal(plant.simulate(u), plant.simulate(u, seed=2))
    assert pickle.loads(pickle.dumps(plant)) == plant == pz.Plant(plant.to_dict())
    stiffer = plant.to_dict() | {"creep_per_decade": 0.0}
    assert pz.Plant(stiffer) != plant
    one, other = plant.drawn(seed=3), plant.drawn(seed=3, index=1)
    assert one != other and one == plant.drawn(seed=3) and other.name == "pl140-1"
    with pytest.warns(UserWarning, match="driver's current"):
        plant.simulate([0.0, 30.0, -30.0] * 20)
    with pytest.raises(pz.PiezoidError, match="rest or settled"):
        plant.simulate(u, begin="moving")  # type: ignore[arg-type]
    with pytest.raises(pz.PiezoidError, match="tolerance|share"):
        plant.drawn(1.5)


def test_controllers_are_compared_on_a_twin(model: pz.Model) -> None:
    r = 400 * np.sin(2 * np.pi * 5 * np.arange(1200) * model.ts)
    found = pz.control("pl140", model, {"sine": r}, controller=["gain", "feed-forward+pi"], driver="pl140")
    table = found.table
    assert list(table.index) == ["sine"] and table["feed-forward+pi"].iloc[0] < 0.3 * table["gain"].iloc[0]
    assert found.run("feed-forward+pi")["u"].shape == r.shape and "<html" in found.html
    with pytest.raises(pz.PiezoidError, match="no run of pid"):
        found.run("pid")
    with pytest.raises(pz.PiezoidError, match="no controller called `pd`"):
        pz.control("pl140", model, r, controller="pd")


def test_models_are_compared_on_records(tmp_path: Path, model: pz.Model, rich: pz.Record) -> None:
    weaker = model.to_dict()
    weaker["linear"]["b"] = [0.9 * b for b in weaker["linear"]["b"]]
    model.save(tmp_path / "good.json")
    found = pz.compare({"good": model, "weak": pz.Model.from_dict(weaker)}, {"a": rich, "b": rich.part(0.5)}, record="b")
    assert found.best == "good" and "smallest error" in (found.summary or "") and "<html" in found.html
    assert found.table.loc["weak", "total"] > found.table.loc["good", "total"]
    assert found.table.loc["good", "a"] == model.validate(rich).rms_pp_percent
    listed = pz.compare([tmp_path / "good.json", model, pz.Model.from_dict(weaker)], [rich])
    twins = [f"{model.operator} (1)", f"{model.operator} (2)"]
    assert list(listed.table.index) == ["good.json", *twins] and list(listed.table.columns) == ["record 1"]
    assert pz.compare(tmp_path / "good.json", rich).best == "good.json"
    for message, call in {
        "models is empty": lambda: pz.compare([], rich),
        "data is empty": lambda: pz.compare(model, {}),
        "no record called `c`": lambda: pz.compare(model, {"a": rich}, record="c"),
        "skip = -1": lambda: pz.compare(model, rich, skip=-1),
    }.items():
        with pytest.raises(pz.PiezoidError, match=message):
            call()


def test_functions_are_compared_with_operators_on_one_split(rich: pz.Record, model: pz.Model) -> None:
    trained: list[list[pz.Record]] = []

    class Line:
        """A straight line with two parameters."""

        parameters = 2

        def __init__(self, train: list[pz.Record]) -> None:
            u, y = (np.concatenate([getattr(one, name) for one in train]) for name in "uy")
            self.line = np.polyfit(u, y, 1)

        def simulate(self, u: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
            return np.asarray(np.polyval(self.line, u))

    def line(train: list[pz.Record]) -> Line:
        trained.append(train)
        return Line(train)

    def fails(train: list[pz.Record]) -> None:
        raise ValueError("no idea")

    methods = {"line": line, "given": lambda u: 30 * u, "model": model, "fails": fails, "short": lambda u: u[1:]}
    found = pz.compare(rich, methods, operators=["stop"], structures="hammerstein,linear", effort="quick", offset="free")
    ranking = found.ranking
    assert set(ranking.index) == {"stop", "linear", *methods}
    n = round(0.75 * len(rich))
    assert len(trained[0]) == 1 and trained[0][0] == pz.Record(rich.u[:n], rich.y[:n], rich.ts)
    assert "ValueError: no idea" in ranking.loc["fails", "reason"] and "samples" in ranking.loc["short", "reason"]
    assert ranking.loc["line", "parameters"] == 2 and ranking.loc["line", "fit_s"] > 0
    assert ranking.loc["stop", "step_ns"] > 0 and pd.isna(ranking.loc["given", "parameters"])
    # The same figures as on the held-out part alone, without memory.
    held = pz.Record(rich.u[n:], rich.y[n:], rich.ts)
    left = held.y - Line(trained[0]).simulate(held.u)
    expected = 100 * (left - left.mean()).std() / np.ptp(held.y)
    np.testing.assert_allclose(ranking.loc["line", "rms_pp_percent"], expected, rtol=1e-9)
    again = pz.compare(rich, methods, operators="stop", structures=["hammerstein", "linear"], effort="quick", offset="free")
    assert (again.figures, again.html, again.svg) == (found.figures, found.html, found.svg)
    other = pz.compare(records=[rich], methods=line, data=held)
    assert list(other.ranking.index) == ["line"] and other.figures["split"]["held_out"] is None
    assert trained[-1][0] == rich
    assert list(pz.compare(records=[rich], methods={"class": Line}, data=held).ranking.index) == ["class"]
    trained.clear()
    for message, call in {
        "did you mean": lambda: pz.compare(rich, line, operators="stopp"),
        "two methods are called": lambda: pz.compare(rich, [line, line]),
        "from 0 to 12": lambda: pz.compare(rich, line, structures="order-99"),
        "skip": lambda: pz.compare(rich, line, skip=1e6),
        "there are no names": lambda: pz.compare(rich, operators=[]),
        "held_out = 1": lambda: pz.compare(rich, operators="stop", held_out=1),
    }.items():
        with pytest.raises(pz.PiezoidError, match=message):
            call()
    assert not trained, "what is wrong is found before the work"


def test_errors_call_settings_by_their_names_here(model: pz.Model, rich: pz.Record) -> None:
    plant, r = pz.plants["pl140"], [0.0, 100.0, 0.0]
    wrong = {
        "skip = -1": lambda: model.validate(rich, skip=-1),
        "start = -1": lambda: rich.part(-1),
        "stop = 'end'": lambda: rich.part(0, "end"),  # type: ignore[arg-type]
        "ts = 'x'": lambda: pz.Record([0.0], [0.0], ts="x"),  # type: ignore[arg-type]
        "peak = -1": lambda: pz.reference("sine", model, peak=-1, frequency=5, duration=1),
        "tolerance = 2": lambda: plant.drawn(2),
        "tolerance = 0.1": lambda: pz.control(plant, model, r, tolerance=0.1),  # type: ignore[arg-type]
        "gain_margin = -1": lambda: pz.control(plant, model, r, gain_margin=-1),
        "plant = None": lambda: pz.control(None, model, r),  # type: ignore[arg-type]
        "there is no controller": lambda: pz.control(plant, model, r, controller=[]),
        "driver_lag = -1": lambda: pz.identify(data=rich, driver_lag=-1),
        "low = -inf": lambda: model.compensate(r, low=float("-inf")),
        "range = 3": lambda: pz.export(model, "waveform", reference=r, range=3),  # type: ignore[arg-type]
        "model = 3": lambda: pz.export(3, "c"),  # type: ignore[arg-type]
        "give controller=": lambda: pz.export(model, "c", delay_samples=2),
        "servo_cycle = 0.001: does not apply to": lambda: pz.export(model, "c", servo_cycle=1e-3),
        "not the parameters of a plant": lambda: pz.Plant("pl140"),
        "cannot contain a set": lambda: pz.Model.from_dict({"ts": {1}}),
    }
    for message, call in wrong.items():
        with pytest.raises(pz.PiezoidError) as raised:
            call()
        assert message in str(raised.value)


def test_a_model_is_exported_as_code_that_gives_its_numbers(model: pz.Model, tmp_path: Path) -> None:
    files = pz.export(model, "c", tmp_path / "bender", name="bender", controller="pi", driver="pl140")
    assert {path.name for path in (tmp_path / "bender").iterdir()} == {*files, "piezoid-export.json"}
    build = ["cc", "-std=c99", "-ffp-contract=off", "bender.c", "bender_test.c", "-o", "self_test"]
    subprocess.run(build, cwd=tmp_path / "bender", check=True)
    sentence = subprocess.run(["./self_test"], cwd=tmp_path / "bender", check=True, capture_output=True, text=True).stdout
    assert sentence.count("0 of 400 differ") == 3
    with pytest.raises(pz.PiezoidError, match="float = true: does not apply to the target fixed"):
        pz.export(model, "fixed", float=True)
    with pytest.raises(pz.PiezoidError, match="must begin with a letter"):
        pz.export(model, "c", tmp_path / "nothing", name="1")
    assert not (tmp_path / "nothing").exists()


def test_the_study_gives_its_tables_and_page(tmp_path: Path) -> None:
    study = pz.study("paper")
    held = study.table1.query("method == 'held-direction' and frequency_hz == 5")["mse"].iloc[0]
    assert held < 1e-5 and len(study.table2) >= 2 and "5 Hz" in study.verdict
    study.save(tmp_path)
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>") and list(tmp_path.glob("*.svg"))


def test_linear_blocks_are_fitted_and_run(small: pz.Record) -> None:
    from scipy.signal import lfilter

    fit = pz.linear.fit(small, 2, estimator="output-error")
    a, b = fit.arx.a, fit.arx.b
    assert np.allclose(fit.arx.simulate(small.u), lfilter(b, np.r_[1, -a], small.u), rtol=1e-9, atol=1e-9)
    assert fit.arx.is_stable and abs(fit.arx.poles[0]["hz"] - 166) < 2 and pz.linear.Arx(a, b, small.ts) == fit.arx
    assert pickle.loads(pickle.dumps(fit)) == fit and f"{a[0]:.6f}" in repr(fit.arx)
    with pytest.raises(pz.PiezoidError, match=r"y\[1\] is NaN"):
        fit.arx.predict([0.0, 1.0], [0.0, float("nan")])


def test_blocks_are_fitted_in_one_unit(small: pz.Record) -> None:
    alone = pz.linear.fit(small).arx
    both = pz.linear.fit([small, small.output_in("nm")]).arx
    assert np.allclose(both.a, alone.a) and np.allclose(both.b, alone.b)
    with pytest.raises(pz.PiezoidError, match="the conversion is unknown"):
        pz.linear.fit([small, pz.Record(small.u, small.y, small.ts, units=("V", "furlong"))])


def test_a_file_of_a_run_that_was_killed_is_told(tmp_path: Path, model: pz.Model) -> None:
    path = tmp_path / "m.json"
    model.save(path)
    pz.load(path)
    about = "piezoid was ended while it replaced these files: some may be new and others old.\n"
    about += "Repeat the command that writes them all; it removes this file.\n"
    (tmp_path / "piezoid-unfinished.txt").write_text(f"{about}\nm.json\n")
    with pytest.warns(UserWarning, match="m.json may be older than other files of its run"):
        pz.load(path)
