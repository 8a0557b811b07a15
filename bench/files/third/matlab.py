"""MATLAB, versions 4, 5 and 7.3."""

import h5py
import scipy.io as sio

from common import *

MATHEAD = b"MATLAB 5.0 MAT-file, Platform: PCWIN64, Created on: Thu May  2 10:11:12 2024"


def mat5(p, d, **k):
    sio.savemat(p, d, **k)
    if k.get("format", "5") == "5":
        with open(p, "r+b") as f:
            f.write(MATHEAD.ljust(116))


def sa(*ds):
    o = np.zeros((1, len(ds)), dtype=[(k, "O") for k in ds[0]])
    for i, d in enumerate(ds):
        for k, v in d.items():
            o[0, i][k] = v
    return o


def pm(p):
    import pymatreader

    return pymatreader.read_mat(p)


@case(
    "dspace_controldesk.mat",
    "dSPACE",
    "ControlDesk struct: X(1) time, Y(1..4) with names, units and data; temperature and reference beside.",
    check=lambda p: (lambda m: (m["X"]["Data"], m["Y"]["Data"][2], m["Y"]["Data"][1]))(pm(p)["rec_007"]),
)
def _(p):
    r = Rec("dsp", 1e-3)
    col = lambda n, u, v: {"Name": n, "Type": 4.0, "Data": v.reshape(1, -1), "Unit": u, "XIndex": 1.0, "Raster": "1"}
    mat5(
        p,
        {
            "rec_007": {
                "X": sa(col("Time", "s", r.t + 5)),
                "Y": sa(
                    col("Temperature", "degC", 22 + 0 * r.t),
                    col("Displacement", "um", r.y),
                    col("Piezo_Voltage", "V", r.u),
                    col("Gain", "-", 1 + 0 * r.t),
                ),
                "Description": {"General": {"DateTime": "02.05.2024"}},
                "RTProgram": "piezo.sdf",
                "Info": "",
                "Capture": {"Length": 1.0, "Downsampling": 1.0},
            }
        },
    )
    return ok(1e-3, r.u, r.y)


@case(
    "simulink_struct_with_time.mat",
    "Simulink",
    "'Structure with time': time and signals(1..2) with values and labels; displacement is signal 1; also scalars tout-like in the workspace.",
    check=lambda p: (lambda m: (m["time"], m["signals"]["values"][1], m["signals"]["values"][0]))(pm(p)["ScopeData"]),
)
def _(p):
    r = Rec("sim1", 1e-3)
    sg = lambda n, v: {
        "values": v.reshape(-1, 1),
        "dimensions": 1.0,
        "label": n,
        "title": "",
        "plotStyle": np.zeros((1, 1)),
    }
    mat5(
        p,
        {
            "Kp": 0.3,
            "Ki": 12.0,
            "ScopeData": {
                "time": r.t.reshape(-1, 1),
                "signals": sa(sg("displacement [um]", r.y), sg("voltage [V]", r.u)),
                "blockName": "piezo/Scope",
            },
        },
        do_compression=True,
    )
    return ok(1e-3, r.u, r.y)


@case(
    "speedgoat_timeseries_1x1xN.mat",
    "Simulink",
    "logsout-like nest of timeseries structs; Data of the displacement is 1x1xN, each element has its own equal Time.",
    check=lambda p: (lambda m: (m["u"]["Time"], m["u"]["Data"].ravel(), m["y"]["Data"].ravel()))(pm(p)["logsout"]),
)
def _(p):
    r = Rec("sim2", 5e-4)
    e = lambda n, un, v: {
        "Name": n,
        "Time": r.t.reshape(-1, 1),
        "Data": v,
        "DataInfo": {"Units": un, "Interpolation": "linear"},
        "TimeInfo": {"Units": "seconds", "Start": 0.0, "Length": float(r.n)},
    }
    mat5(
        p,
        {"logsout": {"u": e("voltage", "V", r.u.reshape(-1, 1)), "y": e("displacement", "um", r.y.reshape(1, 1, -1))}},
    )
    return ok(5e-4, r.u, r.y)


