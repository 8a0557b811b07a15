"""Writes formats/: one record in every format that is read, for tests/formats.rs.

numpy, scipy, h5py and npTDMS write; what they do not write, the other byte order, is written here and read back by scipy.
"""

import struct
from pathlib import Path

import h5py
import numpy as np
from nptdms import ChannelObject, TdmsWriter
from scipy.io import loadmat, savemat, wavfile
from scipy.sparse import coo_array

folder = Path(__file__).with_name("formats")
folder.mkdir(exist_ok=True)

t, u, y = np.arange(4) * 5e-4, np.array([0.0, 1.0, 1.5, -2.0]), np.array([0.0, 20.0, 33.0, -40.0])
counts, armed = np.array([-300, 0, 1, 300], dtype=np.int16), np.array([False, True, True, False])
column = (4, 1)

# NumPy: arrays of every kind, in either byte order.
instants = np.datetime64("2026-01-01") + (t * 1e6).astype("timedelta64[us]")
arrays = {
    "t_s": instants,
    "u_V": u.astype(">f4"),
    "y_um": y.astype(np.float16).reshape(column),
    "counts": counts.astype(">i2"),
    "armed": armed,
    "gain": np.array(10.0),
    "remark": np.array("bender"),
    "map": np.eye(2),
    "short": u[:3],
    "names": np.array(list("abcd")),
    "impedance": u + 1j,
}
np.savez(folder / "stored.npz", **arrays)
np.savez_compressed(folder / "deflated.npz", **arrays)
fields = np.zeros(4, dtype=np.dtype([("t_s", ">f8"), ("armed", "?"), ("u_V", "<f4"), ("y_um", "<f8"), ("corner", "<f8", (2,))], align=True))
for name, values in {"t_s": t, "armed": armed, "u_V": u, "y_um": y}.items():
    fields[name] = values
np.save(folder / "fields.npy", fields)

# MATLAB, versions 4 and 5 (7 is 5 with its variables compressed).
savemat(folder / "v4.mat", {"t_s": t, "u_V": u.astype(np.float32), "y_um": y.astype(np.int16), "counts": counts, "remark": "bender", "map": np.eye(2)}, format="4")
log = {
    "t_s": t.reshape(column),
    "drive": {"u_V": u, "counts": counts, "armed": armed, "single": u.astype(np.float32)},
    "y_um": y,
    "cells": np.array([1.0, 2.0, 3.0, 4.0], dtype=object),
    "gain": 10.0,
    "remark": "bender",
    "lines": np.array(["bender", "stack"]),
    "map": np.eye(2),
    "impedance": u + 1j,
    "sparse": coo_array(np.eye(4)),
    "nothing": np.zeros((0, 0)),
    "runs": np.array([{"u": 1.0}, {"u": 2.0}], dtype=object),
    "short": u[:3],
    "large": np.array([1, 2, 3, 2**63], dtype=np.uint64),
}
twice = np.zeros((1, 2), dtype=[("u", object)])
for compressed, name in [(False, "v5.mat"), (True, "v7.mat")]:
    savemat(folder / name, {"log": log, "twice": twice}, do_compression=compressed)
    whole = (folder / name).read_bytes()
    text = b"MATLAB 5.0 MAT-file, written by scipy"  # without the date
    (folder / name).write_bytes(text.ljust(124) + whole[124:])


