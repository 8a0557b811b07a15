"""Controllers of piezo actuators and of laboratories."""

from common import *


def controllers():
    # attocube
    r = rec(0.0032768, 60, 0, 5.1e6, y0=8.3e8)
    t, u, y = S("%.7f", r.t), S("%.3f", r.u), ["%d" % round(v) for v in r.y]
    add(
        "65_IDS3010_axis0.csv",
        "attocube",
        text(
            ["time[s],drive voltage[V],absolute position[pm],contrast[%]"]
            + rows(",", t, u, y, ["%.1f" % v for v in r.g.normal(80, 0.5, r.n)])
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "attocube: whole picometres on a large offset, contrast channel",
        chk=pdcsv(1, 2, 0),
    )

    # Keyence
    r = rec(0.001, 100, 0, 0.01)
    add(
        "66_LK-Navigator.csv",
        "keyence",
        text(
            ["LK-Navigator2", "Sampling cycle,1ms", "No.,OUT1(mm),OUT2(mm)"]
            + rows(",", ["%d" % i for i in range(r.n)], S("%+.5f", r.y), S("%+.5f", -r.y + 0.002)),
            eol="\r\n",
        ),
        X,
        0.001,
        [],
        [],
        "Keyence: two laser heads, no voltage",
    )

    # Lion / gap
    r = rec(0.002, 450, 0, -38, y0=125)
    t, u, y = S("%.4f", r.t), S("%.2f", r.u), S("%.4f", r.y)
    add(
        "67_elite_gap.txt",
        "lion",
        text(
            [
                "Lion Precision Elite Series CPL290",
                "Range 250 um, bandwidth 1 kHz",
                "",
                "Elapsed Time (sec), Actuator HV (volts), Gap (microns)",
            ]
            + rows(", ", t, u, y)
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "units spelled out (sec, volts, microns); gap falls when the actuator grows",
        chk=pdcsv(1, 2, 0, skiprows=3),
    )

    # PI GCS
    def gcs(r, names, cols, nd=None, ts=None, sep=32):
        return (
            [
                "# REM E-727.3CD",
                "# REM 2023-08-01",
                "# VERSION = 1 ",
                "# TYPE = 1 ",
                "# SEPARATOR = %d " % sep,
                "# DIM = %d " % len(names),
                "# SAMPLE_TIME = %s " % ts,
                "# NDATA = %d " % (nd or r.n),
            ]
            + ["# NAME%d = %s " % (i, s) for i, s in enumerate(names)]
            + ["# END_HEADER "]
            + [z + " " for z in rows(chr(sep), *cols)]
        )

    r = rec(0.00005, 100, -20, 98)
    u, y = S("%.6e", r.u), S("%.6e", r.y)
    add(
        "68_DRR_open_loop.dat",
        "pi-gcs",
        text(gcs(r, ["Voltage of OutputChan1", "Current Position of axis1"], [u, y], ts="0.0000500")),
        E,
        0.00005,
        V(u),
        V(y),
        "PI GCS array: names, sample time, separator as a character code; trailing blanks",
        chk=pdcsv(0, 1, sep=r"\s+", comment="#", header=None),
    )
    r = rec(0.0002, 100, 0, 100)
    u, y, tp = S("%.6f", r.u), S("%.6f", r.y), S("%.6f", r.y + r.g.normal(0, 0.02, r.n))
    add(
        "69_DRR_closed_loop.dat",
        "pi-gcs",
        text(
            gcs(
                r,
                [
                    "Target Position of axisA",
                    "Current Position of axisA",
                    "Position Error of axisA",
                    "Voltage of OutputChan1",
                ],
                [tp, y, S("%.6f", r.g.normal(0, 0.02, r.n)), u],
                ts="0.0002",
                sep=9,
            )
        ),
        E,
        0.0002,
        V(u),
        V(y),
        "PI GCS: target and current position, error and output voltage; separator 9 (tab)",
        chk=pdcsv(3, 1, sep=r"\s+", comment="#", header=None),
    )
    r = rec(0.0002, 100, 0, 100)
    add(
        "70_DRR_noV.dat",
        "pi-gcs",
        text(
            gcs(
                r,
                ["Target Position of axisA", "Current Position of axisA"],
                [S("%.6f", r.y), S("%.6f", r.y * 0.99)],
                ts="0.0002",
            )
        ),
        X,
        0.0002,
        [],
        [],
        "PI GCS: target and current position, no voltage",
    )
    r = rec(0.0001, 100, 0, 100, n=240)
    u, y = S("%.6f", r.u), S("%.6f", r.y)
    add(
        "71_DRR_cut.dat",
        "pi-gcs",
        text(
            gcs(r, ["Voltage of OutputChan1", "Current Position of axis1"], [u, y], ts="0.0001", nd=4096), final=False
        )[:-6],
        X,
        0.0001,
        [],
        [],
        "PI GCS: header promises 4096 values, file ends after 240 in the middle of a number",
    )

    # NV200
    r = rec(0.0005, 130, -20, 82)
    t, u, y = S("%.2f", r.t * 1e3), S("%.3f", r.u), S("%.3f", r.y)
    add(
        "72_nv200_recorder.csv",
        "piezosystem",
        text(
            ["NV200/D Net;Serial 1234567;Stroke 80 µm", "Time (ms);Measured position (µm);Piezo voltage (V)"]
            + rows(";", t, y, u),
            "cp1252",
            "\r\n",
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "NV200 recorder: a first line with three fields, position before voltage",
        chk=pdcsv(2, 1, 0, 1e-3, sep=";", skiprows=1, encoding="cp1252"),
    )

    # Kinesis
    r = rec(0.1, 75, 0, 20)
    t0 = dt.datetime(2021, 10, 4, 11, 59, 52, 300000)
    t = [
        (t0 + dt.timedelta(milliseconds=100 * i)).strftime("%I:%M:%S.%f")[:-3]
        + (" AM" if (t0 + dt.timedelta(milliseconds=100 * i)).hour < 12 else " PM")
        for i in range(r.n)
    ]
    u, y = S("%.2f", r.u), S("%.3f", r.y)
    add(
        "73_Kinesis_KPZ101.csv",
        "thorlabs",
        text(
            [
                "Thorlabs Kinesis",
                "KPZ101 29500123 / KSG101 24500456",
                "Date: 10/4/2021",
                "",
                "Time,Output Voltage (V),Position (µm)",
            ]
            + rows(",", t, u, y),
            eol="\r\n",
            bom=BOM,
        ),
        E,
        0.1,
        V(u),
        V(y),
        "12-hour clock 11:59:59 AM passing to 12:00:00 PM",
        chk=pdcsv(1, 2, skiprows=4, encoding="utf-8-sig"),
    )

    # Fortran
    r = rec(0.0004, 100, 0, 12.5)
    dd = lambda a: [(("%15.6E") % v).replace("E", "D") for v in a]
    t, u, y = dd(r.t), dd(r.u), dd(r.y)
    add(
        "74_NEWPORT.PRN",
        "fortran",
        text(["      TIME(S)         CMD(V)        DISP(UM)"] + [a + b + c for a, b, c in zip(t, u, y)], eol="\r\n"),
        E,
        (V(t)[-1] - V(t)[0]) / (r.n - 1),
        V(u),
        V(y),
        "fixed width, Fortran D exponents, upper case units",
    )

    # fixed width without gaps
    r = rec(0.001, 100, -100, 12.5)
    t, u, y = S("%10.4f", r.t), S("%10.3f", r.u), S("%10.4f", r.y)
    add(
        "75_fixed.txt",
        "fortran",
        text(["    t [s]     U [V]    s [µm]", "-" * 30] + [a + b + c for a, b, c in zip(t, u, y)]),
        E,
        r.ts,
        V(u),
        V(y),
        "fixed width with a rule of dashes under the names",
        chk=pdcsv(1, 2, 0, sep=r"\s+", skiprows=2, header=None),
    )

    # ControlDesk csv
    r = rec(0.001, 10, 0, 15)
    t, u, y = ["%.15g" % v for v in r.t], ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y]
    add(
        "76_controldesk.csv",
        "dspace",
        text(
            [
                "dspace",
                "title,Recording 4",
                "date,2023-01-17 10:22:31",
                "raster,HostService,0.001",
                "path,,Platform()://MicroLabBox/Model Root/Piezo/DAC/u_piezo{In1},Platform()://MicroLabBox/Model Root/Sensor/y_disp{Out1}",
                "name,time,u_piezo,y_disp",
                "unit,s,V,um",
                "trace_values,%s,%s,%s" % (t[0], u[0], y[0]),
            ]
            + [",%s,%s,%s" % z for z in zip(t[1:], u[1:], y[1:])],
            eol="\r\n",
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "ControlDesk-like: row labels in the first column, first data row labelled, others with an empty field",
        chk=pdcsv(2, 3, 1, skiprows=7, header=None),
    )

    # BenchLink UTF-16
    r = rec(0.5, 150, 0, 15)
    t0 = dt.datetime(2023, 11, 30, 14, 5, 58, 123000)
    t = [(t0 + dt.timedelta(milliseconds=500 * i)).strftime("%m/%d/%Y %H:%M:%S:%f")[:-3] for i in range(r.n)]
    u, y = S("%.6E", r.u), S("%.6E", r.y)
    add(
        "77_BenchLink.csv",
        "keysight",
        text(
            [
                "Name:,piezo creep",
                "Owner:,lab",
                "Comments:,",
                "Acquisition Date:,11/30/2023 2:05:58 PM",
                "Instrument:,34970A",
                "Sweep #,Time,101 <Piezo HV> (VDC),102 <LVDT> (UM),103 <Temp> (C)",
            ]
            + rows(",", ["%d" % (i + 1) for i in range(r.n)], t, u, y, S("%.6E", 22 + 0 * r.u)),
            "utf-16",
            "\r\n",
        ),
        E,
        0.5,
        V(u),
        V(y),
        "BenchLink Data Logger: UTF-16, clock with a colon before the milliseconds, unit VDC and UM",
        chk=pdcsv(2, 3, skiprows=5, encoding="utf-16"),
    )

    # minutes
    r = rec(0.6, 100, 0, 15)
    t, u, y = C(S("%.2f", r.t / 60)), C(S("%.2f", r.u)), C(S("%.4f", r.y))
    add(
        "78_Kriechen.csv",
        "csv-units",
        text(["Zeit [min];Spannung [V];Längenänderung [µm]"] + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        0.6,
        V(u, ","),
        V(y, ","),
        "time in minutes",
        chk=pdcsv(1, 2, 0, 60, sep=";", decimal=",", encoding="cp1252"),
    )

    # epoch
    r = rec(0.02, 100, 0, 15)
    t, u, y = ["%d" % (1709630000123 + 20 * i) for i in range(r.n)], S("%.3f", r.u), S("%.4f", r.y)
    add(
        "79_mqtt_dump.csv",
        "csv-time",
        text(["epoch_ms,piezo_voltage_v,disp_um"] + rows(",", t, u, y)),
        E,
        0.02,
        V(u),
        V(y),
        "epoch milliseconds (13 digits)",
        chk=pdcsv(1, 2, 0, 1e-3),
    )
    r = rec(0.001, 100, 0, 15)
    t, u, y = ["%d" % (1650021000500000000 + 1000000 * i) for i in range(r.n)], S("%.3f", r.u), S("%.4f", r.y)
    add(
        "80_ros_bag.csv",
        "csv-time",
        text(
            ["%time,field.cmd_voltage,field.stage_position_um,field.temperature"] + rows(",", t, u, y, ["24.5"] * r.n)
        ),
        E,
        0.001,
        V(u),
        V(y),
        "rostopic echo -p: first name %time, epoch in whole nanoseconds (19 digits)",
        chk=pdcsv(1, 2),
    )
