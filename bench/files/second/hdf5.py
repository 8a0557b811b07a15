"""HDF5."""

from common import *


def hdf5():
    import h5py
    from scipy.io import netcdf_file

    # HDF5
    r = rec(1e-4, 10, 0, 9)
    with h5py.File(path("117_daq.h5"), "w") as f:
        f.attrs["created"] = "2023-05-05T12:00:00"
        g = f.create_group("acquisition/run_001")
        g.attrs["sample_rate"] = 10000.0
        g.attrs["sample_rate_unit"] = "Hz"
        for n, v, l, un in (
            ("AI0", r.y, "displacement", "um"),
            ("AI1", r.u, "piezo voltage", "V"),
            ("AI2", 22 + 0 * r.u, "temperature", "degC"),
        ):
            d = g.create_dataset(n, data=v, compression="gzip")
            d.attrs["label"] = l
            d.attrs["units"] = un
    add(
        "117_daq.h5",
        "hdf5",
        None,
        E,
        1e-4,
        r.u,
        r.y,
        "HDF5: AI0..AI2, meaning in attributes label and units, rate at the group",
        chk=lambda p: (h5py.File(p)["acquisition/run_001/AI1"][:], h5py.File(p)["acquisition/run_001/AI0"][:], 1e-4),
    )
    r = rec(0.002, 10, 0, 9)
    c = np.zeros(r.n, dtype=[("index", "<i8"), ("time", "<f8"), ("u_V", "<f8"), ("pos_nm", "<f8"), ("flag", "?")])
    c["index"] = np.arange(r.n)
    c["time"] = r.t
    c["u_V"] = r.u
    c["pos_nm"] = r.y * 1e3
    with h5py.File(path("118_pytables.h5"), "w") as f:
        f.attrs["CLASS"] = np.bytes_("GROUP")
        f.attrs["PYTABLES_FORMAT_VERSION"] = np.bytes_("2.1")
        d = f.create_dataset("df/table", data=c)
        d.attrs["CLASS"] = np.bytes_("TABLE")
        f["df"].attrs["pandas_type"] = np.bytes_("frame_table")
    add(
        "118_pytables.h5",
        "hdf5",
        None,
        E,
        0.002,
        r.u,
        c["pos_nm"],
        "compound table as PyTables / pandas write",
        chk=lambda p: (h5py.File(p)["df/table"][:]["u_V"], h5py.File(p)["df/table"][:]["pos_nm"], 0.002),
    )
    import netCDF4

    r = rec(0.01, 100, 0, 9)
    with netCDF4.Dataset(path("119_piezo.nc"), "w") as f:
        f.title = "piezo characterisation"
        f.Conventions = "CF-1.8"
        f.createDimension("time", r.n)
        v = f.createVariable("time", "f8", ("time",))
        v.units = "milliseconds since 2024-01-01 00:00:00"
        v.long_name = "time"
        v[:] = r.t * 1e3
        v = f.createVariable("vd", "f8", ("time",))
        v.units = "V"
        v.long_name = "drive voltage"
        v[:] = r.u
        v = f.createVariable("dx", "f8", ("time",))
        v.units = "micrometer"
        v.long_name = "displacement"
        v[:] = r.y

    def ck(p):
        f = netCDF4.Dataset(p)
        return f["vd"][:].data, f["dx"][:].data, float(np.mean(np.diff(f["time"][:].data))) * 1e-3

    add(
        "119_piezo.nc",
        "netcdf",
        None,
        E,
        0.01,
        r.u,
        r.y,
        'netCDF-4: time units "milliseconds since ...", long_name, unit micrometer',
        chk=ck,
    )
    r = rec(0.01, 100, 0, 9)
    f = netcdf_file(path("120_piezo_classic.nc"), "w")
    f.createDimension("time", r.n)
    for n, a, un in (("time", r.t, "s"), ("voltage", r.u, "V"), ("displacement", r.y, "um")):
        v = f.createVariable(n, "d", ("time",))
        v.units = un
        v[:] = a
    f.close()

    def ck(p):
        f = netCDF4.Dataset(p)
        return f["voltage"][:].data, f["displacement"][:].data, 0.01

    add(
        "120_piezo_classic.nc",
        "netcdf",
        None,
        E,
        0.01,
        r.u,
        r.y,
        "netCDF classic (CDF-1)",
        "refuse: format not supported",
        chk=ck,
    )

    # TDMS
    from nptdms import TdmsWriter, ChannelObject, GroupObject, RootObject, TdmsFile

    r = rec(0.0005, 10, 0, 45)
    t0 = np.datetime64("2023-04-01T10:00:00")
    pr = lambda un, **k: dict(
        wf_increment=0.0005,
        wf_start_offset=0.0,
        wf_samples=r.n,
        wf_start_time=t0,
        unit_string=un,
        NI_UnitDescription=un,
        **k,
    )
    with TdmsWriter(path("121_wf.tdms")) as w:
        w.write_segment(
            [
                RootObject({"name": "121", "Operator": "AK", "Amplifier gain": "15"}),
                GroupObject("Measured Data", {"Comment": "run 1: 10 V = 150 V"}),
                ChannelObject("Measured Data", "Piezo Command", r.u, pr("V")),
                ChannelObject("Measured Data", "Cap Sensor", r.y, pr("um")),
                ChannelObject("Measured Data", "Load", r.y * 2, pr("N")),
            ]
        )

    def ck(p):
        f = TdmsFile.read(p)["Measured Data"]
        return f["Piezo Command"][:], f["Cap Sensor"][:], f["Cap Sensor"].properties["wf_increment"]

    add(
        "121_wf.tdms",
        "tdms",
        None,
        E,
        0.0005,
        r.u,
        r.y,
        "TDMS waveform channels with units, text properties with numbers",
        chk=ck,
    )
    # scaled
    r = rec(0.001, 10, 0, 45)
    sc = lambda a, b: {
        "NI_Number_Of_Scales": np.uint32(1),
        "NI_Scaling_Status": "unscaled",
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": a,
        "NI_Scale[0]_Linear_Y_Intercept": b,
        "NI_Scale[0]_Linear_Input_Source": np.uint32(0xFFFFFFFF),
    }
    ru, ry = np.round(r.u / 3.2e-4).astype(np.int16), np.round((r.y + 2) / 1.6e-3).astype(np.int16)
    from nptdms import types as tt_

    def props(d):
        return {k: (tt_.Uint32(int(v)) if isinstance(v, np.uint32) else v) for k, v in d.items()}

    with TdmsWriter(path("122_scaled.tdms")) as w:
        w.write_segment(
            [
                RootObject(),
                GroupObject("Log"),
                ChannelObject(
                    "Log", "PiezoVoltage", ru, props(dict(wf_increment=0.001, unit_string="Volts", **sc(3.2e-4, 0.0)))
                ),
                ChannelObject(
                    "Log", "Displacement", ry, props(dict(wf_increment=0.001, unit_string="µm", **sc(1.6e-3, -2.0)))
                ),
            ]
        )

    def ck(p):
        f = TdmsFile.read(p)["Log"]
        return f["PiezoVoltage"][:], f["Displacement"][:], f["Displacement"].properties["wf_increment"]

    u_, y_, _ = ck(path("122_scaled.tdms"))
    assert np.allclose(u_, ru * 3.2e-4) and np.allclose(y_, ry * 1.6e-3 - 2.0)
    add("122_scaled.tdms", "tdms", None, E, 0.001, u_, y_, "TDMS raw int16 with NI linear scales (offset too)", chk=ck)
    # interleaved, hand written, with a time channel, plus a second group of settings
    r = rec(0.002, 100, 0, 12)

    def st(s):
        b = s.encode()
        return struct.pack("<I", len(b)) + b

    def obj(pth, n=None, props=()):
        b = st(pth)
        b += struct.pack("<I", 0xFFFFFFFF) if n is None else struct.pack("<IIIQ", 20, 10, 1, n)
        b += struct.pack("<I", len(props))
        for k, v in props:
            b += st(k) + (struct.pack("<I", 0x20) + st(v) if isinstance(v, str) else struct.pack("<Id", 10, v))
        return b

    objs = [
        obj("/", None, [("title", "interleaved run")]),
        obj("/'Settings'", None, [("gain", 10.0), ("sensor", "D-510.050")]),
        obj("/'Data'"),
        obj("/'Data'/'Time'", r.n, [("unit_string", "s")]),
        obj("/'Data'/'Voltage'", r.n, [("unit_string", "V")]),
        obj("/'Data'/'Position'", r.n, [("unit_string", "µm")]),
    ]
    meta = struct.pack("<I", len(objs)) + b"".join(objs)
    raw = np.column_stack([r.t, r.u, r.y]).astype("<f8").tobytes()
    add(
        "123_interleaved.tdms",
        "tdms",
        b"TDSm" + struct.pack("<IIQQ", 2 | 4 | 8 | 32, 4713, len(meta) + len(raw), len(meta)) + meta + raw,
        E,
        r.ts,
        r.u,
        r.y,
        "TDMS interleaved, explicit time channel, a settings group without channels",
        chk=lambda p: (
            TdmsFile.read(p)["Data"]["Voltage"][:],
            TdmsFile.read(p)["Data"]["Position"][:],
            float(np.mean(np.diff(TdmsFile.read(p)["Data"]["Time"][:]))),
        ),
    )
