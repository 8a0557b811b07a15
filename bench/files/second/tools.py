"""Languages and tools."""

from common import *


def tools():
    r = rec(0.001, 60, 0, 5.5)
    t, u, y = S("%.3f", r.t), S("%.4f", r.u), S("%.5f", r.y)
    add(
        "15_r_writecsv.csv",
        "csv-r",
        text(['"","time_s","u_volt","x_um"'] + rows(",", ['"%d"' % (i + 1) for i in range(r.n)], t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "R write.csv: quoted row names without a column name, unit in the name",
        chk=pdcsv("u_volt", "x_um", "time_s"),
    )

    r = rec(1e-4, 10, 0, 20)
    t, u, y = [repr(float(v)) for v in r.t], [repr(float(v)) for v in r.u], [repr(float(v)) for v in r.y]
    add(
        "16_julia.csv",
        "csv-julia",
        text(["t,u,y"] + rows(",", t, u, y)),
        E,
        (float(t[-1]) - float(t[0])) / (r.n - 1),
        V(u),
        V(y),
        "bare names t,u,y; shortest full-precision doubles (9.999e-5 style)",
        chk=pdcsv(1, 2, 0, float_precision="round_trip"),
    )

    r = rec(0.0005, 100, 0, 14)
    t, u, y = ["%.4g sec" % v for v in r.t], ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y]
    add(
        "17_writetimetable.csv",
        "csv-matlab",
        text(["Time,Vin_V,Disp_um"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        'MATLAB writetimetable: durations as "0.0005 sec"',
        chk=pdcsv(1, 2),
    )

    r = rec(0.01, 100, 0, 14200)
    t0 = dt.datetime(2024, 3, 5, 10, 15, 59, 500000)
    t = [(t0 + dt.timedelta(seconds=float(round(v, 3)))).isoformat(timespec="milliseconds") + "+01:00" for v in r.t]
    u, y = S("%.3f", r.u), S("%.1f", r.y)
    add(
        "18_pandas_iso.csv",
        "csv-pandas",
        text([",timestamp,drive_voltage [V],stage_pos [nm]"] + rows(",", [str(i) for i in range(r.n)], t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "pandas index column without name; ISO 8601 stamps with zone",
        chk=pdcsv(2, 3),
    )

    r = rec(0.001, 100, 0, 8.8)

    def td(v):
        us = int(round(v * 1e6))
        return (
            "0 days 00:00:%02d.%06d" % (us // 1000000, us % 1000000)
            if us % 1000000
            else "0 days 00:00:%02d" % (us // 1000000)
        )

    t, u, y = [td(v) for v in r.t], S("%.6f", r.u), S("%.6f", r.y)
    add(
        "19_timedelta.csv",
        "csv-pandas",
        text(["elapsed,voltage_V,displacement_um"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        'pandas Timedelta "0 days 00:00:00.001000", first row without decimals',
        chk=pdcsv(1, 2),
    )

    # Igor
    r = rec(0.0005, 100, 0, 10)
    u, y = S("%.6g", r.u), S("%.6g", r.y)
    add(
        "20_igor.itx",
        "igor",
        text(
            ["IGOR", "WAVES/D\tVpiezo\tDisp", "BEGIN"]
            + ["\t%s\t%s" % z for z in zip(u, y)]
            + [
                "END",
                'X SetScale/P x 0,0.0005,"s", Vpiezo; SetScale y 0,0,"V", Vpiezo',
                'X SetScale/P x 0,0.0005,"s", Disp; SetScale y 0,0,"um", Disp',
                'X Note Vpiezo, "E-503 amplifier, ch 1"',
            ],
            eol="\r",
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "Igor text: CR line ends, dt and units stand behind the data in SetScale lines",
    )

    # Origin
    r = rec(0.002, 100, 0, 6.9)
    t, u, y = S("%.3f", r.t), S("%.5f", r.u), S("%.5f", r.y)
    add(
        "21_Origin_Book1.dat",
        "origin",
        text(
            ["Time\tVoltage\tDisplacement", "s\tV\t\\g(m)m", "run 7\tE-663\tcapacitive, 5 kHz"] + rows("\t", t, u, y),
            eol="\r\n",
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "Origin ASCII export: long name, units, comments; micro written as \\g(m)m",
        chk=pdcsv(1, 2, 0, sep="\t", skiprows=3, header=None),
    )
    r = rec(0.002, 100, 0, 6900)
    t, u, y = S("%.3f", r.t), S("%.5f", r.u), S("%.5f", r.y)
    add(
        "22_Origin_ABC.txt",
        "origin",
        text(["A(X)\tB(Y)\tC(Y)", "Zeit\tPiezospannung\tWeg", "s\tV\tnm", "\t\tkalibriert 2021"] + rows("\t", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "Origin with short names row first, then long names, units, comments",
        chk=pdcsv(1, 2, 0, sep="\t", skiprows=4, header=None),
    )

    # gnuplot
    r = rec(0.0002, 200, 0, 19)
    t, u, y = S("%.4e", r.t), S("%12.4f", r.u), S("%12.5f", r.y)
    add(
        "23_scan.dat",
        "gnuplot",
        text(
            ["# piezo stack PSt 150/5, preload 200 N", "# 2022-09-14", "#", "# t[s]  U[V]  d[um]"]
            + ["%s %s %s" % z for z in zip(t, u, y)]
        ),
        E,
        (float(t[-1]) - float(t[0])) / (r.n - 1),
        V(u),
        V(y),
        "gnuplot: names in a # line, aligned columns",
        chk=pdcsv(1, 2, 0, sep=r"\s+", comment="#", header=None),
    )

    # Octave text
    r = rec(0.001, 100, 0, 13)

    def blk(name, a):
        return (
            ["# name: %s" % name, "# type: matrix", "# rows: %d" % len(a), "# columns: 1"]
            + [" " + s for s in a]
            + ["", ""]
        )

    t, u, y = ["%.15g" % v for v in r.t], ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y]
    add(
        "24_octave.txt",
        "octave",
        text(
            ["# Created by Octave 6.4.0, Tue Mar 14 10:02:11 2023 CET <lab@piezo>"]
            + blk("t", t)
            + blk("u", u)
            + blk("y", y)
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "Octave save -text: vectors one below the other",
        "refuse: rare format, blocks one below the other",
    )

    # serial log key=value
    r = rec(0.01, 5, 0, 3.2)
    t, u, y = ["%d" % round(v * 1000) for v in r.t], S("%.3f", r.u), S("%.3f", r.y)
    add(
        "25_serial_monitor.log",
        "log",
        text(["millis=%s\tdac_V=%s\tpos_um=%s" % z for z in zip(t, u, y)], eol="\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        "serial monitor log name=value on each line",
        "refuse: not a table",
    )

    # long format
    r = rec(0.05, 100, 0, 10)
    t, u, y = S("%.2f", r.t), S("%.3f", r.u), S("%.3f", r.y)
    ls = ["time_s,channel,value,unit"]
    for a, b, c in zip(t, u, y):
        ls += ["%s,piezo_voltage,%s,V" % (a, b), "%s,displacement,%s,um" % (a, c)]
    add(
        "26_influx_long.csv",
        "log",
        text(ls),
        E,
        r.ts,
        V(u),
        V(y),
        "long table: one row per channel and instant",
        "refuse: long table",
    )

    # row wise
    r = rec(0.001, 100, 0, 10)
    t, u, y = S("%.3f", r.t), S("%.2f", r.u), S("%.3f", r.y)
    add(
        "27_transposed.csv",
        "csv-odd",
        text(["Time (s)," + ",".join(t), "Voltage (V)," + ",".join(u), "Displacement (um)," + ",".join(y)]),
        E,
        r.ts,
        V(u),
        V(y),
        "transposed: one channel per line",
        "refuse: table on its side",
    )
