"""HDF5 by h5py: the ways people lay out t, u and y."""
import h5py
import numpy as np

from common import REAL, Ch, record

WHO = "h5py %s" % h5py.__version__
U, Y = Ch("u"), Ch("y")


def write(b, name, fill, **kw):
    with h5py.File(b.path(name), "w", **kw) as f:
        fill(f)


def put(g, key, v, unit="", **kw):
    ds = g.create_dataset(key, data=v, **kw)
    if unit:
        ds.attrs["units"] = unit
    return ds


def three(g, r, keys=("t", "u", "y"), units=("s", "V", "um"), **kw):
    for k, v, x in zip(keys, (r.t, r.u, r.y), units):
        put(g, k, v, x, **kw)


def flat(b):
    uv, yv = Ch("u", unit="V"), Ch("y", unit="um")
    cases = (("h5_root.h5", {}, {}, "t, u, y at the root; attribute units"),
             ("h5_gzip.h5", {}, dict(chunks=(64,), compression="gzip",
              shuffle=True, fletcher32=True),
              "chunks, shuffle, deflate and checksum"),
             ("h5_lzf.h5", {}, dict(chunks=(100,), compression="lzf"),
              "LZF filter, which only h5py brings"),
             ("h5_latest.hdf5", dict(libver="latest"), dict(chunks=(50,)),
              "newest superblock and chunk index"))
    for name, fkw, dkw, why in cases:
        r = record(name)
        write(b, name, lambda f: three(f, r, **dkw), **fkw)
        more = {"also_ok": "refuse: filter unsupported"}
        b.read(name, r, uv, yv, why, WHO, REAL,
               **(more if "lzf" in name else {}))


def grouped(b):
    name = "h5_groups.h5"
    r = record(name)

    def fill(f):
        f.attrs["operator"] = "N.N."
        f.create_group("config").attrs["gain"] = 10.0
        g = f.create_group("measurement/run7")
        three(g, r, ("time", "voltage", "displacement"))
        put(g, "temperature", np.full(5, 23.4), "degC")
    write(b, name, fill)
    b.read(name, r, Ch("/measurement/run7/voltage", "voltage", "V"),
           Ch("/measurement/run7/displacement", "displacement", "um"),
           "two groups deep; a short dataset besides", WHO, REAL)
    name = "h5_two_runs.h5"
    r2 = record(name)
    again = record(name + " again")
    write(b, name, lambda f: [three(f.create_group(g), one)
                              for g, one in (("run1", r2), ("run2", again))])
    b.refuse(name, "two groups with the same datasets", ["which group"],
             WHO, REAL, data=r2, u=Ch("/run1/u", "u", "V"),
             y=Ch("/run1/y", "y", "um"))


def tables(b):
    name = "h5_compound.h5"
    r = record(name)
    kind = [("time", "f8"), ("voltage", "f4"), ("displacement", "f4")]
    a = np.zeros(r.n, kind)
    a["time"], a["voltage"], a["displacement"] = r.t, r.u, r.y
    r.u, r.y = a["voltage"], a["displacement"]
    write(b, name, lambda f: f.create_dataset("log", data=a))
    b.read(name, r, Ch("/log.voltage", "voltage"),
           Ch("/log.displacement", "displacement"),
           "one dataset of compound type", WHO, REAL)
    name = "h5_matrix_columns.h5"
    r2 = record(name)

    def fill(f):
        ds = put(f, "data", np.column_stack([r2.t, r2.y, r2.u]))
        ds.attrs["columns"] = ["time", "displacement", "voltage"]
        ds.attrs["units"] = ["s", "um", "V"]
    write(b, name, fill)
    b.read(name, r2, Ch("voltage", unit="V"), Ch("displacement", unit="um"),
           "a matrix; names and units are attributes of text arrays", WHO,
           REAL, also_ok="refuse and ask for the columns")


def rates(b):
    name = "h5_rate_attribute.h5"
    r = record(name)

    def fill(f):
        f.attrs["sampling_rate_Hz"] = 2000.0
        put(f, "voltage", r.u.astype("f4"), "V")
        put(f, "displacement", r.y.astype("f4"), "µm")
    write(b, name, fill)
    r.u, r.y = r.u.astype("f4"), r.y.astype("f4")
    b.read(name, r, Ch("voltage", unit="V"), Ch("displacement", unit="µm"),
           "no time; the rate is an attribute of the file", WHO, REAL)
    name = "h5_dimension_scale.h5"
    r2 = record(name)

    def scale(f):
        x = put(f, "time", r2.t, "s")
        x.make_scale("time")
        for k, v, unit in (("voltage", r2.u, "V"), ("position", r2.y, "um")):
            put(f, k, v, unit).dims[0].attach_scale(x)
    write(b, name, scale)
    b.read(name, r2, Ch("voltage", unit="V"), Ch("position", unit="um"),
           "dimension scale as in netCDF-4: reference attributes", WHO, REAL)
    name = "h5_no_time.h5"
    r3 = record(name)
    write(b, name, lambda f: [put(f, "u", r3.u), put(f, "y", r3.y)])
    b.refuse(name, "no time and no rate", ["sampling period"], WHO, REAL,
             data=r3, u=U, y=Y, ts=None)


def make(b):
    for f in (flat, grouped, tables, rates):
        f(b)