@case(
    "pico_v4.mat",
    "MATLAB v4",
    "MAT v4 in PicoScope's way: Tstart, Tinterval, Length and one float32 array per (renamed) channel.",
    check=lambda p: (
        lambda m: (np.arange(m["U_piezo"].size) * m["Tinterval"].item(), m["U_piezo"].ravel(), m["y_um"].ravel())
    )(sio.loadmat(p)),
)
def _(p):
    r = Rec("v4", 2e-5)
    u, y = r.u.astype("f4"), r.y.astype("f4")
    mat5(
        p,
        {
            "Tstart": -0.001,
            "Tinterval": 2e-5,
            "Length": float(r.n),
            "U_piezo": u.reshape(-1, 1),
            "y_um": y.reshape(-1, 1),
        },
        format="4",
    )
    return ok(2e-5, u, y)


def v73(p, fill):
    with h5py.File(p, "w", userblock_size=512) as f:
        fill(f)
    with open(p, "r+b") as f:
        f.write(
            b"MATLAB 7.3 MAT-file, Platform: PCWIN64, Created on: Thu May  2 10:11:12 2024 HDF5 schema 1.00 .".ljust(
                116
            )
            + bytes(8)
            + b"\x00\x02IM"
        )


def h5m(g, n, a, cls="double", **k):
    d = g.create_dataset(n, data=a, **k)
    d.attrs["MATLAB_class"] = np.bytes_(cls)
    if cls == "char":
        d.attrs["MATLAB_int_decode"] = np.int32(2)
    return d


@case(
    "v73_struct.mat",
    "MATLAB v7.3",
    "v7.3 struct with compressed columns voltage, displacement (float32), Fs only as a scalar, a calibration array of 10 values beside.",
    check=lambda p: (
        lambda m: (np.arange(m["voltage"].size) / m["Fs"], m["voltage"].ravel(), m["displacement"].ravel())
    )(pm(p)["data"]),
)
def _(p):
    r = Rec("v73", 1e-4)
    y = r.y.astype("f4")

    def fill(f):
        g = f.create_group("data")
        g.attrs["MATLAB_class"] = np.bytes_("struct")
        h5m(g, "voltage", r.u.reshape(1, -1), **C)
        h5m(g, "displacement", y.reshape(1, -1), "single", **C)
        h5m(g, "Fs", np.array([[1e4]]))
        h5m(f, "calib", np.arange(10.0).reshape(1, -1))
        h5m(g, "unit", np.frombuffer("um".encode("utf-16-le"), "u2").reshape(-1, 1), "char")

    v73(p, fill)
    return ok(1e-4, r.u, y)


@case(
    "v73_cell_names_matrix.mat",
    "MATLAB v7.3",
    "v7.3: N x 3 matrix (stored transposed) and a cell array of names in the order displacement, time, voltage.",
    also_ok="refuse: column names stand in a separate cell array",
    check=lambda p: (lambda m: (m["data"][:, 1], m["data"][:, 2], m["data"][:, 0]))(pm(p)),
)
def _(p):
    r = Rec("v73c", 1e-3)

    def fill(f):
        h5m(f, "data", np.vstack([r.y, r.t, r.u]))
        g = f.create_group("#refs#")
        o = np.empty((3, 1), h5py.ref_dtype)
        for i, s in enumerate(("displacement_um", "time_s", "voltage_V")):
            o[i, 0] = h5m(g, "abc"[i], np.frombuffer(s.encode("utf-16-le"), "u2").reshape(-1, 1), "char").ref
        f.create_dataset("names", data=o, dtype=h5py.ref_dtype).attrs["MATLAB_class"] = np.bytes_("cell")

    v73(p, fill)
    return ok(1e-3, r.u, r.y)


@refuse(
    "v73_rate_contradicts.mat",
    "MATLAB v7.3",
    "Fs = 10000 but the time vector in s has steps of 1 ms: the period cannot be known.",
)
def _(p):
    r = Rec("v73r", 1e-3)
    v73(
        p,
        lambda f: [
            h5m(f, n, np.reshape(a, (1, -1)))
            for n, a in (("time_s", r.t), ("voltage_V", r.u), ("displacement_um", r.y), ("Fs", 1e4))
        ],
    )


@refuse("mat5_unnamed_matrix.mat", "MATLAB v5", "One N x 3 matrix 'data' whose columns have no names.")
def _(p):
    r = Rec("m5", 1e-3)
    mat5(p, {"data": np.column_stack([r.t, r.y, r.u * 0.15])})
