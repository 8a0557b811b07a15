"""MAT files by scipy (v4, v5), by h5py and by hdf5storage (v7.3).

Format: "MAT-File Format", MathWorks (v4, v5). v7.3 is HDF5 behind a user
block of 512 bytes, with attributes such as MATLAB_class. Struct layouts:
Simulink "Structure With Time", dSPACE ControlDesk captures (X, Y, Capture)
as used in public MATLAB code. MATLAB objects (iddata, timeseries, table) can
not be written from Python; their fields stand in plain structs here.
"""
import io
import struct

import h5py
import numpy as np
import scipy
from scipy.io import savemat

from common import HAND, REAL, Ch, record

STAMP = b"MATLAB 5.0 MAT-file Platform: posix, Created on: Tue Mar  5 " \
        b"14:07:09 2024"
STAMP73 = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Tue Mar  5 " \
          b"14:07:09 2024 HDF5 schema 1.00 ."
SCIPY = "scipy %s savemat" % scipy.__version__
U, Y = Ch("u"), Ch("y")


def v5(b, name, content, **kw):
    """Save by scipy and put a fixed date into the text header."""
    f = io.BytesIO()
    savemat(f, content, **kw)
    data = f.getvalue()
    if kw.get("format") != "4":
        data = STAMP.ljust(116) + data[116:]
    b.raw(name, data)


def col(v):
    return np.asarray(v).reshape(-1, 1)


def cell(*items):
    c = np.empty((1, len(items)), dtype=object)
    c[0, :] = items
    return c


def structs(*dicts):
    """A 1xN struct array."""
    a = np.empty((1, len(dicts)), dtype=[(k, object) for k in dicts[0]])
    for i, d in enumerate(dicts):
        a[0, i] = tuple(d.values())
    return a


def plain(b):
    cases = (("column", dict(oned_as="column"), "column vectors"),
             ("row", dict(oned_as="row"), "row vectors"),
             ("compressed", dict(oned_as="column", do_compression=True),
              "deflated elements (the default of MATLAB save -v7)"),
             ("v4", dict(oned_as="column", format="4"), "MAT version 4"))
    for tag, kw, why in cases:
        name = "mat_%s.mat" % tag
        r = record(name)
        v5(b, name, {"t": r.t, "u": r.u, "y": r.y}, **kw)
        b.read(name, r, U, Y, why, SCIPY, REAL)


def types(b):
    name = "mat_single.mat"
    r = record(name)
    r.u, r.y = r.u.astype("f4"), r.y.astype("f4")
    v5(b, name, {"t": col(r.t), "u": col(r.u), "y": col(r.y)})
    b.read(name, r, U, Y, "single precision values, double time", SCIPY,
           REAL)
    name = "mat_int16.mat"
    r = record(name)
    r.u = np.round(r.u * 100).astype("i2")
    r.y = np.round(r.y * 1000).astype("i2")
    v5(b, name, {"u": col(r.u), "y": col(r.y), "fs": 2000.0})
    b.read(name, r, U, Y, "int16 counts without scale; rate fs, no time",
           SCIPY, REAL)
    name = "mat_v4_big_endian.mat"
    r = record(name)
    data = b""
    for k, v in (("t", r.t), ("u", r.u), ("y", r.y)):
        data += struct.pack(">5i", 1000, r.n, 1, 0, 2) + k.encode() + b"\0"
        data += v.astype(">f8").tobytes()
    b.raw(name, data)
    b.read(name, r, U, Y, "MAT version 4 in big endian order (old UNIX)",
           "after layout: MAT-File Format, version 4", HAND)


def named(b):
    name = "mat_fs_names.mat"
    r = record(name)
    v5(b, name, {"fs": 2000, "voltage": col(r.u), "position": col(r.y),
                 "note": "piezo run 7", "ok": np.array([[True]]),
                 "params": {"gain": 10.0, "cap": np.arange(3.0)},
                 "tags": cell("a", "b")})
    b.read(name, r, Ch("voltage"), Ch("position"), "no time vector but fs; "
           "text, logical, struct and cell variables besides", SCIPY, REAL)
    name = "mat_matrix_3col.mat"
    r = record(name)
    v5(b, name, {"data": np.column_stack([r.t, r.u, r.y])})
    b.refuse(name, "one matrix with three columns and no names",
             ["which column is time, voltage, displacement", "units"], SCIPY,
             REAL, data=r)


def in_structs(b):
    name = "mat_struct.mat"
    r = record(name)
    v5(b, name, {"data": {"t": col(r.t), "u": col(r.u), "y": col(r.y)}},
       do_compression=True)
    b.read(name, r, Ch("data.u", "u"), Ch("data.y", "y"),
           "the vectors are fields of a struct", SCIPY, REAL)
    name = "mat_nested.mat"
    r = record(name)
    sig = {"voltage": {"values": col(r.u), "unit": "V"},
           "displacement": {"values": col(r.y), "unit": "um"}}
    v5(b, name, {"meas": {"info": {"operator": "N.N."}, "time": col(r.t),
                          "signals": sig}})
    b.read(name, r, Ch("meas.signals.voltage.values", "voltage", "V"),
           Ch("meas.signals.displacement.values", "displacement", "um"),
           "struct in struct; the unit is a field", SCIPY, REAL)
    name = "mat_three_runs.mat"
    r = record(name)
    runs = [{"t": col(r.t), "u": col(k * r.u), "y": col(k * r.y)}
            for k in (1.0, 0.5, 0.25)]
    v5(b, name, {"run": structs(*runs)})
    b.refuse(name, "struct array with three runs", ["which run"], SCIPY,
             REAL, data=r, u=Ch("run(1).u", "u"), y=Ch("run(1).y", "y"))


