"""HDF5, NetCDF."""

import os

import h5py

from common import *


@case(
    "nexus_links.nxs",
    "HDF5",
    "NeXus: NXdata with soft links to detector groups (every array is reachable twice), setpoint beside, gzip and shuffle.",
    check=lambda p: (lambda f: (f["entry/data/time"][:], f["entry/data/voltage"][:], f["entry/data/displacement"][:]))(
        h5py.File(p)
    ),
)
def _(p):
    r = Rec("nx", 1e-3)
    with h5py.File(p, "w") as f:
        e = f.create_group("entry")
        e.attrs["NX_class"] = "NXentry"
        i = e.create_group("instrument")
        i.attrs["NX_class"] = "NXinstrument"
        for g, n, v, un in (
            ("clock", "time", r.t + 7, "s"),
            ("interferometer", "displacement", r.y, "um"),
            ("amplifier", "voltage", r.u, "V"),
        ):
            q = i.create_group(g)
            q.attrs["NX_class"] = "NXdetector"
            d = q.create_dataset(n, data=v, **C)
            d.attrs["units"] = un
            d.attrs["target"] = f"/entry/instrument/{g}/{n}"
        d = e.create_group("data")
        d.attrs.update({"NX_class": "NXdata", "signal": "displacement", "axes": "time"})
        for g, n in (("clock", "time"), ("interferometer", "displacement"), ("amplifier", "voltage")):
            d[n] = h5py.SoftLink(f"/entry/instrument/{g}/{n}")
        f.attrs["default"] = "entry"
    return ok(1e-3, r.u, r.y)


@case(
    "h5_big_endian_rates.h5",
    "HDF5",
    "Two groups with different sampling; the fast one holds big-endian voltage and displacement with an attribute sampling_rate_Hz and no time array.",
    check=lambda p: (
        lambda f: (
            np.arange(f["fast/voltage"].size) / f["fast"].attrs["sampling_rate_Hz"],
            f["fast/voltage"][:],
            f["fast/displacement"][:],
        )
    )(h5py.File(p)),
)
def _(p):
    r = Rec("h5b", 2e-4)
    y = r.y.astype(">f4")
    with h5py.File(p, "w") as f:
        g = f.create_group("fast")
        g.attrs["sampling_rate_Hz"] = 5000.0
        g.create_dataset("displacement", data=y, **C).attrs["unit"] = "um"
        g.create_dataset("voltage", data=r.u.astype(">f8"), **C).attrs["unit"] = "V"
        s = f.create_group("slow")
        s.attrs["sampling_rate_Hz"] = 10.0
        s.create_dataset("temperature", data=22 + np.arange(12) * 0.01)
    return ok(2e-4, r.u, y)


@case(
    "pytables_table.h5",
    "HDF5",
    "PyTables table with fields in alphabetical order, int64 sample time in microseconds (t_us).",
    check=lambda p: (lambda d: (d["t_us"] * 1e-6, d["voltage_V"], d["displacement_um"]))(
        pd.DataFrame(h5py.File(p)["run/record"][:])
    ),
)
def _(p):
    import tables as tb

    r = Rec("pt", 1e-3)
    a = np.zeros(r.n, [("amb_degC", "f4"), ("displacement_um", "f8"), ("t_us", "i8"), ("voltage_V", "f4")])
    a["displacement_um"], a["t_us"], a["voltage_V"], a["amb_degC"] = r.y, 1000 * r.k + 5_000_000, r.u, 22
    with tb.open_file(p, "w") as f:
        f.create_table(
            "/run", "record", obj=a, createparents=True, track_times=False, filters=tb.Filters(4, "zlib", shuffle=True)
        )
    return ok(1e-3, a["voltage_V"], a["displacement_um"])


