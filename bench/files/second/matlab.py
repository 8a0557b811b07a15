"""MATLAB and NumPy."""

from common import *


def matlab():
    from scipy.io import savemat, loadmat
    import h5py

    # v4
    r = rec(0.001, 100, 0, 9)
    savemat(path("107_v4.mat"), {"t": r.t, "u": r.u, "y": r.y}, format="4")

    def ck(p, U="u", Y="y", T="t"):
        m = loadmat(p)
        return m[U].ravel(), m[Y].ravel(), float(np.mean(np.diff(m[T].ravel())))

    add("107_v4.mat", "mat", None, E, r.ts, r.u, r.y, "MAT v4 with t, u, y", chk=ck)
    # Structure with time
    r = rec(0.0005, 100, 0, 9)
    sig = np.zeros((1, 2), dtype=[("values", "O"), ("dimensions", "O"), ("label", "O"), ("blockName", "O")])
    for k, (v, l) in enumerate(((r.y, "displacement [um]"), (r.u, "piezo voltage [V]"))):
        sig[0, k] = (v[:, None], np.array([[1.0]]), l, "piezo_model/To Workspace")
    savemat(
        path("108_simout.mat"),
        {"simout": {"time": r.t[:, None], "signals": sig, "blockName": "piezo_model/To Workspace"}},
        do_compression=True,
    )

    def ck(p):
        s = loadmat(p)["simout"][0, 0]
        return (
            s["signals"][0, 1]["values"].ravel(),
            s["signals"][0, 0]["values"].ravel(),
            float(np.mean(np.diff(s["time"].ravel()))),
        )

    add(
        "108_simout.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "Simulink Structure With Time, labels in signals(k).label, output first",
        chk=ck,
    )
    # timeseries-like
    r = rec(0.001, 100, 0, 9)
    mk = lambda n, v, un: {
        "Name": n,
        "Time": r.t[:, None],
        "Data": v[:, None],
        "DataInfo": {"Units": un},
        "TimeInfo": {"Units": "seconds", "Start": 0.0},
    }
    savemat(
        path("109_timeseries.mat"), {"ts_cmd": mk("PiezoCommand", r.u, "V"), "ts_pos": mk("StagePosition", r.y, "um")}
    )

    def ck(p):
        m = loadmat(p)
        return (
            m["ts_cmd"][0, 0]["Data"].ravel(),
            m["ts_pos"][0, 0]["Data"].ravel(),
            float(np.mean(np.diff(m["ts_cmd"][0, 0]["Time"].ravel()))),
        )

    add(
        "109_timeseries.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "timeseries turned into structs, each with its own time, units nested",
        chk=ck,
    )
    # dataset-like
    r = rec(0.002, 100, 0, 9)
    el = np.empty((1, 3), dtype=object)
    for k, (n, v) in enumerate((("u_piezo", r.u), ("temp_stack", 25 + 0 * r.u), ("y_disp", r.y))):
        el[0, k] = {"Name": n, "BlockPath": "ctrl/" + n, "Values": {"Time": r.t[:, None], "Data": v[:, None]}}
    savemat(
        path("110_logsout.mat"),
        {"logsout": {"Name": "logsout", "numElements": 3.0, "elements": el}, "Ts": 0.002},
        do_compression=True,
    )

    def ck(p):
        e = loadmat(p)["logsout"][0, 0]["elements"]
        return e[0, 0]["Values"][0, 0]["Data"][0, 0].ravel(), e[0, 2]["Values"][0, 0]["Data"][0, 0].ravel(), 0.002

    add(
        "110_logsout.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "Dataset-like: cell of structs with Name and Values",
        chk=ck,
    )
    # dSPACE rec
    r = rec(0.001, 10, 0, 20)
    Y = np.zeros(
        (1, 2), dtype=[("Name", "O"), ("Type", "O"), ("Data", "O"), ("Unit", "O"), ("XIndex", "O"), ("Path", "O")]
    )
    Y[0, 0] = (
        '"Model Root"/"Sensor"/"Position"/"Out1"',
        4.0,
        r.y[None, :].astype(np.float64),
        "um",
        1.0,
        "Model Root/Sensor/Position",
    )
    Y[0, 1] = ('"Model Root"/"DAC"/"Piezo voltage"/"In1"', 4.0, r.u[None, :], "V", 1.0, "Model Root/DAC/Piezo voltage")
    Xs = np.zeros((1, 1), dtype=[("Name", "O"), ("Type", "O"), ("Data", "O"), ("Unit", "O")])
    Xs[0, 0] = ("time", 4.0, r.t[None, :], "s")
    savemat(
        path("111_rec1_042.mat"),
        {
            "rec1_042": {
                "X": Xs,
                "Y": Y,
                "Description": {"General": {"Version": 2.1, "DateTime": "11-Mar-2022 09:12:13"}},
                "RTProgram": "piezo_ctrl.sdf",
                "Capture": {"Length": 0.5, "SamplingPeriod": 0.001},
            }
        },
    )

    def ck(p):
        m = loadmat(p)["rec1_042"][0, 0]
        return (
            m["Y"][0, 1]["Data"].ravel(),
            m["Y"][0, 0]["Data"].ravel(),
            float(np.mean(np.diff(m["X"][0, 0]["Data"].ravel()))),
        )

    add(
        "111_rec1_042.mat",
        "dspace",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "dSPACE ControlDesk mat: X, Y(k).Name paths with quotes",
        chk=ck,
    )
    # Fs scalar
    r = rec(1 / 8000.0, 10, 0, 20)
    savemat(
        path("112_fs.mat"),
        {
            "Fs": 8000.0,
            "u": r.u[:, None],
            "y": r.y[:, None],
            "ref": np.round(r.y, 1)[:, None],
            "gain": 15.0,
            "operator": "mk",
            "units": "V, um",
        },
        do_compression=True,
    )
    add(
        "112_fs.mat",
        "mat",
        None,
        E,
        1 / 8000.0,
        r.u,
        r.y,
        "u, y and scalar Fs; reference of the same length beside",
        chk=lambda p: (loadmat(p)["u"].ravel(), loadmat(p)["y"].ravel(), 1 / float(loadmat(p)["Fs"][0, 0])),
    )
    # v7.3
    r = rec(0.0005, 100, 0, 9)
    p = path("113_v73.mat")
    with h5py.File(p, "w", userblock_size=512) as f:
        f.attrs  # root
        g = f.create_group("meas")
        g.attrs["MATLAB_class"] = np.bytes_("struct")
        for n, v in (("Time_s", r.t), ("Volt_V", r.u), ("Disp_um", r.y)):
            d = g.create_dataset(n, data=v[None, :])
            d.attrs["MATLAB_class"] = np.bytes_("double")
        d = g.create_dataset("Comment", data=np.frombuffer("stack 3".encode("utf-16-le"), np.uint16)[:, None])
        d.attrs["MATLAB_class"] = np.bytes_("char")
        d.attrs["MATLAB_int_decode"] = np.int32(2)
    with open(p, "r+b") as fh:
        h = b"MATLAB 7.3 MAT-file, Platform: PCWIN64, Created on: Wed Mar 01 10:10:10 2023 HDF5 schema 1.00 ."
        fh.write(h.ljust(116) + b"\0" * 8 + b"\x00\x02IM")
    add(
        "113_v73.mat",
        "mat",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "MAT v7.3 (HDF5 with userblock), struct, column vectors stored 1xN",
        chk=lambda p: (
            lambda f: (
                f["meas/Volt_V"][:].ravel(),
                f["meas/Disp_um"][:].ravel(),
                float(np.mean(np.diff(f["meas/Time_s"][:].ravel()))),
            )
        )(h5py.File(p, "r")),
    )
    # numpy
    r = rec(0.001, 100, 0, 9)
    a = np.zeros(r.n, dtype=[("timestamp_ns", "i8"), ("pzt_V", "f4"), ("disp_nm", "f8")])
    a["timestamp_ns"] = np.arange(r.n) * 1000000 + 1700000000000000000
    a["pzt_V"] = r.u
    a["disp_nm"] = r.y * 1000
    np.save(path("114_struct.npy"), a)
    add(
        "114_struct.npy",
        "numpy",
        None,
        E,
        0.001,
        a["pzt_V"].astype(float),
        a["disp_nm"],
        "structured npy; nanosecond epoch in int64; float32 voltage",
        chk=lambda p: (np.load(p)["pzt_V"].astype(float), np.load(p)["disp_nm"], 0.001),
    )
    r = rec(0.0004, 100, 0, 9)
    np.savez(path("115_run.npz"), dt=0.0004, voltage=r.u, displacement=r.y, meta=np.array("P-885.51"))
    add(
        "115_run.npz",
        "numpy",
        None,
        E,
        0.0004,
        r.u,
        r.y,
        "npz with dt and two named arrays",
        chk=lambda p: (np.load(p)["voltage"], np.load(p)["displacement"], float(np.load(p)["dt"])),
    )
    r = rec(1 / 25e3, 100, 0, 9)
    np.savez_compressed(
        path("116_run_fs.npz"),
        fs_Hz=np.array([25000]),
        V_drive=r.u[:, None],
        x_um=r.y[:, None],
        x_ref_um=r.y[:, None] * 1.02,
        trigger=np.zeros((r.n, 1), bool),
    )
    add(
        "116_run_fs.npz",
        "numpy",
        None,
        E,
        1 / 25e3,
        r.u,
        r.y,
        "npz, fs_Hz as array of one, column vectors, reference beside",
        chk=lambda p: (np.load(p)["V_drive"].ravel(), np.load(p)["x_um"].ravel(), 1 / 25e3),
    )
