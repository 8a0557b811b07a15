"""TDMS."""

import os

from common import *


def tdms(p, segs):
    from nptdms import ChannelObject, GroupObject, TdmsWriter

    with TdmsWriter(p) as w:
        for s in segs:
            w.write_segment([ChannelObject(*x) if len(x) == 4 else GroupObject(*x) for x in s])


def td(p, g, u, y, t=None):
    from nptdms import TdmsFile

    f = TdmsFile.read(p)
    c = f[g]
    return (c[t][:] if t else c[u].time_track()), c[u][:], c[y][:]


W = lambda dx, unit, off=0.0: {
    "wf_increment": dx,
    "wf_start_offset": off,
    "wf_samples": 1,
    "wf_start_time": np.datetime64("2024-05-02T10:11:12"),
    "unit_string": unit,
    "NI_UnitDescription": unit,
}


@case(
    "tdms_two_rates.tdms",
    "TDMS",
    "Waveform properties; the group with temperature has another rate and comes first.",
    check=lambda p: td(p, "Fast", "Piezo voltage", "Displacement"),
)
def _(p):
    r = Rec("td1", 2e-4)
    tdms(
        p,
        [
            [
                ("Slow", "Temperature", 22 + np.arange(20) * 0.01, W(0.01, "degC")),
                ("Fast", "Displacement", r.y, W(2e-4, "um", 0.5)),
                ("Fast", "Piezo voltage", r.u, W(2e-4, "V", 0.5)),
            ]
        ],
    )
    return ok(2e-4, r.u, r.y)


@case(
    "tdms_scaled_int16.tdms",
    "TDMS",
    "Raw int16 channels with NI_Scale properties: linear for the voltage, a polynomial for the displacement.",
    check=lambda p: td(p, "AI", "Voltage", "Displacement"),
)
def _(p):
    r = Rec("td2", 1e-4)
    ru = np.round(r.u / 0.004).astype("i2")
    ry = np.round(r.y / 0.0005).astype("i2")
    a = dict(
        W(1e-4, "V"),
        **{
            "NI_Scaling_Status": "unscaled",
            "NI_Number_Of_Scales": 1,
            "NI_Scale[0]_Scale_Type": "Linear",
            "NI_Scale[0]_Linear_Slope": 0.004,
            "NI_Scale[0]_Linear_Y_Intercept": 0.25,
            "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
        },
    )
    c = [0.02, 5e-4, 1.5e-10, 0.0]
    b = dict(
        W(1e-4, "um"),
        **{
            "NI_Scaling_Status": "unscaled",
            "NI_Number_Of_Scales": 1,
            "NI_Scale[0]_Scale_Type": "Polynomial",
            "NI_Scale[0]_Polynomial_Coefficients_Size": 4,
            "NI_Scale[0]_Polynomial_Input_Source": 0xFFFFFFFF,
        },
    )
    for i, v in enumerate(c):
        b[f"NI_Scale[0]_Polynomial_Coefficients[{i}]"] = v
    from nptdms import types

    for d in (a, b):
        for k in d:
            if k.endswith("Input_Source"):
                d[k] = types.Uint32(d[k])
    tdms(p, [[("AI", "Voltage", ru, a), ("AI", "Displacement", ry, b)]])
    x = ry.astype(float)
    return ok(1e-4, ru * 0.004 + 0.25, c[0] + c[1] * x + c[2] * x * x)


@case(
    "tdms_many_segments.tdms",
    "TDMS",
    "Seven appended segments, time channel with an offset, float32 displacement; wf_increment of 1 was left at its default.",
    also_ok="refuse: wf_increment contradicts the time channel",
    check=lambda p: td(p, "Log", "Voltage_V", "Displacement_um", "Time_s"),
)
def _(p):
    r = Rec("td3", 5e-3, n=350, t0=40)
    y = r.y.astype("f4")
    d = {"wf_increment": 1.0}
    tdms(
        p,
        [
            [
                ("Log", "Time_s", r.t[k : k + 50], {}),
                ("Log", "Voltage_V", r.u[k : k + 50], d),
                ("Log", "Displacement_um", y[k : k + 50], d),
            ]
            for k in range(0, 350, 50)
        ],
    )
    return ok(5e-3, r.u, y)


@refuse("tdms_two_runs.tdms", "TDMS", "Two groups Run_001 and Run_002 with complete records of different rates.")
def _(p):
    a, b = Rec("td4", 1e-4, n=200), Rec("td4b", 2e-4, 80, n=300)
    tdms(
        p,
        [
            [
                (g, c, v, W(r.ts, n))
                for g, r in (("Run_001", a), ("Run_002", b))
                for c, v, n in (("Voltage", r.u, "V"), ("Displacement", r.y, "um"))
            ]
        ],
    )


@refuse("tdms_truncated.tdms", "TDMS", "File cut in the raw data of the second channel (disk full).")
def _(p):
    r = Rec("td5", 1e-4, n=300)
    tdms(p, [[("G", "Voltage", r.u, W(1e-4, "V")), ("G", "Displacement", r.y, W(1e-4, "um"))]])
    os.truncate(p, os.path.getsize(p) - 1003)
