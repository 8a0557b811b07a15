"""NumPy, Parquet, MDF."""

import datetime as dt

from common import *


@case(
    "npz_dt_scalar.npz",
    "NumPy",
    "npz with dt (0-d), voltage, position and a calibration array of another length.",
    check=lambda p: (lambda z: (np.arange(z["voltage"].size) * z["dt"], z["voltage"], z["position"]))(np.load(p)),
)
def _(p):
    r = Rec("npz", 5e-5)
    y = r.y.astype("f4")
    np.savez_compressed(p, cal=np.linspace(0, 1, 11), position=y, dt=np.float64(5e-5), voltage=r.u.reshape(-1, 1)[:, 0])
    return ok(5e-5, r.u, y)


@case(
    "npy_structured.npy",
    "NumPy",
    "Structured npy with aligned padding, big-endian field and the displacement before the voltage; time in ms by name.",
    check=lambda p: (lambda a: (a["time_ms"] * 1e-3, a["voltage_V"], a["displacement_um"]))(np.load(p)),
)
def _(p):
    r = Rec("npy", 1e-3)
    a = np.zeros(
        r.n,
        np.dtype(
            {
                "names": ["flag", "displacement_um", "voltage_V", "time_ms"],
                "formats": ["u1", ">f8", "<f4", "<f8"],
                "offsets": [0, 8, 16, 24],
                "itemsize": 32,
            }
        ),
    )
    a["displacement_um"], a["voltage_V"], a["time_ms"] = r.y, r.u, np.round(r.t * 1e3, 6)
    np.save(p, a)
    return ok(1e-3, a["voltage_V"], a["displacement_um"])


@case(
    "npz_fortran_columns.npz",
    "NumPy",
    "npz with a Fortran-ordered N x 3 array and a string array of column names in the order voltage, time, displacement.",
    also_ok="refuse: column names stand in a separate array",
    check=lambda p: (lambda z: (z["data"][:, 1], z["data"][:, 0], z["data"][:, 2]))(np.load(p)),
)
def _(p):
    r = Rec("npf", 1e-3)
    np.savez(
        p,
        data=np.asfortranarray(np.column_stack([r.u, r.t, r.y])),
        columns=np.array(["voltage_V", "time_s", "displacement_um"]),
    )
    return ok(1e-3, r.u, r.y)


@refuse(
    "npz_train_test.npz", "NumPy", "u_train, y_train, u_test, y_test: two records, neither is named as the one meant."
)
def _(p):
    a, b = Rec("tr", 1e-3, n=250), Rec("te", 1e-3, 70, n=250)
    np.savez(p, dt=1e-3, u_train=a.u, y_train=a.y, u_test=b.u, y_test=b.y)


@case(
    "arrow_timestamp.parquet",
    "Parquet",
    "Parquet with a timestamp[us, UTC] column, float32 voltage, dictionary-coded state column, several row groups.",
    tstol=1e-5,
    check=lambda p: (lambda d: ((d["time"] - d["time"][0]).dt.total_seconds(), d["voltage_V"], d["displacement_um"]))(
        pd.read_parquet(p)
    ),
)
def _(p):
    import pyarrow as pa
    import pyarrow.parquet as pq

    r = Rec("pq", 2e-3, n=300)
    u = r.u.astype("f4")
    t = pa.array((r.k * 2000 + 1714644672000000).astype("i8")).cast(pa.timestamp("us", "UTC"))
    pq.write_table(
        pa.table(
            {"state": pa.array(["run"] * r.n).dictionary_encode(), "displacement_um": r.y, "time": t, "voltage_V": u}
        ),
        p,
        row_group_size=64,
    )
    return ok(2e-3, u, r.y)


@case(
    "mdf4_two_groups.mf4",
    "MDF",
    "MDF4: raw int16 with linear conversions, a slower temperature group before, master channel t with an offset.",
    check=lambda p: _mdf(p),
)
def _(p):
    from asammdf import MDF, Signal
    from asammdf.blocks.conversion_utils import from_dict

    r = Rec("mdf", 1e-3, t0=2.0)
    ru = np.round((r.u + 1) / 0.004).astype("i2")
    ry = np.round(r.y / 0.0005).astype("i2")
    m = MDF(version="4.10")
    m.start_time = dt.datetime(2024, 5, 2, tzinfo=dt.timezone.utc)
    tt = np.arange(10) * 0.05 + 2
    m.append([Signal(22 + tt * 0.01, tt, name="Temperature", unit="degC")], comment="slow")
    sg = lambda n, un, raw, a, b: Signal(raw, r.t, name=n, unit=un, conversion=from_dict({"a": a, "b": b}), raw=True)
    m.append([sg("Voltage", "V", ru, 0.004, -1.0), sg("Displacement", "um", ry, 0.0005, 0.0)], comment="fast")
    m.save(p, overwrite=True)
    m.close()
    b = bytearray(open(p, "rb").read())
    i = b.find(b"##FH")
    while i >= 0:
        b[i + 40 : i + 48] = (1714644672 * 10**9).to_bytes(8, "little")
        i = b.find(b"##FH", i + 4)  # file history time
    open(p, "wb").write(b)
    return ok(1e-3, ru * 0.004 - 1.0, ry * 0.0005)


def _mdf(p):
    from asammdf import MDF

    with MDF(p) as m:
        u, y = m.get("Voltage"), m.get("Displacement")
        return u.timestamps, u.samples, y.samples
