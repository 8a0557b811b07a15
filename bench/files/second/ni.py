"""National Instruments."""

from common import *


def ni():
    hdr = [
        "LabVIEW Measurement\t",
        "Writer_Version\t2",
        "Reader_Version\t2",
        "Separator\tTab",
        "Decimal_Separator\t%s",
        "Multi_Headings\t%s",
        "X_Columns\t%s",
        "Time_Pref\tRelative",
        "Operator\tlabor",
        "Description\tSweep 3, 1.5 Hz, 100 V",
        "Date\t2023/02/17",
        "Time\t14:22:05%s2345678901234567890",
        "***End_of_Header***\t",
        "\t",
    ]

    def h(dec, multi, xc):
        a = list(hdr)
        a[4] %= dec
        a[5] %= multi
        a[6] %= xc
        a[11] %= dec
        return a

    r = rec(0.001, 100, 0, 10)
    t, u, y = S("%.6f", r.t), S("%.6f", r.u), S("%.6f", r.y)
    add(
        "28_sweep_one.lvm",
        "lvm",
        text(
            h(".", "No", "One")
            + [
                "Channels\t2\t\t\t",
                "Samples\t%d\t%d\t" % (r.n, r.n),
                "Date\t2023/02/17\t2023/02/17\t",
                "Time\t14:22:05.2345\t14:22:05.2345\t",
                "Y_Unit_Label\tV\tum\t",
                "X_Dimension\tTime\tTime\t",
                "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t",
                "Delta_X\t0.001000\t0.001000\t",
                "***End_of_Header***\t\t\t",
                "X_Value\tVoltage\tDisplacement\tComment",
            ]
            + [z + "\t" for z in rows("\t", t, u, y)],
            eol="\r\n",
        ),
        E,
        0.001,
        V(u),
        V(y),
        "LVM X_Columns One, trailing tabs",
        chk=lambda p: pdcsv(1, 2, 0, sep="\t", skiprows=24, header=None, usecols=[0, 1, 2])(p),
    )

    r = rec(0.0002, 100, 0, 10)
    t, u, y = C(S("%.6f", r.t)), C(S("%.6f", r.u)), C(S("%.6f", r.y))
    add(
        "29_sweep_multi.lvm",
        "lvm",
        text(
            h(",", "No", "Multi")
            + [
                "Channels\t2\t\t",
                "Samples\t%d\t\t%d" % (r.n, r.n),
                "Date\t2023/02/17\t\t2023/02/17",
                "Time\t14:22:05,2345\t\t14:22:05,2345",
                "Y_Unit_Label\tVolts\t\tµm",
                "X_Dimension\tTime\t\tTime",
                "X0\t0,0000000000000000E+0\t\t0,0000000000000000E+0",
                "Delta_X\t0,000200\t\t0,000200",
                "***End_of_Header***\t\t\t\t",
                "X_Value\tPiezospannung\tX_Value\tWegsensor\tComment",
            ]
            + rows("\t", t, u, t, y),
            "cp1252",
            eol="\r\n",
        ),
        E,
        0.0002,
        V(u, ","),
        V(y, ","),
        "LVM X_Columns Multi, decimal comma, two time columns",
        chk=lambda p: pdcsv(1, 3, 0, sep="\t", skiprows=24, header=None, decimal=",", encoding="cp1252")(p),
    )

    r = rec(0.0004, 7.5, 0, 60)
    u, y = S("%.6f", r.u), S("%.6f", r.y)
    tmp = S("%.6f", 22.1 + 0.0001 * np.arange(r.n))
    add(
        "30_nox.lvm",
        "lvm",
        text(
            h(".", "No", "No")
            + [
                "Channels\t3",
                "Samples\t%d\t%d\t%d" % ((r.n,) * 3),
                "Date\t2023/02/17\t2023/02/17\t2023/02/17",
                "Time\t14:22:05.2\t14:22:05.2\t14:22:05.2",
                "Y_Unit_Label\tdeg C\tum\tV",
                "X_Dimension\tTime\tTime\tTime",
                "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t0.0000000000000000E+0",
                "Delta_X\t4.000000E-4\t4.000000E-4\t4.000000E-4",
                "***End_of_Header***",
                "X_Value\tPT100\tCap sensor\tAO Piezo\tComment",
            ]
            + ["\t%s\t%s\t%s" % z for z in zip(tmp, y, u)],
            eol="\r\n",
        ),
        E,
        0.0004,
        V(u),
        V(y),
        "LVM X_Columns No: dt only from Delta_X; order temperature, sensor, drive",
    )

    # two segments
    r = rec(0.001, 100, 0, 10, n=300)
    u, y = S("%.6f", r.u), S("%.6f", r.y)
    seg = lambda i0: (
        [
            "Channels\t2",
            "Samples\t150\t150",
            "Date\t2023/02/17\t2023/02/17",
            "Time\t14:22:05.%03d\t14:22:05.%03d" % (200 + i0, 200 + i0),
            "Y_Unit_Label\tV\tum",
            "X_Dimension\tTime\tTime",
            "X0\t%.16E\t%.16E" % (i0 * 0.001, i0 * 0.001),
            "Delta_X\t0.001000\t0.001000",
            "***End_of_Header***",
            "X_Value\tVoltage\tDisplacement\tComment",
        ]
        + ["\t%s\t%s" % z for z in zip(u[i0 : i0 + 150], y[i0 : i0 + 150])]
        + [""]
    )
    add(
        "31_segments.lvm",
        "lvm",
        text(h(".", "Yes", "No") + seg(0) + seg(150), eol="\r\n"),
        E,
        0.001,
        V(u),
        V(y),
        "LVM Multi_Headings Yes: two packets, the second continues in time exactly",
        "refuse: two packets",
    )

    r = rec(0.001, 100, 0, 10)
    add(
        "32_noheader.lvm",
        "lvm",
        text(rows("\t", S("%.6f", r.u), S("%.6f", r.y)), eol="\r\n"),
        X,
        None,
        [],
        [],
        "LVM written with headers None: two columns of numbers, no time, no names",
    )

    r = rec(0.001, 100, 0, 10)
    add(
        "33_spreadsheet.txt",
        "labview",
        text(rows("\t", S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r.y)), eol="\r\n"),
        X,
        None,
        [],
        [],
        "LabVIEW Write To Spreadsheet File: three columns, no names at all",
    )

    # SignalExpress
    r = rec(0.001, 100, 0, 10)
    u, y = S("%.6E", r.u), S("%.6E", r.y)
    add(
        "34_signalexpress.txt",
        "ni",
        text(
            [
                "channel names:",
                "Piezo Voltage\tDisplacement",
                "start times:",
                "5/12/2015 2:31:05.123456 PM\t5/12/2015 2:31:05.123456 PM",
                "dt:",
                "0.001000\t0.001000",
                "data:",
            ]
            + rows("\t", u, y),
            eol="\r\n",
        ),
        E,
        0.001,
        V(u),
        V(y),
        "SignalExpress ASCII: names and dt in lines of the same number of fields as the data",
        chk=pdcsv(0, 1, sep="\t", skiprows=7, header=None),
    )

    r = rec(0.001, 10, 0, 4)
    ab = [
        (dt.datetime(2019, 8, 22, 15, 13, 47, 483000) + dt.timedelta(milliseconds=i)).strftime("%m/%d/%Y %H:%M:%S.%f")
        for i in range(r.n)
    ]
    add(
        "35_waveform_export.txt",
        "labview",
        text(
            [
                "waveform\t[0]\t[1]",
                "t0\t08/22/2019 15:13:47.483\t08/22/2019 15:13:47.483",
                "delta t\t0.001000\t0.001000",
                "",
                "time\tY[0]\tY[1]",
            ]
            + rows("\t", ab, S("%.6E", r.u), S("%.6E", r.y)),
            eol="\r\n",
        ),
        X,
        0.001,
        [],
        [],
        "LabVIEW Export Waveforms: Y[0], Y[1] tell nothing",
    )

    # FlexLogger
    r = rec(0.001, 10, 0, 95)
    t0 = dt.datetime(2024, 6, 3, 9, 59, 59, 900000)
    t = [(t0 + dt.timedelta(milliseconds=i)).strftime("%m/%d/%Y %I:%M:%S.%f %p") for i in range(r.n)]
    u, y = S("%.9f", r.u), S("%.9f", r.y)
    add(
        "36_flexlogger.csv",
        "ni",
        text(
            [
                "Log name,Piezo run 3",
                "Log description,",
                "Author,ni",
                "Log start time,06/03/2024 09:59:59.900000 AM",
                "Sample rate (Hz),1000",
                "",
                "Time,Amp drive (V),Cap gauge (µm),Load cell (N)",
            ]
            + rows(",", t, u, y, S("%.6f", 20 + 0.1 * r.u)),
            eol="\r\n",
            bom=BOM,
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "FlexLogger style: US date with AM/PM and microseconds, start time and rate in header",
        chk=pdcsv(1, 2, sep=",", skiprows=6, encoding="utf-8-sig"),
    )

    # text as xls
    r = rec(0.005, 100, 0, 10)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r.y)
    add(
        "37_result.xls",
        "labview",
        text(["Time (s)\tPiezo (V)\tDisplacement (um)"] + rows("\t", t, u, y), eol="\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        "tab separated text with the ending .xls, as many LabVIEW programs write",
        "refuse: ending and content differ",
        chk=pdcsv(1, 2, 0, sep="\t"),
    )
