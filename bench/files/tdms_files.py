"""TDMS by npTDMS TdmsWriter.

Layout: "TDMS File Format Internal Structure", NI. Waveform properties:
wf_increment, wf_start_offset, wf_samples, wf_start_time, unit_string.
Scaling: NI_Scale[0]_Linear_Slope and kin, as NI-DAQmx writes them.
"""
from datetime import datetime

import nptdms
import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from common import REAL, Ch, record

WHO = "npTDMS %s TdmsWriter" % nptdms.__version__
START = np.datetime64(datetime(2024, 3, 5, 14, 7, 9), "us")


def wave(unit, ts, n, **more):
    p = {"unit_string": unit, "wf_increment": ts, "wf_start_offset": 0.0,
         "wf_samples": n, "wf_start_time": START}
    p.update(more)
    return p


def write(b, name, segments, index=False):
    with TdmsWriter(b.path(name), index_file=index) as w:
        for objects in segments:
            w.write_segment(objects)


def pair(group, r, props=True, names=("Voltage", "Displacement"),
         units=("V", "um")):
    return [ChannelObject(group, c, v, wave(x, r.ts, r.n) if props else {})
            for c, v, x in zip(names, (r.u, r.y), units)]


def waveform(b):
    for name, index in (("tdms_waveform.tdms", False),
                        ("tdms_indexed.tdms", True)):
        r = record(name)
        root = RootObject({"title": "piezo run 7", "Author": "lab"})
        write(b, name, [[root, GroupObject("Log")] + pair("Log", r)], index)
        b.read(name, r, Ch("Log/Voltage", "Voltage", "V"),
               Ch("Log/Displacement", "Displacement", "um"),
               "time only as wf_increment", WHO, REAL)
    b.refuse("tdms_indexed.tdms_index", "index file: metadata, no values",
             ["the .tdms file beside it"], WHO, REAL)


def groups(b):
    name = "tdms_groups.tdms"
    r = record(name)
    temp = 23 + 0.01 * np.arange(20)
    write(b, name, [[GroupObject("Config", {"gain": 10.0}),
                     ChannelObject("Slow", "Temperature", temp,
                                   wave("degC", 0.01, 20))]
                    + pair("Piezo", r)])
    b.read(name, r, Ch("Piezo/Voltage", "Voltage", "V"),
           Ch("Piezo/Displacement", "Displacement", "um"),
           "an empty group and a slower one besides", WHO, REAL)
    name = "tdms_two_runs.tdms"
    r = record(name)
    write(b, name, [pair("Run 1", r) + pair("Run 2", record(name + "2"))])
    b.refuse(name, "two groups with the same channels", ["which group"],
             WHO, REAL, data=r, u=Ch("Run 1/Voltage", "Voltage", "V"),
             y=Ch("Run 1/Displacement", "Displacement", "um"))


def segments(b):
    name = "tdms_segments.tdms"
    r = record(name)
    parts = np.array_split(np.arange(r.n), 4)
    props = [wave("V", r.ts, r.n), wave("um", r.ts, r.n)]
    write(b, name, [[ChannelObject("Log", "Voltage", r.u[i], props[0]),
                     ChannelObject("Log", "Displacement", r.y[i], props[1])]
                    for i in parts])
    b.read(name, r, Ch("Log/Voltage", "Voltage", "V"),
           Ch("Log/Displacement", "Displacement", "um"),
           "four segments must be joined", WHO, REAL)


def scaled(b):
    name = "tdms_scaled_int16.tdms"
    r = record(name)
    made = []
    for ch, key, slope, off, unit in (
            ("Voltage", "u", 0.005, 10.0, "V"),
            ("Displacement", "y", 0.0005, 0.25, "um")):
        raw = np.round((getattr(r, key) - off) / slope).astype("i2")
        setattr(r, key, raw * slope + off)
        scale = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1,
                 "NI_Scale[0]_Scale_Type": "Linear",
                 "NI_Scale[0]_Linear_Slope": slope,
                 "NI_Scale[0]_Linear_Y_Intercept": off,
                 "NI_Scale[0]_Linear_Input_Source": np.uint32(0xFFFFFFFF)}
        made.append(ChannelObject("DAQ", ch, raw,
                                  wave(unit, r.ts, r.n, **scale)))
    write(b, name, [made])
    b.read(name, r, Ch("DAQ/Voltage", "Voltage", "V"),
           Ch("DAQ/Displacement", "Displacement", "um"),
           "int16 with a linear scale in the file; the values here are "
           "scaled by it", WHO, REAL, also_ok="refuse: scaling unsupported")


def time_channels(b):
    name = "tdms_time_channel.tdms"
    r = record(name)
    r.u, r.y = r.u.astype("f4"), r.y.astype("f4")
    write(b, name, [[ChannelObject("Data", c, v, {"unit_string": x})
                     for c, v, x in (("Time", r.t, "s"), ("u", r.u, "V"),
                                     ("y", r.y, "um"))]])
    b.read(name, r, Ch("Data/u", "u", "V"), Ch("Data/y", "y", "um"),
           "time is a channel; single precision", WHO, REAL)
    name = "tdms_timestamps.tdms"
    r = record(name)
    when = START + np.round(r.t * 1e6).astype("m8[us]")
    write(b, name, [[ChannelObject("Data", "Timestamp", when)]
                    + pair("Data", r, props=False)])
    b.read(name, r, Ch("Data/Voltage", "Voltage"),
           Ch("Data/Displacement", "Displacement"),
           "time stamps of 128 bits; no units", WHO, REAL)


def unclear(b):
    cases = (("tdms_untitled.tdms", ("Untitled", "Untitled 1"), ("", ""),
              "names of LabVIEW for unnamed signals"),
             ("tdms_daqmx_names.tdms", ("Dev1/ai0", "Dev1/ai1"),
              ("Volts", "Volts"), "names of the device, both in volts"))
    for name, names, units, why in cases:
        r = record(name)
        write(b, name, [pair("Log", r, True, names, units)])
        b.refuse(name, why, ["which channel is the input and which the "
                 "displacement", "units and scales"], WHO, REAL, data=r,
                 u=Ch("Log/" + names[0], names[0], units[0]),
                 y=Ch("Log/" + names[1], names[1], units[1]))
    name = "tdms_no_time.tdms"
    r = record(name)
    write(b, name, [pair("Log", r, props=False)])
    b.refuse(name, "no wf_increment and no time channel",
             ["sampling period"], WHO, REAL, data=r, ts=None,
             u=Ch("Log/Voltage", "Voltage"),
             y=Ch("Log/Displacement", "Displacement"))


def make(b):
    for f in (waveform, groups, segments, scaled, time_channels, unclear):
        f(b)
