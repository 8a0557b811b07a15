"""npy and npz by numpy (format: numpy.lib.format, NEP 1)."""
import io

import numpy as np

from common import HAND, REAL, Ch, record

WHO = "numpy %s " % np.__version__
U, Y = Ch("u"), Ch("y")
ORDER = ["which column is time, voltage, displacement", "units"]


def npy(b, name, a, **kw):
    f = io.BytesIO()
    np.save(f, a, **kw)
    b.raw(name, f.getvalue())


def npz(b, name, save=np.savez, **arrays):
    f = io.BytesIO()
    save(f, **arrays)
    b.raw(name, f.getvalue())


def bare_arrays(b):
    cases = (("npy_2d.npy", np.asarray, "shape (n, 3), no names"),
             ("npy_fortran.npy", np.asfortranarray,
              "Fortran order, no names"),
             ("npy_3rows.npy", np.transpose, "shape (3, n), no names"))
    for name, turn, why in cases:
        r = record(name)
        npy(b, name, turn(np.column_stack([r.t, r.u, r.y])))
        b.refuse(name, why, ORDER, WHO + "save", REAL, data=r)


def structured(b):
    cases = (("npy_structured.npy", "<f8", ("time", "voltage",
              "displacement"), "field names; no units"),
             ("npy_structured_big_endian.npy", ">f4", ("time_s", "voltage_V",
              "displacement_um"), "big endian single precision"),
             ("npy_structured_latin1.npy", "<f8", ("Zeit_s", "Spannung_V",
              "Weg_\u00b5m"), "version 1 header in Latin-1: byte B5"),
             ("npy_structured_utf8.npy", "<f8", ("Zeit_s", "Spannung_V",
              "Weg_\u03bcm"), "version 3 header in UTF-8: Greek mu"))
    for name, kind, names, why in cases:
        r = record(name)
        a = np.zeros(r.n, dtype=[(n, kind) for n in names])
        for n, v in zip(names, (r.t, r.u, r.y)):
            a[n] = v
        r.u, r.y = a[names[1]], a[names[2]]
        npy(b, name, a)
        split = [n.rsplit("_", 1) + [""] for n in names]
        b.read(name, r, Ch(names[1], split[1][0], split[1][1]),
               Ch(names[2], split[2][0], split[2][1]), why, WHO + "save",
               REAL)


def named_arrays(b):
    name = "npz_tuy.npz"
    r = record(name)
    npz(b, name, t=r.t, u=r.u, y=r.y)
    b.read(name, r, U, Y, "three arrays", WHO + "savez", REAL)
    name = "npz_compressed_float32.npz"
    r = record(name)
    r.u, r.y = r.u.astype("f4"), r.y.astype("f4")
    npz(b, name, np.savez_compressed, time=r.t, voltage=r.u,
        displacement=r.y)
    b.read(name, r, Ch("voltage"), Ch("displacement"),
           "deflated members, single precision", WHO + "savez_compressed",
           REAL)
    name = "npz_fs.npz"
    r = record(name)
    npz(b, name, u=r.u, y=r.y, fs=np.float64(2000))
    b.read(name, r, U, Y, "no time; fs is an array of dimension 0",
           WHO + "savez", REAL)
    name = "npz_columns.npz"
    r = record(name)
    npz(b, name, data=np.asfortranarray(np.column_stack([r.t, r.u, r.y])),
        columns=np.array(["time", "voltage", "displacement"]),
        units=np.array(["s", "V", "um"]))
    b.read(name, r, Ch("voltage", unit="V"), Ch("displacement", unit="um"),
           "Fortran order; names and units are text arrays", WHO + "savez",
           REAL, also_ok="refuse and ask for the columns")
    name = "npz_no_time.npz"
    r = record(name)
    npz(b, name, u=r.u, y=r.y)
    b.refuse(name, "no time and no rate", ["sampling period"],
             WHO + "savez", REAL, data=r, u=U, y=Y, ts=None)
    name = "npz_length_mismatch.npz"
    r = record(name)
    npz(b, name, t=r.t, u=r.u, y=r.y[:-3])
    b.refuse(name, "y has three samples less than t and u",
             ["how the channels line up"], WHO + "savez", REAL)


def pickled(b):
    name = "npz_pickled.npz"
    r = record(name)
    box = np.empty(1, dtype=object)
    box[0] = {"t": [0.0, 1.0]}
    npz(b, name, data=box)
    b.refuse(name, "object array: a pickle, which runs code when read",
             ["plain arrays"], WHO + "savez", REAL)
    name = "npy_cut.npy"
    f = io.BytesIO()
    np.save(f, np.column_stack([r.t, r.u, r.y]))
    b.raw(name, f.getvalue()[:-500])
    b.refuse(name, "the last 500 bytes are missing", ["the whole file"],
             WHO + "save, then cut", HAND)


def make(b):
    for f in (bare_arrays, structured, named_arrays, pickled):
        f(b)