def element(kind: int, data: bytes) -> bytes:
    return struct.pack(">ii", kind, len(data)) + data.ljust(-(-len(data) // 8) * 8, b"\0")


def matrix(name: str, values: np.ndarray) -> bytes:
    flags, dims = struct.pack(">ii", 6, 0), struct.pack(">ii", 1, len(values))
    named = element(1, name.encode()) if len(name) > 4 else struct.pack(">hh", len(name), 1) + name.encode().ljust(4, b"\0")
    return element(14, element(6, flags) + element(5, dims) + named + element(3, values.astype(">i2").tobytes()) if name == "y_um" else
                   element(6, flags) + element(5, dims) + named + element(9, values.astype(">f8").tobytes()))  # fmt: skip


channels = {"t_s": t, "u_V": u, "y_um": y}
big5 = b"MATLAB 5.0 MAT-file, the most significant byte first".ljust(124) + b"\x01\x00MI"
(folder / "v5_big.mat").write_bytes(big5 + b"".join(matrix(name, values) for name, values in channels.items()))
big4 = [struct.pack(">5i", 1000, len(v), 1, 0, len(n) + 1) + n.encode() + b"\0" + v.astype(">f8").tobytes() for n, v in channels.items()]
(folder / "v4_big.mat").write_bytes(b"".join(big4))
for name in ["v5_big.mat", "v4_big.mat"]:
    read = loadmat(folder / name, squeeze_me=True)
    assert all(np.array_equal(read[channel], values) for channel, values in channels.items())


# MATLAB 7.3: shapes turned round, classes in attributes, 512 bytes of text before the file itself.
def put(group: h5py.Group, name: str, values: np.ndarray, kind: str, **how: object) -> None:
    data = group.create_dataset(name, data=np.atleast_2d(values), **how)
    data.attrs["MATLAB_class"] = np.bytes_(kind)
    if kind == "logical":
        data.attrs["MATLAB_int_decode"] = np.int32(1)


with h5py.File(folder / "v73.mat", "w", userblock_size=512) as file:
    group = file.create_group("log")
    group.attrs["MATLAB_class"] = np.bytes_("struct")
    put(group, "t_s", t.reshape(column), "double")
    put(group, "u_V", u.astype(np.float32), "single", chunks=(1, 3), compression="gzip", shuffle=True, fletcher32=True)
    put(group, "y_um", y.astype(">i2").reshape(column), "int16", chunks=(2, 1))
    put(group, "armed", armed.astype(np.uint8), "logical")
    put(group, "gain", np.array(10.0), "double")
    put(group, "remark", np.frombuffer("bend".encode("utf-16-le"), np.uint16).reshape(column), "char")
    put(group, "empty", np.zeros(4, dtype=np.uint64), "double")
    group["empty"].attrs["MATLAB_empty"] = np.uint8(1)
    put(group, "map", np.eye(2), "double")
    sparse = file.create_group("sparse")
    sparse.attrs["MATLAB_sparse"] = np.uint64(4)
    sparse["data"] = u
    file.create_group("#refs#")["a"] = u
    group.create_dataset("cells", data=np.array([[file["log/u_V"].ref] * 4]), dtype=h5py.ref_dtype).attrs["MATLAB_class"] = np.bytes_("cell")
whole = (folder / "v73.mat").read_bytes()
(folder / "v73.mat").write_bytes(b"MATLAB 7.3 MAT-file, written by h5py".ljust(116) + bytes(8) + b"\x00\x02IM" + whole[128:])

# HDF5 in the form of 1.8: other heads, and links that are messages.
creation, access = h5py.h5p.create(h5py.h5p.FILE_CREATE), h5py.h5p.create(h5py.h5p.FILE_ACCESS)
creation.set_obj_track_times(False)
access.set_libver_bounds(h5py.h5f.LIBVER_V18, h5py.h5f.LIBVER_V18)
with h5py.File(h5py.h5f.create(str(folder / "links.h5").encode(), h5py.h5f.ACC_TRUNC, creation, access)) as file:
    file["t_s"], file["y_um"] = t, y
    file.create_group("drive", track_times=False)["u_V"] = u
    file["armed"], file["remark"], file["impedance"] = armed, "bender", u + 1j
    file["y_um"].attrs["unit"] = "um"

# Fields of one data set; numbers packed as NetCDF packs them, with a value for samples that are missing.
with h5py.File(h5py.h5f.create(str(folder / "fields.h5").encode(), h5py.h5f.ACC_TRUNC, creation, access)) as file:
    file.create_dataset("log", data=fields[["t_s", "u_V", "y_um"]], track_times=False)
with h5py.File(h5py.h5f.create(str(folder / "packed.h5").encode(), h5py.h5f.ACC_TRUNC, creation, access)) as file:
    file["t_s"], file["u_V"], file["y_um"], file["gaps"] = t, (2 * u + 6).astype(np.int16), (y / 2).astype(">f4"), counts
    for name, slope, intercept in [("u_V", 0.5, -3.0), ("y_um", 2.0, None), ("gaps", None, 1.0)]:
        if slope is not None:
            file[name].attrs["scale_factor"] = slope
        if intercept is not None:
            file[name].attrs["add_offset"] = intercept
    file["gaps"].attrs["_FillValue"] = np.int16(300)

# TDMS: int16 with slope and intercept, the period in a property, a group of its own for text.
with TdmsWriter(folder / "log.tdms") as file:
    scale = {
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 0.5,
        "NI_Scale[0]_Linear_Y_Intercept": -3.0,
    }
    period = {"wf_increment": 5e-4, "unit_string": "V"}
    for part in (slice(0, 3), slice(3, 4)):
        file.write_segment(
            [
                ChannelObject("log", "u_V", (2 * u[part] + 6).astype(np.int16), {**period, **scale}),
                ChannelObject("log", "y_um", y[part].astype(np.float32), {**period, "unit_string": "um"}),
            ]
        )
    file.write_segment([ChannelObject("remarks", "note", ["bend", "er"])])

# TDMS: points in time, scales one after another, and scales that are not read.
with TdmsWriter(folder / "instants.tdms") as file:

    def linear(k: int, slope: float, intercept: float, source: int) -> dict[str, object]:
        of = {"Scale_Type": "Linear", "Linear_Slope": slope, "Linear_Y_Intercept": intercept, "Linear_Input_Source": source}
        return {f"NI_Scale[{k}]_{name}": value for name, value in of.items()}

    two = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 2}
    chain = {**two, **linear(0, 2.0, 1.0, 0xFFFFFFFF), **linear(1, 0.25, -1.75, 0)}
    branch = {**two, **linear(0, 2.0, 1.0, 0xFFFFFFFF), **linear(1, 0.25, -1.75, 0xFFFFFFFF)}
    thermocouple = {**two, "NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Thermocouple"}
    whole = (2 * u + 3).astype(np.int8)
    file.write_segment(
        [
            ChannelObject("log", "t_s", instants),
            ChannelObject("log", "u_V", whole, chain),
            ChannelObject("log", "y_um", y, {"unit_string": "um"}),
            ChannelObject("log", "branch", whole, branch),
            ChannelObject("log", "heat", whole, thermocouple),
            ChannelObject("log", "wide", (2 * u + 6).astype(np.uint32), {**chain, "NI_Scaling_Status": "scaled"}),
        ]
    )

# WAV: two channels of 32-bit floats at 2 kHz, as scipy writes them.
wavfile.write(folder / "log.wav", 2000, np.stack([u, y], axis=1).astype(np.float32))