@case(
    "xarray_scaled.nc",
    "NetCDF4",
    "xarray: int16 with scale_factor and add_offset for both channels, int64 time in 'microseconds since'.",
    tol=1e-9,
    check=lambda p: _xr(p),
)
def _(p):
    import netCDF4

    r = Rec("xr", 1e-4)
    ru = np.round((r.u - 50) / 0.002).astype("i2")
    ry = np.round((r.y - 6) / 0.0005).astype("i2")
    with netCDF4.Dataset(p, "w") as d:
        d.createDimension("time", r.n)
        t = d.createVariable("time", "i8", ("time",))
        t.units = "microseconds since 2024-05-02 10:11:12"
        t.calendar = "proleptic_gregorian"
        t[:] = 100 * r.k
        for n, raw, sf, ao, un in (("voltage", ru, 0.002, 50.0, "V"), ("displacement", ry, 0.0005, 6.0, "um")):
            v = d.createVariable(n, "i2", ("time",), zlib=True, shuffle=True, fill_value=np.int16(-32768))
            v.scale_factor, v.add_offset, v.units = sf, ao, un
            v.set_auto_maskandscale(False)
            v[:] = raw
    return ok(1e-4, ru * 0.002 + 50.0, ry * 0.0005 + 6.0)


def _xr(p):
    import xarray

    with xarray.open_dataset(p) as d:
        return (
            (d.time.values - d.time.values[0]) / np.timedelta64(1, "s"),
            d.voltage.values.astype(float),
            d.displacement.values.astype(float),
        )


@refuse(
    "netcdf_fill_gap.nc", "NetCDF4", "_FillValue (1e20) in eight samples of the displacement: a gap in the used column."
)
def _(p):
    import netCDF4

    r = Rec("ncg", 1e-3)
    y = r.y.copy()
    y[80:88] = 1e20
    with netCDF4.Dataset(p, "w") as d:
        d.createDimension("time", r.n)
        for n, v, un in (("time", r.t, "s"), ("voltage", r.u, "V"), ("displacement", y, "um")):
            q = d.createVariable(n, "f8", ("time",), fill_value=1e20 if n != "time" else None)
            q.units = un
            q[:] = v


@refuse("h5_truncated.h5", "HDF5", "HDF5 file cut at 70 % of its length (copy aborted).")
def _(p):
    r = Rec("h5t", 1e-3, n=400)
    with h5py.File(p, "w") as f:
        for n, v in (("time_s", r.t), ("voltage_V", r.u), ("displacement_um", r.y)):
            f[n] = v
    os.truncate(p, int(os.path.getsize(p) * 0.7))


@case(
    "pandas_fixed.h5",
    "HDF5",
    "pandas to_hdf in fixed layout: values in block0_values, names in block0_items (displacement, voltage), time as axis1.",
    also_ok="refuse: pandas block layout",
    check=lambda p: (lambda d: (d.index.to_numpy(), d["voltage_V"].to_numpy(), d["displacement_um"].to_numpy()))(
        pd.read_hdf(p)
    ),
)
def _(p):
    import functools

    import tables as tb

    keep = tb.File.create_array
    tb.File.create_array = functools.partialmethod(keep, track_times=False)  # no time stamps in the file
    r = Rec("pdf", 2e-3)
    pd.DataFrame({"displacement_um": r.y, "voltage_V": r.u}, index=pd.Index(r.t, name="time_s")).to_hdf(
        p, key="df", mode="w"
    )
    tb.File.create_array = keep
    return ok(2e-3, r.u, r.y)


@refuse(
    "zurich_demod.h5",
    "Zurich Instruments",
    "LabOne demodulator record: x and y are quadratures, auxin0 and auxin1 have no meaning stated, so no role is known.",
)
def _(p):
    r = Rec("zi", 1e-3)
    with h5py.File(p, "w") as f:
        g = f.create_group("000/dev3123/demods/0/sample")
        ts = (r.k * 210000 + 10**12).astype("u8")
        g["timestamp"] = ts
        for n, v in (
            ("x", r.u * 1e-3),
            ("y", r.y * 1e-3),
            ("frequency", 1e4 + 0 * r.t),
            ("phase", 0 * r.t),
            ("auxin0", r.y),
            ("auxin1", r.u / 15),
        ):
            g[n] = v
        g["dio"] = np.zeros(r.n, "u4")
        g["trigger"] = np.zeros(r.n, "u4")
        f["000/dev3123"].attrs["clockbase"] = 210e6
