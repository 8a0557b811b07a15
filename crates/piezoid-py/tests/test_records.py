"""Records from any data that Python has."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import piezoid as pz
import pytest

U, Y = np.array([0.0, 1.0, 1.5, -2.0]), np.array([0.0, 20.0, 33.0, -40.0])
T = np.arange(4) * 5e-4


@pytest.mark.parametrize(
    "u",
    [
        U.tolist(),
        tuple(U),
        U.astype(">f8"),
        U.astype(np.float32),
        np.repeat(U, 2)[::2],
        np.stack([U, U], axis=1)[:, 0],
        pd.Series(U),
        U.astype(object),
        np.frombuffer(b"x" + U.tobytes(), offset=1),
    ],
    ids=["list", "tuple", "big endian", "float32", "strided", "column", "Series", "objects", "misaligned"],
)
def test_samples_may_be_anything_that_numpy_takes_for_numbers(u: Any) -> None:
    assert np.array_equal(pz.Record(u, Y, ts=5e-4).u, U)


def test_whole_numbers_are_numbers() -> None:
    assert pz.Record([0, 1], np.array([2, 3], dtype=np.uint8), ts=1).y.tolist() == [2.0, 3.0]


@pytest.mark.parametrize(
    ("u", "message"),
    [
        (np.zeros((4, 2)), "shape (4, 2)"),
        (np.zeros((1, 4)), "shape (1, 4)"),
        (np.zeros(()), "shape ()"),
        (np.array(["a"] * 4), "real numbers"),
        (U + 1j, "complex128"),
        ([0.0, 1.0, float("nan"), 2.0], "u[2] is NaN"),
        (np.ma.masked_array(U, U > 1), "masked"),
        (U[:3], "u has 3 samples but y has 4"),
        ([[1.0], [2.0, 3.0]], "is not a series of numbers"),
        ([None, 1.0, 2.0, 3.0], "NaN"),
    ],
)
def test_what_is_no_series_is_refused_with_what_it_is(u: Any, message: str) -> None:
    with pytest.raises(pz.PiezoidError) as raised:
        pz.Record(u, Y, ts=5e-4)
    assert message in str(raised.value)


def test_samples_of_a_record_cannot_be_changed_behind_its_back() -> None:
    mine = U.copy()
    record = pz.Record(mine, Y, ts=5e-4)
    mine[0] = 99
    assert record.u[0] == 0.0 and not record.u.flags.writeable and record.u is record.u
    with pytest.raises(ValueError, match="WRITEABLE"):
        record.u.setflags(write=True)


def test_records_travel_and_compare() -> None:
    record = pz.Record(U, Y, ts=5e-4, units=("V", "nm"))
    again = pickle.loads(pickle.dumps(record))
    assert again == record and hash(again) == hash(record) and again.units == ("V", "nm")
    assert hash(pz.Record(-U, Y, ts=5e-4)) == hash(pz.Record(0.0 - U, Y, ts=5e-4)), "-0.0 is 0.0"
    assert record != pz.Record(U, Y, ts=5e-4)
    assert record.output_in("um").y[1] == 0.02 and len(record.part(5e-4, 1.5e-3)) == 2
    assert "4 samples" in repr(record) and "nm" in record._repr_html_()


def test_frames_give_records_and_records_frames() -> None:
    record = pz.read(pd.DataFrame({"t_s": T, "u_V": U, "y_nm": Y, "remark": list("abcd")}))
    assert (record.ts, record.units) == (5e-4, ("V", "nm"))
    assert pz.read(record.to_frame()) == record


@pytest.mark.parametrize("index", [pd.to_timedelta(T, unit="s"), pd.Timestamp("2026-01-01 12:00") + pd.to_timedelta(T, unit="s")])
def test_frames_of_instants_know_their_times(index: pd.Index) -> None:
    assert pz.read(pd.DataFrame({"u_V": U, "y_um": Y}, index=index)) == pz.Record(U, Y, ts=5e-4)


def test_a_file_says_the_same_as_the_command_lines(tmp_path: Path) -> None:
    record = pz.Record(U, Y, ts=5e-4)
    record.save(tmp_path / "r.csv")
    assert pz.read(tmp_path / "r.csv") == record
    assert (tmp_path / "r.csv").read_text().splitlines()[0] == "t_s,u_V,y_um"


def test_archives_of_numpy_and_matlab_give_records(tmp_path: Path) -> None:
    from scipy.io import loadmat, savemat

    record = pz.Record(U, Y, ts=5e-4)
    np.savez(tmp_path / "r.npz", t_s=T, u_V=U, y_um=Y, remark=np.array("hello"))
    savemat(tmp_path / "r.mat", {"t_s": T, "u_V": U, "y_um": Y, "n": 4, "name": "bender"})
    savemat(tmp_path / "structure.mat", {"log": {"t_s": T, "u_V": U, "y_um": Y}})
    for name in ["r.npz", "r.mat", "structure.mat"]:
        assert pz.read(tmp_path / name) == record, name
    assert pz.read(loadmat(tmp_path / "r.mat")) == record
    assert pz.read(loadmat(tmp_path / "structure.mat")) == record
    assert pz.read(loadmat(tmp_path / "structure.mat", struct_as_record=False, squeeze_me=True)) == record
    savemat(tmp_path / "two.mat", {"one": {"t_s": T, "u_V": U, "y_um": Y}, "other": {"t_s": T, "u_V": Y, "y_um": U}})
    with pytest.raises(pz.PiezoidError, match="one/u_V.*other/u_V"):
        pz.read(tmp_path / "two.mat")


def test_matlabs_newest_files_give_records(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "r.mat", "w", userblock_size=512) as file:
        for name, values in {"t_s": T, "u_V": U, "y_um": Y}.items():
            file.create_dataset(f"log/{name}", data=values[None, :])
    whole = (tmp_path / "r.mat").read_bytes()
    (tmp_path / "r.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + whole[512:])
    assert pz.read(tmp_path / "r.mat") == pz.Record(U, Y, ts=5e-4)


def test_a_file_of_matlab_itself_is_read() -> None:
    from importlib.resources import files

    from piezoid._piezoid import Columns

    folder = files("scipy.io.matlab") / "tests" / "data"
    if not folder.is_dir():
        pytest.skip("this scipy comes without MATLAB's files")
    expected = np.arange(9) * np.pi / 4
    for name in ["testhdf5_7.4_GLNX86.mat", "testdouble_4.2c_SOL2.mat", "testdouble_6.1_SOL2.mat", "testdouble_7.4_GLNX86.mat"]:
        columns = Columns.from_file(str(folder / name))
        _, samples = columns.reference({"ts": 1.0, "output_col": "testdouble", "output_unit": "um"}, "um")
        assert np.allclose(samples, expected, rtol=1e-15), name


@pytest.mark.parametrize("kind", ["<f8", ">f4", "<f2", ">i2", "<u4", "i1", "?"])
@pytest.mark.parametrize("how", ["npz", "packed.npz", "4.mat", "5.mat", "7.mat", "h5", "packed.h5"])
def test_samples_of_every_type_come_out_of_every_file_as_numpy_has_them(tmp_path: Path, kind: str, how: str) -> None:
    import h5py
    from scipy.io import savemat

    rng = np.random.default_rng(1)
    n, path = 1000, tmp_path / f"r.{how}"
    u = rng.normal(scale=50, size=n).round(3).astype(kind)
    arrays = {"t_s": np.arange(n) * 5e-4, "u_V": u, "y_um": rng.normal(size=(n, 1)), "gain": np.float64(2.0)}
    if how.endswith("mat"):
        if how == "4.mat" or u.dtype == np.float16:  # neither format has all types
            arrays["u_V"] = u = u.astype(np.float32)
        savemat(path, {"log": arrays} if how != "4.mat" else arrays, format=how[0] if how == "4.mat" else "5", do_compression=how == "7.mat")
    elif how.endswith("npz"):
        (np.savez_compressed if "packed" in how else np.savez)(path, **arrays)
    else:
        with h5py.File(path, "w") as file:
            for name, values in arrays.items():
                packing = {"chunks": (300,) * values.ndim, "maxshape": (None,) * values.ndim, "compression": 9, "shuffle": True, "fletcher32": True}
                file.create_dataset(f"run/log/{name}", data=values, **(packing if "packed" in how and values.shape == (n,) else {}))
    record = pz.read(path)
    assert record.ts == 5e-4 and np.array_equal(record.u, u.astype(float)) and np.array_equal(record.y, arrays["y_um"].ravel())


def test_what_a_file_leaves_out_is_told(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", t_s=T, u_V=U, y_um=Y[:3], map=np.eye(2))
    with pytest.raises(pz.PiezoidError, match=r"r.npz: .*left out: map \(of shape 2 x 2\), y_um \(of 3 samples, not 4\); give output_col="):
        pz.read(tmp_path / "r.npz")
    np.save(tmp_path / "plain.npy", U)
    with pytest.raises(pz.PiezoidError, match="without column names"):
        pz.read(tmp_path / "plain.npy")
    np.savez(tmp_path / "uneven.npz", t_s=[0, 1, 2, 9], u_V=U, y_um=Y)
    with pytest.raises(pz.PiezoidError, match="row 3, t_s: the step"):
        pz.read(tmp_path / "uneven.npz")


def test_a_file_is_what_it_holds_whatever_it_is_called(tmp_path: Path) -> None:
    record = pz.Record(U, Y, ts=5e-4)
    with open(tmp_path / "r.dat", "wb") as file:
        np.savez(file, t_s=T, u_V=U, y_um=Y)
    record.save(tmp_path / "r.csv")
    (tmp_path / "r.csv").rename(tmp_path / "r.mat")
    assert pz.read(tmp_path / "r.dat") == pz.read(tmp_path / "r.mat") == record


@pytest.mark.parametrize(
    ("columns", "how", "message"),
    [
        ({"u_V": U, "y_um": Y}, {}, "there is no time column"),
        ({"u_V": U, "y_um": Y}, {"input_col": "u"}, "`u_V`"),
        ({"t_s": [0, 1, 2, 9], "u_V": U, "y_um": Y}, {}, "row 3, t_s"),
        ({"t_s": T, "u_V": U, "y_um": [1, 2, float("inf"), 4]}, {}, "row 2, y_um: the sample is inf"),
        ({}, {}, "there is no column of numbers"),
        ({"t_s": T, "u_V": U, "y_um": Y[:3]}, {}, "left out: y_um (of 3 samples, not 4)"),
        ({"t_s": T, "u_V": U, "y_um": ["0", "x", "2", "3"]}, {}, "left out: y_um (of shape (4,), <U1)"),
        ({"t_s": T, "u_V": U, "y_um": np.ma.masked_array(Y, Y > 30)}, {}, "y_um is a masked array"),
    ],
)
def test_tables_that_say_too_little_are_refused_by_row_and_keyword(
    columns: dict[str, Any], how: dict[str, Any], message: str
) -> None:
    with pytest.raises(pz.PiezoidError) as raised:
        pz.read(columns, **how)
    assert message in str(raised.value) and "--" not in str(raised.value)


def test_units_may_be_said_and_greek_letters_are_read() -> None:
    columns = {"drive": U, "probe": Y}
    record = pz.read(columns, ts=5e-4, input_col="drive", output_col="probe", units=("V", "µm"))
    assert record == pz.Record(U, Y, ts=5e-4) and record.output_in("µm") == record
    for wrong in ["um", ("V",), ("V", 1)]:
        with pytest.raises(pz.PiezoidError, match="units = "):
            pz.Record(U, Y, ts=5e-4, units=wrong)  # type: ignore[arg-type]


def test_named_fields_objects_and_instants_are_columns(tmp_path: Path) -> None:
    record = pz.Record(U, Y, ts=5e-4)
    fields = np.zeros(4, dtype=[("t_s", float), ("u_V", float), ("y_um", float)])
    fields["t_s"], fields["u_V"], fields["y_um"] = T, U, Y
    np.save(tmp_path / "r.npy", fields)
    assert pz.read(fields) == pz.read(tmp_path / "r.npy") == record
    instants = np.datetime64("2026-01-01") + (T * 1e6).astype("timedelta64[us]")
    assert pz.read({"t_s": instants, "u_V": U.astype(object), "y_um": Y}) == record


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    (tmp_path / "broken.mat").write_bytes(b"nothing of the kind")
    (tmp_path / "broken.csv").write_text("t_s,u_V,y_um\n0,1,2\n1,x,3\n")
    (tmp_path / "broken.npz").write_text("nothing of the kind")
    for name, message in [("broken.npz", "damaged"), ("none.csv", "no such file"), ("none.npz", "no such file"), ("broken.mat", "cannot be read"),
                       ("broken.csv", "line 3")]:  # fmt: skip
        with pytest.raises(pz.PiezoidError) as raised:
            pz.read(tmp_path / name)
        assert name in str(raised.value) and message in str(raised.value)
    with pytest.raises(pz.PiezoidError, match="an object of type int cannot be read as a record"):
        pz.read(3)  # type: ignore[arg-type]


def test_references_come_in_the_unit_of_the_model_and_at_its_pace() -> None:
    document = {"piezoid": 1, "ts": 5e-4, "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [1.0]}}
    model = pz.Model.from_dict(document)
    r = pz.read_reference({"t_s": T, "r_mm": [0.0, 1.0, 2.0, 3.0]}, model)
    assert r.tolist() == [0.0, 1000.0, 2000.0, 3000.0]
    with pytest.raises(pz.PiezoidError, match="every 0.0005 s but the reference every 0.001 s"):
        pz.read_reference({"t_s": 2 * T, "r_mm": [0.0, 1.0, 2.0, 3.0]}, model)