def toolboxes(b):
    name = "mat_iddata_struct.mat"
    r = record(name, 0.001)
    v5(b, name, {"z": {"Domain": "Time", "Name": "run7",
                       "OutputData": col(r.y), "OutputName": cell("travel"),
                       "OutputUnit": cell("um"), "InputData": col(r.u),
                       "InputName": cell("voltage"), "InputUnit": cell("V"),
                       "Ts": 0.001, "Tstart": 0.0, "TimeUnit": "seconds"}})
    b.read(name, r, Ch("z.InputData", "voltage", "V"),
           Ch("z.OutputData", "travel", "um"),
           "fields of an iddata object in a struct; Ts, no time vector",
           SCIPY, REAL)
    name = "mat_simulink_struct_time.mat"
    r = record(name)
    sig = structs(*[{"values": col(v), "dimensions": 1.0, "label": s,
                     "title": "", "plotStyle": np.array([[0.0, 0.0]])}
                    for v, s in ((r.u, "Voltage"), (r.y, "Displacement"))])
    v5(b, name, {"ScopeData": {"time": col(r.t), "signals": sig,
                               "blockName": "piezo/Scope"}})
    b.read(name, r, Ch("ScopeData.signals(1).values", "Voltage"),
           Ch("ScopeData.signals(2).values", "Displacement"),
           "Simulink Structure With Time; names are labels", SCIPY, REAL)


def dspace(b):
    """ControlDesk capture: the variable has the name of the file."""
    name = "dspace_run7.mat"
    r = record(name, 0.001)
    slow = np.arange(0, r.n // 10) * 0.01
    x = structs(*[{"Name": "time", "Type": "Timestamp", "Data": t[None, :],
                   "Unit": "s", "Raster": s}
                  for t, s in ((r.t, "1 ms"), (slow, "10 ms"))])
    def channel(n, d, unit, i):
        return {"Name": n, "Type": "Parameter", "Data": d[None, :],
                "Unit": unit, "XIndex": float(i),
                "Path": "Model Root/Piezo", "Raster": ("1 ms", "10 ms")[i - 1]}
    y = structs(channel("temperature", 23 + 0 * slow, "degC", 2),
                channel("u_piezo", r.u, "V", 1),
                channel("x_meas", r.y, "um", 1))
    cap = {"SamplingPeriod": 0.001, "Downsampling": 1.0,
           "DateTime": "05-Mar-2024 14:07:09", "Length": float(r.n)}
    v5(b, name, {"dspace_run7": {"X": x, "Y": y, "Capture": cap,
                                 "Description": "", "RTProgram": "piezo"}})
    b.read(name, r, Ch("dspace_run7.Y(2).Data", "u_piezo", "V"),
           Ch("dspace_run7.Y(3).Data", "x_meas", "um"),
           "Y struct array; XIndex tells which of two time axes", SCIPY,
           REAL)


def userblock(b, name):
    """Put the MATLAB text header into the free 512 bytes in front."""
    path = b.path(name)
    with open(path, "r+b") as f:
        f.write(STAMP73.ljust(116) + b"\0" * 8 + b"\x00\x02IM")


def h5(b, name, fill, **kw):
    with h5py.File(b.path(name), "w", userblock_size=512, **kw) as f:
        fill(f)
    userblock(b, name)


def put(g, key, v, cls="double"):
    ds = g.create_dataset(key, data=np.asarray(v)[None, :], chunks=True,
                          compression="gzip", shuffle=True)
    ds.attrs["MATLAB_class"] = np.bytes_(cls)


def v73(b):
    who = "h5py %s with MATLAB attributes" % h5py.__version__
    name = "mat_v73.mat"
    r = record(name)
    h5(b, name, lambda f: [put(f, k, getattr(r, k)) for k in "tuy"])
    b.read(name, r, U, Y, "HDF5 behind 512 bytes; a column vector is stored "
           "as one row", who, REAL)
    name = "mat_v73_struct.mat"
    r2 = record(name)

    def fill(f):
        g = f.create_group("data")
        g.attrs["MATLAB_class"] = np.bytes_("struct")
        for key, v in (("time", r2.t), ("voltage", r2.u),
                       ("displacement", r2.y)):
            put(g, key, v)
        s = g.create_dataset("note", data=np.frombuffer(
            "run 7".encode("utf-16-le"), "<u2")[:, None])
        s.attrs["MATLAB_class"] = np.bytes_("char")
        s.attrs["MATLAB_int_decode"] = np.int32(2)
    h5(b, name, fill)
    b.read(name, r2, Ch("data.voltage", "voltage"),
           Ch("data.displacement", "displacement"),
           "struct is a group; a char field besides", who, REAL)


def v73_storage(b):
    """By hdf5storage, if it is there and works with this numpy."""
    name = "mat_v73_hdf5storage.mat"
    r = record(name)
    try:
        import hdf5storage
        hdf5storage.savemat(b.path(name), {"t": r.t, "u": r.u, "y": r.y},
                            format="7.3", oned_as="column",
                            truncate_existing=True)
    except Exception as e:  # an old package against a new numpy
        print("left out: %s (%r)" % (name, e))
        return
    userblock(b, name)
    b.read(name, r, U, Y, "written by another library for v7.3",
           "hdf5storage %s savemat" % hdf5storage.__version__, REAL)


def make(b):
    for f in (plain, types, named, in_structs, toolboxes, dspace, v73,
              v73_storage):
        f(b)
