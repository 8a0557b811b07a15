"""Files to and from numpy, pandas and scipy: every number survives to the bit."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import piezoid as pz
import pytest

INFO = np.finfo(float)
HARD = [0.0, -0.0, INFO.smallest_subnormal, -3 * INFO.smallest_subnormal, INFO.tiny, INFO.max, -INFO.max, 1e308, 0.1, 1 / 3, 2**53 + 1.0,
        9007199254740993e-20, np.nextafter(1.0, 2.0), 1e-5, 123456789.0123456789]  # fmt: skip


def column(seed: int) -> Any:
    """The hard numbers, and doubles of random bits."""
    bits = np.random.default_rng(seed).integers(0, 2**64, 3000, dtype=np.uint64).view(float)
    return np.concatenate([HARD, bits[np.isfinite(bits)][:2000]])


U, Y = column(1), column(2)
PERIODS = [5e-4, 1 / 3e4, 1 / 44100, 0.1, 60.0]


def assert_same_bits(one: Any, other: Any) -> None:
    one, other = (np.ascontiguousarray(np.ravel(array), dtype="<f8") for array in (one, other))
    assert one.tobytes() == other.tobytes()


def loadmat(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    found = loadmat(path)
    assert all(array.shape == (len(U), 1) for name, array in found.items() if not name.startswith("__"))
    return {name: array.ravel() for name, array in found.items() if not name.startswith("__")}


def load(path: Path) -> dict[str, Any]:
    with np.load(path) as archive:
        return dict(archive)


def read_csv(path: Path) -> Any:
    exact: dict[str, Any] = {} if pd.__version__ >= "3.1" else {"float_precision": "round_trip"}  # later the default
    return pd.read_csv(path, **exact)


READERS: list[tuple[str, Callable[[Path], Any]]] = [
    ("csv", read_csv),
    ("csv", lambda path: np.genfromtxt(path, delimiter=",", names=True)),
    ("npz", load),
    ("npz", lambda path: pd.DataFrame(load(path))),
    ("mat", loadmat),
    ("mat", lambda path: pd.DataFrame(loadmat(path))),
]


@pytest.mark.parametrize("ts", PERIODS)
@pytest.mark.parametrize(("extension", "reader"), READERS, ids=["pandas-csv", "numpy-csv", "numpy-npz", "pandas-npz", "scipy-mat", "pandas-mat"])
def test_others_read_what_is_written(tmp_path: Path, extension: str, reader: Callable[[Path], Any], ts: float) -> None:
    record, path = pz.Record(U, Y, ts, units=("V", "nm")), tmp_path / f"r.{extension}"
    record.save(path)
    found = reader(path)
    names = found.dtype.names if isinstance(found, np.ndarray) else list(found)
    assert list(names) == ["t_s", "u_V", "y_nm"]
    assert_same_bits(found["u_V"], U)
    assert_same_bits(found["y_nm"], Y)
    # The decimal multiples of the period, as a CSV file has them.
    assert found["t_s"][1] == ts and np.allclose(found["t_s"], record.t, rtol=3e-16, atol=0.0)
    again = pz.read(path)
    assert again.ts == ts and again.units == record.units
    assert_same_bits(again.u, U)
    assert_same_bits(again.y, Y)


def savetxt(path: Path, columns: Mapping[str, Any]) -> None:
    np.savetxt(path, np.column_stack(list(columns.values())), fmt="%.17g", delimiter=",", header=",".join(columns), comments="")


def savemat(path: Path, columns: Mapping[str, Any], **how: Any) -> None:
    from scipy.io import savemat

    savemat(path, dict(columns), **how)


WRITERS: list[tuple[str, str, Callable[[Path, Mapping[str, Any]], None]]] = [
    ("pandas", "csv", lambda path, columns: pd.DataFrame(columns).to_csv(path, index=False)),
    ("pandas index", "csv", lambda path, columns: pd.DataFrame(columns).set_index("t_s").to_csv(path)),
    ("pandas decimal comma", "csv", lambda path, columns: pd.DataFrame(columns).to_csv(path, index=False, sep=";", decimal=",")),
    ("numpy text", "csv", savetxt),
    ("numpy", "npz", lambda path, columns: np.savez(path, **columns)),
    ("numpy packed", "npz", lambda path, columns: np.savez_compressed(path, **columns)),
    ("numpy big endian", "npz", lambda path, columns: np.savez(path, **{name: array.astype(">f8") for name, array in columns.items()})),
    ("numpy fields", "npy", lambda path, columns: np.save(path, pd.DataFrame(columns).to_records(index=False))),
    ("scipy", "mat", savemat),
    ("scipy packed", "mat", lambda path, columns: savemat(path, columns, do_compression=True)),
    ("scipy columns", "mat", lambda path, columns: savemat(path, columns, oned_as="column")),
    ("scipy version 4", "mat", lambda path, columns: savemat(path, columns, format="4")),
]


@pytest.mark.parametrize("ts", PERIODS)
@pytest.mark.parametrize(("extension", "writer"), [row[1:] for row in WRITERS], ids=[row[0] for row in WRITERS])
def test_what_others_write_is_read(tmp_path: Path, extension: str, writer: Callable[[Path, Mapping[str, Any]], None], ts: float) -> None:
    path = tmp_path / f"r.{extension}"
    writer(path, {"t_s": np.arange(len(U)) * ts, "u_V": U, "y_nm": Y})
    record = pz.read(path)
    assert record.ts == ts and record.units == ("V", "nm")
    assert_same_bits(record.u, U)
    assert_same_bits(record.y, Y)


@pytest.mark.parametrize("extension", ["csv", "npz", "mat"])
def test_the_same_record_gives_the_same_bytes(tmp_path: Path, extension: str) -> None:
    hashes = set()
    for name in ["one", "other"]:
        pz.Record(U, Y, ts=5e-4).save(tmp_path / f"{name}.{extension}")
        hashes.add(hashlib.sha256((tmp_path / f"{name}.{extension}").read_bytes()).digest())
    assert len(hashes) == 1


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    for name in ["r.npy", "r.h5", "r.tdms"]:
        with pytest.raises(pz.PiezoidError, match=rf"{name}: .* are read, but not written: name the file .csv or .npz or .mat"):
            pz.Record(U, Y, ts=5e-4).save(tmp_path / name)
    with pytest.raises(pz.PiezoidError, match=r"r.mat: column name = \"y_a.u.\": is no name of a variable of MATLAB"):
        pz.Record(U, Y, ts=5e-4, units=("V", "a.u.")).save(tmp_path / "r.mat")
    assert not list(tmp_path.iterdir())
