"""Text as people write it themselves."""

from common import *


def freestyle():
    # index + rate in comment
    r = rec(0.0002, 10, 0, 9)
    u, y = S("%.4f", r.u), S("%.4f", r.y)
    add(
        "81_index_rate.csv",
        "csv-rate",
        text(["# fs = 5000 Hz", "n,u [V],y [µm]"] + rows(",", [str(i) for i in range(r.n)], u, y)),
        E,
        0.0002,
        V(u),
        V(y),
        "sample index, rate in a comment",
        chk=pdcsv(1, 2, comment="#"),
    )
    r = rec(0.0005, 100, 0, 9)
    u, y = C(S("%.4f", r.u)), C(S("%.4f", r.y))
    add(
        "82_Abtastrate.txt",
        "csv-rate",
        text(
            [
                "Prüfling: PSt 150/7/20 VS12",
                "Abtastrate: 2.000,0 Hz",
                "Filter: 500,0 Hz",
                "Nr.\tSpannung in V\tWeg in µm",
            ]
            + rows("\t", [str(i + 1) for i in range(r.n)], u, y),
            "cp1252",
            "\r\n",
        ),
        E,
        0.0005,
        V(u, ","),
        V(y, ","),
        'rate with German thousands point (2.000,0 Hz) beside a filter frequency; index column; "in V"',
        chk=pdcsv(1, 2, sep="\t", decimal=",", skiprows=3, encoding="cp1252"),
    )
    r = rec(0.00025, 100, 0, 9)
    u, y = S("%.4f", r.u), S("%.4f", r.y)
    add(
        "83_interval_us.csv",
        "csv-rate",
        text(["Sample interval (us),250", "Channels,2", "Drive (V),Displacement (um)"] + rows(",", u, y)),
        E,
        0.00025,
        V(u),
        V(y),
        "interval in microseconds in a header line, no time column",
        chk=pdcsv(0, 1, skiprows=2),
    )
    r = rec(0.0005, 100, 0, 9)
    u, y = S("%.4f", r.u), S("%.4f", r.y)
    add(
        "84_kSs.txt",
        "csv-rate",
        text(
            ["DAQ: USB-6211", "Sample rate: 2 kS/s", "Excitation: 12.5 Hz rising sine", "", "Vpiezo[V]   xsens[um]"]
            + rows("   ", u, y)
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "rate as 2 kS/s beside an excitation frequency in Hz",
        chk=pdcsv(0, 1, sep=r"\s+", skiprows=5, header=None),
    )
    # coarse printed time, rate in header
    r = rec(1 / 2048.0, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.4f", r.u), S("%.4f", r.y)
    add(
        "85_coarse_time.txt",
        "csv-rate",
        text(["Sampling frequency: 2048 Hz", "Time (s)\tVoltage (V)\tDisplacement (um)"] + rows("\t", t, u, y)),
        E,
        1 / 2048.0,
        V(u),
        V(y),
        "time printed to 1 ms at 2048 Hz (steps 0 and 1 ms, repeated stamps), rate in the header",
        chk=pdcsv(1, 2, sep="\t", skiprows=1),
    )
    # trailing summary
    r = rec(0.001, 100, 0, 9)
    t, u, y = C(S("%.3f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", r.y))
    add(
        "86_mit_Statistik.csv",
        "csv-odd",
        text(
            ["Zeit / s;Spannung / V;Weg / µm"]
            + rows(";", t, u, y)
            + [
                "",
                "Mittelwert;%s;%s" % ("45,123", "4,5561"),
                "Minimum;0,000;0,0001",
                "Maximum;99,871;9,3312",
                "Ende der Messung",
            ],
            "cp1252",
            "\r\n",
        ),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "summary lines after the data",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="cp1252", nrows=r.n),
    )
    # comments between
    r2 = r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    ls = ["time,s\tdrive,V\tpos,um"]
    for i, z in enumerate(rows("\t", t, u, y)):
        if i and i % 60 == 0:
            ls += ["// marker %d set by user" % (i // 60)]
        ls.append(z)
    add(
        "87_markers.txt",
        "csv-odd",
        text(ls),
        E,
        r.ts,
        V(u),
        V(y),
        "comment lines between the data; unit after a comma inside tab separated names",
        chk=pdcsv(1, 2, 0, sep="\t", comment="/"),
    )
    # repeated header
    r = rec(0.002, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    ls = []
    for i, z in enumerate(rows(",", t, u, y)):
        if i % 50 == 0:
            ls.append("Time_s,Piezo_V,Sensor_um")
        ls.append(z)
    add(
        "88_repeated_header.csv",
        "csv-odd",
        text(ls),
        E,
        r.ts,
        V(u),
        V(y),
        "header repeated every 50 rows, time goes on",
    )
    # plus signs
    r = rec(0.001, 100, -100, 9)
    t, u, y = S("%+.4E", r.t), S("%+.4E", r.u), S("%+.4E", r.y)
    add(
        "89_plus.csv",
        "csv-odd",
        text(["T_sec,U_volt,D_micron"] + rows(", ", t, u, y), final=False),
        E,
        (V(t)[-1] - V(t)[0]) / (r.n - 1),
        V(u),
        V(y),
        "plus signs, blanks after commas, no final newline",
        chk=pdcsv(1, 2, 0),
    )
    # mixed tab and blanks
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "90_mixed_ws.txt",
        "csv-odd",
        text(
            [" Time(s) \t Vpzt(V)   Displ(um)"]
            + [" %s\t  %s \t%s  " % z if i % 3 else "%s %s\t%s" % z for i, z in enumerate(zip(t, u, y))]
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "tabs and blanks mixed",
        chk=pdcsv(1, 2, 0, sep=r"\s+"),
    )
    # CR
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "91_mac_cr.txt",
        "csv-odd",
        text(["Time [s]\tVoltage [V]\tDisplacement [µm]"] + rows("\t", t, u, y), "mac_roman", "\r"),
        E,
        r.ts,
        V(u),
        V(y),
        "CR line ends and MacRoman micro sign",
        chk=pdcsv(1, 2, 0, sep="\t", encoding="mac_roman"),
    )
