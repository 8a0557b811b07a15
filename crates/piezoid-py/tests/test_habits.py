"""What Python users expect: DataFrames, arrays as they have them, one line that says what it is, figures, summaries."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import piezoid as pz
import pytest

HOW = {"operator": "prandtl-ishlinskii", "order": 2}


@pytest.fixture(scope="module")
def record() -> pz.Record:
    u = pz.excite.rising_sine(ts=1e-3, duration=2, amplitude=28, frequency=4)
    return pz.plants["pl140"].measure(u, ts=1e-3)


@pytest.fixture(scope="module")
def found(record: pz.Record) -> pz.Model:
    return pz.identify(record, **HOW)


def test_frames_and_arrays_of_the_same_numbers_give_the_same_model(record: pz.Record, found: pz.Model) -> None:
    frame = pd.DataFrame({"u [V]": record.u, "Position (um)": record.y})
    timed = frame.set_index(pd.to_timedelta(record.t, unit="s"))
    assert pz.identify(frame, fs=1000, **HOW) == pz.identify(frame, ts=1e-3, **HOW) == found
    assert pz.identify(timed, **HOW) == found
    assert pz.identify(record.u, record.y, fs=1000, **HOW) == found
    column = record.y[:, np.newaxis]
    assert pz.identify(frame[["u [V]"]], column, ts=1e-3, **HOW) == found
    nm = pz.identify(record.u, 1e3 * record.y, fs=1000, units={"y": "nm"}, **HOW)
    assert nm.units == ("V", "nm")


def test_what_identify_cannot_take_is_refused_with_the_remedy(record: pz.Record, tmp_path: Path) -> None:
    u, y = record.u, record.y
    (tmp_path / "rig.toml").write_text("fs = 1000.0\n")
    for call, says in [
        (lambda: pz.identify(u, y), "give either ts, the sampling period"),
        (lambda: pz.identify(u, y, ts=1e-3, fs=1e3), "give either ts"),
        (lambda: pz.identify(u, y, fs=-1), "fs = -1: must be a positive number of Hz"),
        (lambda: pz.identify(u, fs=1e3), r"shape \(2000,\): give input and output, as in identify\(u, y, fs=2000\)"),
        (lambda: pz.identify(u, y, fs=1e3, profile=tmp_path / "rig.toml"), "profile: says how columns are read"),
        (lambda: pz.identify(pd.DataFrame({"u [V]": u, "y [um]": y})), "ts= or fs=|fs="),
        (lambda: pz.identify(u, np.stack([y, y], axis=1), fs=1e3), r"y has shape \(2000, 2\)"),
        (lambda: pz.identify(record, target="cpp"), "no target called `cpp`: known are c"),
        (lambda: pz.identify(record, target="c", operator="stopp"), "did you mean `stop`"),
    ]:  # fmt: skip
        with pytest.raises(pz.PiezoidError, match=says):
            call()


def test_a_model_for_a_target_tries_what_the_target_serves(record: pz.Record, found: pz.Model) -> None:
    same = pz.identify(record, target="fixed", **HOW)
    assert same == found and same.provenance["options"] == HOW
    assert pz.targets["waveform"].operators["preisach"] == ["feed-forward"]
    served = pd.DataFrame({name: target.operators for name, target in pz.targets.items()})
    assert set(served.index) == set(pz.operators) and served.loc["stop", "c"] == ["model", "feed-forward"]


def test_records_take_columns_rates_and_units_by_name() -> None:
    column = np.array([[0.0], [1.0], [2.0]])
    plain = pz.Record([0, 1, 2], [0, 1, 2], 5e-4)
    assert pz.Record(column, pd.DataFrame({"y": [0, 1, 2]}), fs=2000) == plain
    assert pz.Record(column, column, 5e-4, units={"y": "nm"}).units == ("V", "nm")
    assert pz.read({"u_V": [0, 1], "y_mm": [0, 1]}, ts=1.0, units={"u": "mV"}).units == ("mV", "mm")
    for units, says in [({"y": "um", "x": "V"}, "must name u and y"), ({"u": 3}, "must be names")]:
        with pytest.raises(pz.PiezoidError, match=says):
            pz.Record(column, column, 5e-4, units=units)  # type: ignore[arg-type]
    with pytest.raises(pz.PiezoidError, match=r"u has shape \(3, 2\)"):
        pz.Record(np.zeros((3, 2)), [0, 1, 2], 5e-4)
    with pytest.raises(pz.PiezoidError, match="masked array"):
        pz.Record(np.ma.masked_equal(column, 1.0), column, 5e-4)


def test_a_frame_gives_a_frame_with_its_index(found: pz.Model, record: pz.Record) -> None:
    frame = pd.DataFrame({"note": ["a"] * 2000, "Drive (V)": record.u}, index=pd.RangeIndex(7, 2007))
    out = found.simulate(frame, begin="settled")
    assert list(out.columns) == ["y_um"] and out.index.equals(frame.index)
    assert np.array_equal(out["y_um"], found.simulate(record.u, begin="settled"))
    stamps = pd.date_range("2026-01-01", periods=2000, freq="1ms")
    assert found.simulate(frame.set_index(stamps)).index.equals(stamps)
    two = pd.DataFrame({"CH1 [V]": record.u, "CH2 [V]": record.u})
    assert len(found.simulate(two, input_col="CH2 [V]")) == 2000
    with pytest.raises(pz.PiezoidError, match="input_col="):
        found.simulate(two)
    with pytest.raises(pz.PiezoidError, match="sampled every 0.001 s but the input every 0.002 s: resample it"):
        found.simulate(frame.set_index(pd.date_range("2026-01-01", periods=2000, freq="2ms")))
    with pytest.raises(pz.PiezoidError, match="input_col = 'u': names a column of a DataFrame"):
        found.simulate(record.u, input_col="u")  # type: ignore[call-overload]


def test_a_model_tells_what_it_is_and_how_good_it_is(found: pz.Model) -> None:
    verdict = found.verdict
    assert verdict is not None and verdict.error_percent < 5 and verdict.u == pytest.approx((-28, 28), rel=0.05)
    assert str(verdict).startswith(f"{verdict.short} (free run") and "minor loops" not in verdict.unproven
    assert repr(found).startswith("<Model prandtl-ishlinskii, order 2, ") and verdict.short in repr(found)
    message = found.summary()
    assert message.startswith("prandtl-ishlinskii, gain ") and "\nGood to " in message
    assert all(len(line) <= 100 for line in message.splitlines())
    assert all(name in message for name in found.parameters["name"])
    bare = pz.Model.from_dict({key: part for key, part in found.to_dict().items() if key != "fit"})
    assert bare.verdict is None and "no verdict" in repr(bare) and "No verdict in its file." in bare.summary()


def test_a_model_draws_its_parts(found: pz.Model) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    axes = found.plot()
    assert [ax.get_ylabel() for ax in axes] == ["hidden variable z [V]", "gain [µm/V]", "phase [°]"]
    _, axes = plt.subplots(3)
    assert list(found.plot(ax=axes)) == list(axes)
    bare = pz.Model.from_dict({key: part for key, part in found.to_dict().items() if key not in ("fit", "identified")})
    bare.plot()
    plt.close("all")


def test_a_profile_of_the_page_reads_the_files_of_a_rig(tmp_path: Path) -> None:
    text = 'time_col = "x-axis"\ninput_col = "1"\noutput_col = "2"\ninput_scale = "20"\noutput_scale = "5um/V"\n'
    (tmp_path / "bench.toml").write_text(text)
    for k in (1, 2):
        rows = "".join(f"{t * 1e-3:.3f},{0.1 * t % 1:.2f},{0.5 * t % 1 + k}\n" for t in range(100 * k))
        (tmp_path / f"scope_{k}.csv").write_text(f"x-axis,1,2\nsecond,Volt,Volt\n{rows}")
    inspections = [pz.inspect(tmp_path / f"scope_{k}.csv") for k in (1, 2)]
    assert [inspection.record for inspection in inspections] == [None, None]
    assert inspections[0].figures["layout"] == inspections[1].figures["layout"]
    one, two = (pz.read(tmp_path / f"scope_{k}.csv", profile=tmp_path / "bench.toml") for k in (1, 2))
    assert (len(one), len(two), two.units) == (100, 200, ("V", "um"))
    assert one.u[1] == 2.0 and two.y[1] == 12.5


def test_a_source_is_inspected_and_its_profile_reads_it_again(tmp_path: Path) -> None:
    t = np.arange(400)
    scope = {"CH1": 0.1 * np.sin(0.1 * t), "CH2": np.cos(0.1 * t)}
    inspection = pz.inspect(scope, fs=1000)
    assert inspection.record is None and "input_col=" in (inspection.error or "") and "no record: " in repr(inspection)
    with pytest.raises(pz.PiezoidError, match="there is no profile, because there is no record"):
        inspection.save_profile(tmp_path / "rig.toml")
    how = {"fs": 1000, "input_col": "CH1", "input_scale": 20, "output_col": "CH2", "output_scale": "5um/V"}
    inspection = pz.inspect(pd.DataFrame(scope), **how)
    assert list(inspection.channels["role"]) == ["input", "output"] and "DataFrame" in repr(inspection)
    inspection.save_profile(tmp_path / "rig.toml")
    again = pz.read(scope, profile=tmp_path / "rig.toml")
    assert again == inspection.record and again.units == ("V", "um") and np.allclose(again.u, 20 * scope["CH1"])
    # A keyword counts more than the profile.
    assert pz.read(scope, profile=tmp_path / "rig.toml", ts=1.0).ts == 1.0
    again.save(tmp_path / "r.csv")
    file = pz.inspect(tmp_path / "r.csv")
    assert file.figures["format"] == "csv" and file.record == again and str(tmp_path / "r.csv") in repr(file)
    (tmp_path / "wrong.toml").write_text("inputcol = 3\n")
    with pytest.raises(pz.PiezoidError, match="wrong.toml"):
        pz.read(scope, profile=tmp_path / "wrong.toml")
    with pytest.raises(pz.PiezoidError, match="none.toml: there is no such file"):
        pz.read(scope, profile=tmp_path / "none.toml")
    with pytest.raises(TypeError, match="unexpected keyword 'input_column'"):
        pz.inspect(scope, input_column=1)


def test_an_export_tells_its_operations_and_is_not_mixed_with_another(found: pz.Model, tmp_path: Path) -> None:
    result = pz.export(found, "c", tmp_path / "out", name="a")
    operations = result.operations
    assert list(operations.index) == ["step", "ff_step"]
    assert (operations["most_seen"] <= operations["bound"]).all() and operations.loc["step", "bound"] > 0
    assert f"bound {operations.loc['step', 'bound']} for every input" in repr(result)
    pz.export(found, "c", tmp_path / "out", name="a")
    with pytest.raises(pz.PiezoidError, match=r"out: the folder holds .* target c, name a: .* give force=True"):
        pz.export(found, "c", tmp_path / "out", name="b")
    pz.export(found, "c", tmp_path / "out", name="b", force=True)
    assert (tmp_path / "out" / "a.c").exists() and (tmp_path / "out" / "b.c").exists()
