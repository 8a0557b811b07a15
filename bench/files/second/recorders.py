"""Recorders."""

from common import *


def recorders():
    r = rec(0.0005, 100, 0, 11)
    t, u, y = S("%+.5E", r.t), S("%+.5E", r.u), S("%+.5E", r.y)
    add(
        "55_WAVE0001.CSV",
        "hioki",
        text(
            [
                '"HIOKI 8847","CSV","V3.10"',
                '"File name","WAVE0001.MEM"',
                '"Title comment","PSt-HD 200"',
                '"Trigger time","\'23-06-14 09:12:44.120"',
                '"Channel","CH1-1","CH1-2","CH2-1"',
                '"Comment","Piezo amp","Laser disp","T amb"',
                '"Time","CH1-1[V]","CH1-2[um]","CH2-1[degC]"',
            ]
            + rows(",", t, u, y, S("%+.5E", 23 + r.g.normal(0, 0.01, r.n))),
            eol="\r\n",
        ),
        E,
        (float(t[-1]) - float(t[0])) / (r.n - 1),
        V(u),
        V(y),
        "Hioki: channel numbers with units, comments row, plus signs in exponents",
        chk=pdcsv(1, 2, 0, skiprows=7, header=None),
    )

    # Graphtec
    r = rec(0.001, 100, 0, 10)
    sg = lambda a, p: [("+" if v >= 0 else "-") + ("%*.*f" % (9, p, abs(v))) for v in a]
    u, y = sg(np.round(r.u, 2), 2), sg(np.round(r.y, 3), 3)
    t0 = dt.datetime(2022, 5, 19, 13, 20, 7)
    dtm = [(t0 + dt.timedelta(milliseconds=i)).strftime("%Y/%m/%d %H:%M:%S") for i in range(r.n)]
    add(
        "56_220519-132007.CSV",
        "graphtec",
        text(
            [
                "Vendor,GRAPHTEC Corporation",
                "Model,GL980",
                "Version,Ver1.04",
                "Sampling interval,1ms",
                "Total data points,%d" % r.n,
                "Start time,2022/05/19 13:20:07",
                "End time,2022/05/19 13:20:07",
                "Trigger time,2022/05/19 13:20:07",
                "AMP settings",
                "CH,Signal name,Input,Range,Filter,Span",
                "CH 1,Piezo,DC,100V,Off,+100.00,-100.00,V",
                "CH 2,Displ.,DC,10V,Off,+20.000,-20.000,um",
                "Logic/Pulse,Off",
                "Data",
                "Number,Date&Time,ms,CH1,CH2,Alarm1",
                "NO.,Time,ms,V,um,A1234567890",
            ]
            + rows(
                ",",
                ["%d" % (i + 1) for i in range(r.n)],
                dtm,
                ["%d" % (i % 1000) for i in range(r.n)],
                u,
                y,
                ["LLLLLLLLLL"] * r.n,
            ),
            eol="\r\n",
        ),
        E,
        0.001,
        V(u),
        V(y),
        "Graphtec: clock without ms and an extra ms column, sign and blanks before digits, units row, interval 1ms in the header",
    )

    # Gantner, OLE
    r = rec(0.1, 150, 0, 16)
    t = ["%.10f" % (45321.4375 + v / 86400) for v in r.t]
    u, y = S("%.4f", r.u), S("%.5f", r.y)
    add(
        "57_GINsData.csv",
        "gantner",
        text(
            [
                "Gantner Instruments Q.station",
                "Sample rate: 10 Hz",
                "",
                "Timestamp (OLE);Piezo_Voltage;Piezo_Current;Displacement",
                "d;V;mA;µm",
            ]
            + rows(";", t, u, S("%.3f", np.gradient(r.u)), y),
            eol="\r\n",
        ),
        E,
        0.1,
        V(u),
        V(y),
        "time as OLE days (45321.43...), rate in the header; current beside",
        chk=pdcsv(1, 3, sep=";", skiprows=5, header=None),
    )

    # catman
    r = rec(0.005, 100, 0, 25)
    t, u, y = C(S("%.6f", r.t)), C(S("%.6f", r.u)), C(S("%.6f", r.y))
    add(
        "58_catman_Job1.ASC",
        "catman",
        text(
            [
                "catmanAP V5.4.2 Build 58",
                "DATEI\tD:\\Messungen\\Job1_2023_05_02.BIN",
                "ANZAHL KANÄLE\t4",
                "MAX. LÄNGE\t%d" % r.n,
                "ABTASTZEITEN [s]\t0,005\t0,005\t0,005\t0,005",
                "",
                "",
                "Zeit  1 - Standardmessrate\tMX440A_CH 1 Piezospannung\tMX440A_CH 2 Wegaufnehmer\tMX440A_CH 3 Kraft",
                "s\tV\tµm\tN",
            ]
            + rows("\t", t, u, y, C(S("%.6f", 200 + r.u * 0.3))),
            "cp1252",
            "\r\n",
        ),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "HBM catman ASCII in German: header lines with as many fields as the rows",
        chk=pdcsv(1, 2, 0, sep="\t", skiprows=9, header=None, decimal=",", encoding="cp1252"),
    )

    # imc famos
    r = rec(0.0002, 100, 0, 5)
    t, u, y = S("%.4f", r.t), S("%.5g", r.u), S("%.5g", r.y)
    add(
        "59_famos.txt",
        "imc",
        text(["x:U_Piezo [s]\tU_Piezo [V]\tx:s_Sensor [s]\ts_Sensor [µm]"] + rows("\t", t, u, t, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        "imc FAMOS export: each channel with its own x column",
        chk=pdcsv(1, 3, 0, sep="\t", encoding="cp1252"),
    )

    # Dewesoft
    r = rec(0.0002, 100, 0, 13)
    t, u, y = C(S("%.4f", r.t)), C(S("%.5f", r.u)), C(S("%.5f", r.y))
    add(
        "60_Piezo_0003.txt",
        "dewesoft",
        text(
            [
                "Data file info",
                "File name\tC:\\DEWESoft\\Data\\Piezo_0003.dxd",
                "Start time\t12.03.2024 14:22:10,123",
                "Number of channels\t3",
                "Sample rate\t5000",
                "Store mode\talways fast",
                "",
                "Events",
                "Event Type\tEvent\tTime\tComment",
                "1\tstoring started at\t0,0000\t",
                "2\tstoring stopped at\t0,0800\t",
                "",
                "Data1",
                "Time\tPiezo amp out\tKapsensor\tPT100",
                "s\tV\tµm\t°C",
            ]
            + rows("\t", t, u, y, C(S("%.2f", 21 + 0 * r.u))),
            "utf-8",
            "\r\n",
            bom=BOM,
        ),
        E,
        0.0002,
        V(u, ","),
        V(y, ","),
        "DEWESoft text: info block, a table of events with four fields before the data",
        chk=pdcsv(1, 2, 0, sep="\t", skiprows=15, header=None, decimal=",", encoding="utf-8-sig"),
    )

    # MTS
    r = rec(0.01, 100, 0, 0.2)
    add(
        "61_specimen.dat",
        "mts",
        text(
            [
                "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A",
                "",
                "Data Acquisition: Timed\t\t\tTime:\t0.0112305 \tSec\t5/4/2021 3:06:26 PM",
                "Time\tAxial Displacement\tAxial Force",
                "Sec\tmm\tkN",
            ]
            + rows("\t", S("%.5f", r.t), S("%.7f", r.y), S("%.6f", r.u * 0.01)),
            eol="\r\n",
        ),
        X,
        0.01,
        [],
        [],
        "MTS: displacement and force, no voltage",
    )

    # Polytec
    r = rec(0.0001953125, 80, 0, 6.2e-6)
    t, u, y = S("%.9E", r.t), S("%.6E", r.u), S("%.6E", r.y)
    add(
        "62_vib_displ.txt",
        "polytec",
        text(
            [
                "Source File Name:\tpiezo_7.pvd",
                "Point Index:\t1",
                "Component:\tRoot",
                "Signal:\tVib - Displacement - Samples, Ref1 - Voltage - Samples",
                "",
                "Time\tVib Displacement\tRef1 Voltage",
                "[ s ]\t[ m ]\t[ V ]",
            ]
            + rows("\t", t, y, u),
            eol="\r\n",
        ),
        E,
        (float(t[-1]) - float(t[0])) / (r.n - 1),
        V(u),
        V(y),
        'Polytec: displacement in m (1e-6), output before input, units row "[ s ]"',
        chk=pdcsv(2, 1, 0, sep="\t", skiprows=7, header=None),
    )
    r = rec(0.0001953125, 80, 0, 6.2e-6)
    add(
        "63_vib_vel.txt",
        "polytec",
        text(
            [
                "Source File Name:\tpiezo_8.pvd",
                "Signal:\tVib - Velocity - Samples, Ref1 - Voltage - Samples",
                "",
                "Time\tVib Velocity\tRef1 Voltage",
                "[ s ]\t[ m/s ]\t[ V ]",
            ]
            + rows("\t", S("%.9E", r.t), S("%.6E", np.gradient(r.y, r.ts)), S("%.6E", r.u)),
            eol="\r\n",
        ),
        X,
        r.ts,
        [],
        [],
        "Polytec: velocity instead of displacement",
    )

    # SIOS
    r = rec(0.01, 100, 0, 10)
    add(
        "64_SIOS_log.txt",
        "sios",
        text(
            [
                "SIOS Meßtechnik GmbH - INFAS 4.5",
                "Messrate: 100 Hz",
                "Wellenlänge: 632.8 nm",
                "Luftdruck: 1004.3 hPa",
                "Nr.\tZeit [s]\tLänge [nm]",
            ]
            + rows("\t", ["%d" % i for i in range(r.n)], S("%.2f", r.t), S("%.2f", r.y * 1e3)),
            "cp1252",
            "\r\n",
        ),
        X,
        0.01,
        [],
        [],
        "SIOS interferometer: length only, no voltage",
    )
