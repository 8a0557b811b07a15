#!/usr/bin/env python3
# -*- coding: utf-8 -*-
"""A second set of records as other programs write them, by someone who had not seen how the first set is read.

usage: second.py DIR [--check]

Every file has its own record; truth.json states what a careful engineer would read from it. With --check, other
libraries read the files back.
"""

import os, io, json, struct, zipfile, shutil, datetime as dt, math, wave, sys
import numpy as np

ROOT = sys.argv[1]
OUT = ROOT
os.makedirs(OUT, exist_ok=True)
TRUTH = []
CHECKS = []  # (file, function(path) -> (u, y, ts or None))
_seed = [4000]


# --------------------------------------------------------------------------- signals
class Rec:
    pass


def rec(ts, umax=100.0, umin=0.0, stroke=10.0, f=None, n=None, noise=2e-4, unoise=0.0, rising=0.75, y0=0.0):
    """Sine of rising amplitude and a hysteretic answer (play operators, lag, some creep).
    stroke: displacement at full voltage, in the unit wanted for y."""
    _seed[0] += 1
    g = np.random.default_rng(_seed[0])
    if n is None:
        n = int(g.integers(150, 401))
    if f is None:
        f = float(g.uniform(2.5, 4.5)) / (n * ts)
    k = np.arange(n)
    t = k * ts
    amp = (1 - rising) + rising * k / (n - 1)
    s = amp * 0.5 * (1 - np.cos(2 * np.pi * f * t))
    u = umin + (umax - umin) * s + unoise * (umax - umin) * g.standard_normal(n)
    # Prandtl-Ishlinskii
    x = (u - umin) / (umax - umin)
    rs = np.array([0.02, 0.06, 0.12, 0.2, 0.3, 0.42])
    ws = np.array([0.10, 0.08, 0.07, 0.06, 0.05, 0.04])
    st = np.zeros(6)
    y = np.empty(n)
    lag = 0.0
    a = 0.35
    cr = 0.0
    for i in range(n):
        st = np.maximum(x[i] - rs, np.minimum(x[i] + rs, st))
        z = 0.72 * x[i] + float(ws @ st)
        cr += 0.002 * (z - cr)
        lag += a * (z + 0.02 * cr - lag)
        y[i] = lag
    y = y0 + stroke * (y + noise * g.standard_normal(n))
    r = Rec()
    r.t, r.u, r.y, r.n, r.ts, r.g, r.f = t, u, y, n, ts, g, f
    return r


# --------------------------------------------------------------------------- text helpers
def S(spec, arr):
    return [spec % float(v) for v in arr]


def V(strs, dec=".", th=""):
    out = []
    for s in strs:
        s = s.strip().strip('"').replace(" ", "")
        if th:
            s = s.replace(th, "")
        if dec != ".":
            s = s.replace(dec, ".")
        s = s.replace("D", "E").replace("d", "e")
        out.append(float(s))
    return out


def C(strs):
    """decimal comma"""
    return [s.replace(".", ",") for s in strs]


def rows(sep, *cols):
    return [sep.join(r) for r in zip(*cols)]


def path(name):
    p = os.path.join(OUT, name)
    return p


def text(lines, enc="utf-8", eol="\n", final=True, bom=b""):
    s = eol.join(lines) + (eol if final else "")
    return bom + s.encode(enc)


def add(name, family, data, expect, ts, u, y, why, also_ok="", chk=None):
    if data is not None:
        with open(path(name), "wb") as fh:
            fh.write(data)
    assert os.path.exists(path(name)), name
    assert expect in ("read", "refuse")
    assert also_ok == "" or also_ok.startswith("refuse")
    if expect == "refuse":
        u, y = [], []
    else:
        assert len(u) == len(y) and len(u) >= 150, (name, len(u), len(y))
    conv = lambda a: [None if (isinstance(v, float) and math.isnan(v)) else float(v) for v in a]
    TRUTH.append(
        dict(
            file=name,
            family=family,
            expect=expect,
            ts=None if ts is None else float(ts),
            u=conv(u),
            y=conv(y),
            why=why,
            also_ok=also_ok,
        )
    )
    if chk is not None:
        CHECKS.append((name, chk))


def pdcsv(uc, yc, tc=None, tscale=1.0, **kw):
    """check by pandas"""

    def f(p):
        import pandas as pd

        d = pd.read_csv(p, **kw)
        u = pd.to_numeric(d.iloc[:, uc] if isinstance(uc, int) else d[uc]).to_numpy(float)
        y = pd.to_numeric(d.iloc[:, yc] if isinstance(yc, int) else d[yc]).to_numpy(float)
        ts = None
        if tc is not None:
            t = pd.to_numeric(d.iloc[:, tc] if isinstance(tc, int) else d[tc]).to_numpy(float) * tscale
            ts = (t[-1] - t[0]) / (len(t) - 1)
        return u, y, ts

    return f


BOM = b"\xef\xbb\xbf"
E = "read"
X = "refuse"


# =========================================================================== spreadsheets, countries
def excel():
    r = rec(0.001, 120, 0, 15)
    t, u, y = C(S("%.3f", r.t)), C(S("%.2f", r.u)), C(S("%.3f", r.y))
    add(
        "01_Messung Piezo 120V.csv",
        "csv-excel",
        text(["Zeit [s];Spannung [V];Weg [µm]"] + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "German Excel: semicolon, decimal comma, cp1252 micro sign, CRLF",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="cp1252"),
    )

    r = rec(0.0005, 150, -20, 30)
    t, u, y = C(S("%.4f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", r.y))
    add(
        "02_essai_actionneur.csv",
        "csv-excel",
        text(
            ["Temps (s);Tension de commande (V);Déplacement (µm);Température (°C)"]
            + rows(";", t, u, y, C(S("%.1f", 23 + 0.002 * np.arange(r.n)))),
            "utf-8",
            "\r\n",
            bom=BOM,
        ),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "French Excel CSV UTF-8 with BOM, accents, temperature beside",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="utf-8-sig"),
    )

    r = rec(0.002, 10, 0, 9500)
    t, u, y = S("%.1f", r.t * 1e3), S("%.4f", r.u), S("%.1f", r.y)
    add(
        "03_stage_unicode.txt",
        "csv-excel",
        text(["Time (ms)\tPiezo voltage (V)\tPosition (nm)"] + rows("\t", t, u, y), "utf-16", "\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        'Excel "Unicode Text": UTF-16 LE with BOM, tabs, time in ms, nm',
        chk=pdcsv(1, 2, 0, 1e-3, sep="\t", encoding="utf-16"),
    )

    r = rec(0.001, 75, 0, 6.1)
    t, u, y = C(S("%.3f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", r.y))
    q = lambda a: ['"%s"' % s for s in a]
    add(
        "04_prova_libreoffice.csv",
        "csv-libreoffice",
        text(['"Tempo (s)","Tensione (V)","Spostamento (µm)"'] + rows(",", q(t), q(u), q(y))),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "Italian LibreOffice: comma separator and quoted decimal commas",
        chk=pdcsv(1, 2, 0, sep=",", decimal=","),
    )

    r = rec(0.004, 100, 0, 42)
    t, u, y = C(S("%.3f", r.t)), C(S("%.2f", r.u)), C(S("%.2f", r.y))
    add(
        "05_ensayo.csv",
        "csv-excel",
        text(["sep=;", "Tiempo (s);Voltaje (V);Desplazamiento (um)"] + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "Spanish, first line sep=;",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="cp1252", skiprows=1),
    )

    # Polish, elapsed clock
    r = rec(0.02, 100, 0, 11.5)

    def hms(s):
        ms = int(round(s * 1000))
        return "%02d:%02d:%02d,%03d" % (ms // 3600000, ms // 60000 % 60, ms // 1000 % 60, ms % 1000)

    t, u, y = [hms(57.5 + s) for s in r.t], C(S("%.2f", r.u)), C(S("%.3f", r.y))
    add(
        "06_pomiar_piezo.csv",
        "csv-excel",
        text(["Czas;Napięcie [V];Przemieszczenie [µm]"] + rows(";", t, u, y), "cp1250", "\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "Polish cp1250; elapsed time hh:mm:ss,fff passing a full minute",
        chk=pdcsv(1, 2, sep=";", decimal=",", encoding="cp1250"),
    )

    r = rec(0.0025, 130, -30, 0.0148)
    t, u, y = S("%.4f", r.t), S("%.3f", r.u), S("%.6f", r.y)
    add(
        "07_meting.csv",
        "csv-excel",
        text(["tijd (s);spanning (V);verplaatsing (mm)"] + rows(";", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "Dutch names, displacement in mm, lower case, decimal point with semicolon",
        chk=pdcsv(1, 2, 0, sep=";"),
    )

    # thousands separators
    r = rec(0.001, 100, 0, 24000, y0=1500)
    t, u, y = S("%.3f", r.t), S("%.2f", r.u), ['"%s"' % format(v, ",.1f") for v in r.y]
    add(
        "08_us_thousands.csv",
        "csv-excel",
        text(["Time (s),Voltage (V),Position (nm)"] + rows(",", t, u, y), eol="\r\n"),
        E,
        r.ts,
        V(u),
        V(y, th=","),
        'quoted numbers with thousands commas "12,345.6"',
        chk=pdcsv(1, 2, 0, sep=",", thousands=","),
    )

    r = rec(0.001, 800, 0, 31000)
    fm = lambda a, p: [format(v, ",.%df" % p).replace(",", "'") for v in a]
    t, u, y = S("%.3f", r.t), S("%.1f", r.u), fm(r.y, 1)
    add(
        "09_swiss.csv",
        "csv-excel",
        text(["Zeit (s);HV-Spannung (V);Auslenkung (nm)"] + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u),
        V(y, th="'"),
        "Swiss Excel: apostrophe thousands 12'345.6, decimal point, semicolon",
        chk=pdcsv(1, 2, 0, sep=";", thousands="'", encoding="cp1252"),
    )

    # German with DE thousands and comma
    r = rec(0.001, 100, 0, 18000)
    de = lambda a, p: [format(v, ",.%df" % p).replace(",", "X").replace(".", ",").replace("X", ".") for v in a]
    t, u, y = de(r.t * 1000, 1), de(r.u, 2), de(r.y, 1)
    # time in ms reaches below 1000 only
    add(
        "10_Auswertung_Tausender.csv",
        "csv-excel",
        text(["Zeit (ms);Ansteuerspannung (V);Weg (nm)"] + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u, ",", "."),
        V(y, ",", "."),
        "German thousands point and decimal comma together: 12.345,6",
        chk=pdcsv(1, 2, 0, 1e-3, sep=";", decimal=",", thousands=".", encoding="cp1252"),
    )

    # chinese / japanese / russian
    r = rec(0.0005, 120, 0, 52)
    t, u, y = S("%.4f", r.t), S("%.3f", r.u), S("%.3f", r.y)
    add(
        "11_压电数据.csv",
        "csv-language",
        text(["时间(s),电压(V),位移(um)"] + rows(",", t, u, y), "gbk", "\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        "Chinese names in GBK; the units alone tell the channels; non-ASCII file name",
        chk=pdcsv(1, 2, 0, sep=",", encoding="gbk"),
    )
    r = rec(0.001, 150, 0, 17.4)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r.y)
    add(
        "12_sokutei.csv",
        "csv-language",
        text(["測定日,2023/11/02", "時間[s],電圧[V],変位[μm]"] + rows(",", t, u, y), "shift_jis", "\r\n"),
        E,
        r.ts,
        V(u),
        V(y),
        "Japanese Shift-JIS; Greek mu instead of the micro sign; title line",
        chk=pdcsv(1, 2, 0, sep=",", encoding="shift_jis", skiprows=1),
    )
    r = rec(0.001, 90, 0, 8)
    t, u, y = C(S("%.3f", r.t)), C(S("%.2f", r.u)), C(S("%.3f", r.y))
    add(
        "13_opyt.csv",
        "csv-language",
        text(["Время, с;Напряжение, В;Перемещение, мкм"] + rows(";", t, u, y), "cp1251", "\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "Russian cp1251, names and units Cyrillic, unit after a comma",
        "refuse: names and units in a script the reader need not know",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="cp1251"),
    )

    # German excel with empty columns, trailing separators
    r = rec(0.001, 100, 0, 12)
    t, u, y = C(S("%.3f", r.t)), C(S("%.2f", r.u)), C(S("%.3f", r.y))
    add(
        "14_leere_spalten.csv",
        "csv-excel",
        text(
            ["Piezo P-843.20, Kanal 1;;;;;;", ";;;;;;", "Zeit;;Spannung;;Weg;;", "s;;V;;µm;;"]
            + ["%s;;%s;;%s;;" % z for z in zip(t, u, y)]
            + [";;;;;;"] * 5,
            "cp1252",
            "\r\n",
        ),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "empty columns between, title line, units row, empty rows at the end",
        chk=lambda p: pdcsv(2, 4, 0, sep=";", decimal=",", encoding="cp1252", skiprows=4, header=None, nrows=r.n)(p),
    )


excel()


# =========================================================================== languages and tools
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


tools()


# =========================================================================== NI
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


ni()


# =========================================================================== oscilloscopes
def scopes():
    r = rec(4e-5, 5, 0, 4.2)
    t, u, y = S("%.8e", r.t - 0.002), S("%.5f", r.u), S("%.5f", r.y)
    mh = lambda lab: [
        "Model,MSO56",
        "Label,%s" % lab,
        "Waveform Type,ANALOG,ANALOG",
        "Horizontal Units,s,s",
        "Sample Interval,4.00000000e-05,4.00000000e-05",
        "Record Length,%d,%d" % (r.n, r.n),
        "Zero Index,50.00000000,50.00000000",
        "Vertical Units,V,V",
        "FastFrame Count,0,0",
        ",",
        ",",
        "Labels,%s" % lab,
        "TIME,CH1,CH2",
    ]
    add(
        "38_tek_mso_labels.csv",
        "scope-tek",
        text(mh("Piezo drive,Displacement sensor") + rows(",", t, u, y), eol="\r\n"),
        E,
        4e-5,
        V(u),
        V(y),
        "Tek MSO5: CH1/CH2 both in V, the labels tell which is what; time starts negative",
        chk=lambda p: pdcsv(1, 2, 0, skiprows=12)(p),
    )
    r = rec(4e-5, 5, 0, 4.2)
    add(
        "39_tek_mso_nolabels.csv",
        "scope-tek",
        text(mh(",") + rows(",", S("%.8e", r.t - 0.002), S("%.5f", r.u), S("%.5f", r.y)), eol="\r\n"),
        X,
        4e-5,
        [],
        [],
        "Tek MSO5 without labels: CH1 and CH2 both in V",
    )
    r = rec(4e-4, 5, 0, 4.2)
    side = [
        "Record Length,%d" % r.n,
        "Sample Interval,4.000000e-04",
        "Trigger Point,0.0",
        ",",
        ",",
        ",",
        "Source,CH1",
        "Vertical Units,V",
        "Vertical Scale,2.000000e+00",
        "Vertical Offset,0.0",
        "Horizontal Units,s",
        "Horizontal Scale,1.0e-02",
        "Pt Fmt,Y",
        "Yzero,0.0",
        "Probe Atten,1.0",
        "Model Number,TDS1012B",
        "Serial Number,C051234",
        "Firmware Version,FV:v22.11",
    ]
    side += [","] * (r.n - len(side))
    add(
        "40_F0000CH1.CSV",
        "scope-tek",
        text(["%s,,%s,%s," % (a, b, c) for a, b, c in zip(side, S("%.6f", r.t), S("%.5f", r.u))], eol="\r\n"),
        X,
        4e-4,
        [],
        [],
        "Tek TDS1000 F0000CH1.CSV: one channel only",
    )
    r = rec(1e-4, 5, 0, 4.2)
    add(
        "41_scope_1.csv",
        "scope-keysight",
        text(
            ["x-axis,1,2", "second,Volt,Volt"] + rows(",", S("%+.6E", r.t), S("%+.5E", r.u), S("%+.5E", r.y)),
            eol="\r\n",
        ),
        X,
        1e-4,
        [],
        [],
        "Keysight InfiniiVision: channels 1 and 2, both Volt",
    )
    # Keysight with probe units set to metre? no: readable Rigol
    r = rec(2e-4, 5, 0, 4.2)
    add(
        "42_RigolDS0.csv",
        "scope-rigol",
        text(
            ["X,CH1,CH2,Start,Increment,", "Sequence,Volt,Volt,0.000000e+00,2.000000e-04"]
            + ["%d,%s,%s," % z for z in zip(range(r.n), S("%.2e", r.u), S("%.2e", r.y))],
            eol="\r\n",
        ),
        X,
        2e-4,
        [],
        [],
        "Rigol: CH1 and CH2 both Volt",
    )
    # Siglent with source names
    r = rec(5e-4, 10, 0, 8.0)
    t, u, y = S("%.9f", r.t - 0.05), S("%.5f", r.u), S("%.5f", r.y)
    add(
        "43_SDS00012.csv",
        "scope-siglent",
        text(
            [
                "Record Length,Analog:%d,Analog:%d" % (r.n, r.n),
                "Sample Interval,C1:5.000000E-04,C2:5.000000E-04",
                "Vertical Units,C1:V,C2:V",
                "Vertical Scale,C1:2.00,C2:2.00",
                "Vertical Offset,C1:-4.0,C2:-4.0",
                "Horizontal Units,s",
                "Horizontal Scale,0.02",
                "Model Number,SDS2104X Plus",
                "Serial Number,SDS2PDDQ4R0001",
                "Software Version,1.3.9R6",
                "Source,C1,C2",
                "Second,Volt,Volt",
            ]
            + rows(",", t, u, y),
            eol="\r\n",
        ),
        X,
        5e-4,
        [],
        [],
        "Siglent: C1 and C2 both in V, no labels",
    )
    # R&S with labels
    r = rec(1e-4, 6, 0, 5)
    t, u, y = S("%.7E", r.t), S("%.5E", r.u), S("%.5E", r.y)
    add(
        "44_RTB_01.CSV",
        "scope-rs",
        text(["in s,PIEZO_DRIVE in V,DISPL_SENSOR in V"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        'R&S RTB: unit as "in V", sensor in volts with a clear label',
        chk=pdcsv(1, 2, 0),
    )
    # Yokogawa
    r = rec(0.0005, 100, 0, 7.7)
    u, y = S("%.5E", r.u), S("%.5E", r.y)
    add(
        "45_DL850_0003.csv",
        "scope-yokogawa",
        text(
            [
                '"Header Size",16',
                '"Model Name","DL850E"',
                '"Comment",""',
                '"BlockNumber",1',
                '"TraceName","PZT_OUT   ","GAP_SENS  "',
                '"BlockSize",%d,%d' % (r.n, r.n),
                '"VUnit","V","um"',
                '"SampleRate",2.0000000E+03,2.0000000E+03',
                '"HResolution",5.0000000E-04,5.0000000E-04',
                '"HOffset",0.0000000E+00,0.0000000E+00',
                '"HUnit","s","s"',
                '"DisplayBlockSize",%d,%d' % (r.n, r.n),
                '"DisplayPointNo.",1,1',
                '"PhaseShift",0.0,0.0',
                '"Date","2023/11/08","2023/11/08"',
                '"Time","10:21:33.123456","10:21:33.123456"',
                "",
            ]
            + [",%s,%s" % z for z in zip(u, y)],
            eol="\r\n",
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "Yokogawa DL850: row labels in the first column, data rows with an empty first field, no time column",
        chk=pdcsv(1, 2, skiprows=17, header=None),
    )
    # PicoScope
    r = rec(0.0001, 10, 0, 8.4)
    add(
        "46_20230112-0001_1.csv",
        "picoscope",
        text(
            ["Time,Channel A,Channel B", "(ms),(V),(V)", ""]
            + rows(",", S("%.8f", r.t * 1e3 - 5), S("%.8f", r.u), S("%.8f", r.y)),
            eol="\r\n",
        ),
        X,
        1e-4,
        [],
        [],
        "PicoScope Channel A and B both in V",
    )
    r = rec(2e-5, 10, 0, 8.4)
    t, u, y = S("%.8f", r.t * 1e3 - 1), S("%.8f", r.u), S("%.8f", r.y)
    add(
        "47_20230112-0002_1.csv",
        "picoscope",
        text(
            ["Time,Piezo drive,Capacitive probe,Trigger", "(ms),(V),(µm),(mV)", ""]
            + rows(",", t, u, y, ["∞" if i % 40 < 20 else "-12.54321300" for i in range(r.n)]),
            eol="\r\n",
            bom=BOM,
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "PicoScope with named channels, units row in parentheses, blank line, over-range sign ∞ in an unneeded channel",
        chk=pdcsv(1, 2, 0, 1e-3, skiprows=3, header=None, encoding="utf-8-sig"),
    )
    r = rec(2e-6, 10000, 0, 900)
    t, u, y = C(S("%.6f", r.t * 1e6)), C(S("%.5f", r.u)), C(S("%.5f", r.y))
    add(
        "48_pico_de.txt",
        "picoscope",
        text(["Zeit\tAktorspannung\tWeg", "(us)\t(mV)\t(nm)", ""] + rows("\t", t, u, y), "cp1252", eol="\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "PicoScope txt in German: decimal comma, units us, mV, nm",
        chk=pdcsv(1, 2, 0, 1e-6, sep="\t", skiprows=3, header=None, decimal=",", encoding="cp1252"),
    )
    # Digilent
    r = rec(0.0005, 5, 0, 3.9)
    t, u, y = ["%.10g" % (v - 0.05) for v in r.t], ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y]
    dh = [
        "#Digilent WaveForms Oscilloscope Acquisition",
        "#Device Name: Discovery2",
        "#Serial Number: SN:210321A12345",
        "#Date Time: 2023-04-05 10:11:12.123.456",
        "#Sample rate: 2000Hz",
        "#Samples: %d" % r.n,
        "#Trigger: Source: None Type: Edge Condition: Rising Level: 0 V Hyst.: Auto HoldOff: 0 s",
    ]
    add(
        "49_acq0001.csv",
        "digilent",
        text(
            dh
            + [
                "#Channel 1: Range: 1 V/div Offset: 0 V Attenuation: 1 X",
                "#Channel 2: Range: 1 um/div Offset: 0 um Attenuation: 1 X",
                "",
                "Time (s),Piezo amp (V),Displacement (um)",
            ]
            + rows(",", t, u, y)
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "WaveForms with renamed channels and a custom unit",
        chk=pdcsv(1, 2, 0, comment="#"),
    )
    r = rec(0.0005, 5, 0, 3.9)
    add(
        "50_acq0002.csv",
        "digilent",
        text(
            dh
            + ["", "Time (s),Channel 1 (V),Channel 2 (V)"]
            + rows(",", S("%.6f", r.t), ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y])
        ),
        X,
        0.0005,
        [],
        [],
        "WaveForms default names, both V",
    )
    # Moku
    r = rec(0.001, 5, 0, 8.2)
    t, u, y = S("%.10e", r.t), S("%.10e", r.u), S("%.10e", r.y)
    add(
        "51_MokuDataLog_20230601.csv",
        "moku",
        text(
            [
                "% Moku:Go Data Logger",
                "% Input 1 - DC coupled, 10 Vpp - piezo amplifier drive signal",
                "% Input 2 - DC coupled, 10 Vpp - displacement sensor (capacitive), 2 um/V",
                "% Acquisition rate: 1.0000000000e+03 Hz, Precision mode",
                "% Acquired 2023-06-01 T 11:45:30 +0200",
                "% Time (s), Input 1 (V), Input 2 (V)",
            ]
            + rows(", ", t, u, y)
        ),
        E,
        0.001,
        V(u),
        V(y),
        "Moku: names in % lines; what the inputs are stands only in comments",
        "refuse: meaning only in free comments",
        chk=pdcsv(1, 2, 0, comment="%", header=None),
    )
    # Red Pitaya
    r = rec(0.001, 1, 0, 0.8)
    add(
        "52_rp_stream.csv",
        "redpitaya",
        text(["CH1,CH2"] + rows(",", S("%.6f", r.u), S("%.6f", r.y))),
        X,
        None,
        [],
        [],
        "Red Pitaya: CH1, CH2, no time and no rate",
    )
    # LabOne
    r = rec(0.001, 1, 0, 0.8)
    add(
        "53_dev3456_demods_0_sample_r_avg_00000.csv",
        "labone",
        text(
            ["chunk;timestamp;value"]
            + rows(";", ["0"] * r.n, ["%d" % (81234567890 + i * 60000) for i in range(r.n)], ["%.15g" % v for v in r.y])
        ),
        X,
        None,
        [],
        [],
        "LabOne: a single demodulator signal, ticks of unknown clock, no input",
    )
    # Saleae
    r = rec(0.0008, 5, 0, 4.4)
    t, u, y = S("%.9f", r.t), S("%.15f", r.u), S("%.15f", r.y)
    add(
        "54_analog.csv",
        "saleae",
        text(["Time [s],Piezo command,Displacement"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "Saleae analog.csv with renamed channels, no units except time",
        chk=pdcsv(1, 2, 0, float_precision="round_trip"),
    )


scopes()


# =========================================================================== recorders and controllers
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


recorders()


# =========================================================================== free style CSV, readable
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
    # long header
    r = rec(0.001, 100, 0, 9)
    t, u, y = C(S("%.3f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", r.y))
    hd = [
        "Prüfstand 4",
        "Datum;14.02.2023;",
        "Uhrzeit;10:22:31;",
        "Bediener;Hr. Müller;",
        "Messrate;1000;Hz",
        "Kanäle;2;",
        "Kalibrierung;1,0002;0,9998",
        "Offset;0,0013;-0,0210",
        "Grenzen U;-20;120",
        "Grenzen s;0;30",
        "",
    ]
    hd += [
        "Parameter %02d;%s;%s" % (i, ("%.3f" % (i * 1.7)).replace(".", ","), ("%.3f" % (i * 0.3)).replace(".", ","))
        for i in range(1, 46)
    ]
    hd += ["1;2;3", "Messzeit;Piezospannung;Messweg", "s;V;µm"]
    add(
        "92_langer_kopf.csv",
        "csv-odd",
        text(hd + rows(";", t, u, y), "cp1252", "\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "60 header lines with three fields and numbers, a column number row 1;2;3 just before names and units",
        chk=pdcsv(1, 2, 0, sep=";", decimal=",", encoding="cp1252", skiprows=len(hd), header=None),
    )
    # names with commas
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "93_comma_names.csv",
        "csv-odd",
        text(
            ['"Time, relative [s]","Voltage, drive [V]","Displacement, measured; filtered [µm]"'] + rows(",", t, u, y)
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "quoted names with commas and a semicolon",
        chk=pdcsv(1, 2, 0),
    )
    # duplicate time
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "94_dup_time.csv",
        "csv-odd",
        text(["Time,Voltage,Time,Displacement", "s,V,s,um"] + rows(",", t, u, t, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "two equal time columns with the same name",
        chk=pdcsv(1, 3, 0, skiprows=2, header=None),
    )
    # 24 columns
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    nm = [
        "Time [s]",
        "T_amb [°C]",
        "T_stack [°C]",
        "T_amp [°C]",
        "RH [%]",
        "p_amb [hPa]",
        "I_piezo [mA]",
        "F_preload [N]",
        "F_load [N]",
        "a_base [m/s²]",
        "Status",
        "Trigger",
        "Alarm",
        "Cycle",
        "Piezo voltage [V]",
        "P [W]",
        "Energy [J]",
        "Strain SG1 [µm/m]",
        "Strain SG2 [µm/m]",
        "Displacement [µm]",
        "Velocity [µm/s]",
        "Freq [Hz]",
        "Phase [deg]",
        "Supply current [A]",
        "Counter",
    ]
    g = r.g
    fill = {
        1: S("%.2f", g.normal(22, 0.1, r.n)),
        2: S("%.2f", g.normal(31, 0.1, r.n)),
        3: S("%.2f", g.normal(40, 0.1, r.n)),
        4: S("%.1f", g.normal(45, 0.2, r.n)),
        5: S("%.1f", g.normal(1001, 0.1, r.n)),
        6: S("%.3f", np.gradient(r.u)),
        7: S("%.2f", g.normal(200, 0.1, r.n)),
        8: S("%.2f", 3 * r.y),
        9: S("%.4f", g.normal(0, 0.1, r.n)),
        10: ["0"] * r.n,
        11: ["1" if i % 50 == 0 else "0" for i in range(r.n)],
        12: ["0"] * r.n,
        13: [str(i // 100) for i in range(r.n)],
        15: S("%.4f", r.u * np.gradient(r.u) / 1e3),
        16: S("%.5f", r.u**2 / 1e5),
        17: S("%.2f", r.y * 50),
        18: S("%.2f", r.y * 49),
        20: S("%.3f", np.gradient(r.y, r.ts)),
        21: ["12.5"] * r.n,
        22: S("%.2f", np.full(r.n, 3.2)),
        23: S("%.3f", g.normal(1.2, 0.01, r.n)),
        24: [str(i) for i in range(r.n)],
    }
    cols = [t if i == 0 else u if i == 14 else y if i == 19 else fill[i] for i in range(25)]
    add(
        "95_25_columns.csv",
        "csv-many",
        text([",".join(nm)] + rows(",", *cols), bom=BOM),
        E,
        r.ts,
        V(u),
        V(y),
        "25 columns of which two matter (strain, velocity, supply current, counter as bait)",
        chk=pdcsv(14, 19, 0, encoding="utf-8-sig"),
    )
    # controller names
    r = rec(0.0005, 100, 0, 9)
    t, u, y = S("%.4f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "96_Regler.csv",
        "csv-many",
        text(
            ["t [s];Sollwert [µm];Istwert [µm];Regelabweichung [µm];Stellgröße [V]"]
            + rows(";", t, S("%.4f", r.y + 0.01), y, ["0.0100"] * r.n, u)
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "German controller words: set value, actual value, error, actuating variable",
        chk=pdcsv(4, 2, 0, sep=";"),
    )
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "97_setpoint.csv",
        "csv-many",
        text(
            ["Time (s),Setpoint (um),Measured position (um),Piezo voltage (V)"]
            + rows(",", t, S("%.4f", r.y * 1.01), y, u)
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "set point and measured position both in um",
        chk=pdcsv(3, 2, 0),
    )
    # case sensitive t/T, U/I/F
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "98_formelzeichen.csv",
        "csv-many",
        text(
            ["T [°C];t [s];U [V];I [mA];x [µm];F [N];v [mm/s]"]
            + rows(
                ";",
                S("%.2f", 22 + 0 * r.u),
                t,
                u,
                S("%.3f", np.gradient(r.u)),
                y,
                S("%.2f", 200 + r.u),
                S("%.4f", np.gradient(r.y)),
            )
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "one-letter symbols: T and t, U, v [mm/s] beside",
        chk=pdcsv(2, 4, 1, sep=";"),
    )
    # DIN style t/ms U/V s/µm
    r = rec(0.001, 100, 0, 9)
    t, u, y = C(S("%.1f", r.t * 1e3)), C(S("%.3f", r.u)), C(S("%.4f", r.y))
    add(
        "99_DIN.txt",
        "csv-units",
        text(["t/ms\tU/V\ts/µm"] + rows("\t", t, u, y)),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "unit after a slash; s is the path in um, not seconds",
        chk=pdcsv(1, 2, 0, 1e-3, sep="\t", decimal=","),
    )
    # sensor in volts
    r = rec(0.001, 10, 0, 9.2)
    t, u, y = S("%.3f", r.t), S("%.4f", r.u), S("%.4f", r.y)
    add(
        "100_sensor_volts.csv",
        "csv-units",
        text(["Time [s],Amp input [V],Cap sensor out [V]"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "both in V, names clear",
        chk=pdcsv(1, 2, 0),
    )
    # kV and micro-inch style
    r = rec(0.002, 1.0, 0, 62)
    t, u, y = S("%.3f", r.t), S("%.5f", r.u), S("%.3f", r.y)
    add(
        "101_HV_kV.csv",
        "csv-units",
        text(["TIME_S,U_HV_KV,TIP_DEFLECTION_UM"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "all upper case; kV; deflection",
        chk=pdcsv(1, 2, 0),
    )
    # small jitter
    r = rec(0.01, 5, 0, 9)
    tt = np.round(r.t + r.g.uniform(-1.5e-4, 1.5e-4, r.n), 6)
    t, u, y = S("%.6f", tt), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "102_python_logger.csv",
        "csv-time",
        text(["elapsed_s,voltage_V,position_um"] + rows(",", t, u, y)),
        E,
        (tt[-1] - tt[0]) / (r.n - 1),
        V(u),
        V(y),
        "software-timed log, jitter 1.5 % of the step",
        chk=pdcsv(1, 2, 0),
    )
    # ISO date and elapsed both; NaN in an unneeded channel
    r = rec(0.05, 100, 0, 9)
    iso = [
        (dt.datetime(2023, 12, 31, 23, 59, 55) + dt.timedelta(milliseconds=50 * i)).strftime("%Y-%m-%d %H:%M:%S")
        for i in range(r.n)
    ]
    t, u, y = S("%.2f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "103_iso_and_elapsed.csv",
        "csv-time",
        text(
            ["DateTime,Elapsed (s),Temperature (C),Piezo (V),Displacement (um)"]
            + rows(",", iso, t, ["NaN" if i % 20 else "22.4" for i in range(r.n)], u, y)
        ),
        E,
        0.05,
        V(u),
        V(y),
        "date and time only to whole seconds beside an exact elapsed column; NaN in temperature",
        chk=pdcsv(3, 4, 1),
    )
    # a single NaN in y
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    y[97] = "NaN"
    y[98] = "NaN"
    add(
        "104_two_nan.csv",
        "csv-missing",
        text(["time_s,voltage_V,disp_um"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        [float(s) for s in y],
        "two NaN in y (null in the truth; filling between neighbours is fine)",
        "refuse: missing values in y",
        chk=None,
    )
    # last line cut
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "105_last_line_cut.csv",
        "csv-missing",
        text(["time (s),voltage (V),disp (um)"] + rows(",", t, u, y) + ["%.3f,3" % (r.n * r.ts)], final=False),
        E,
        r.ts,
        V(u),
        V(y),
        "last line cut after one and a half fields; all lines before are whole",
        "refuse: cut",
        chk=pdcsv(1, 2, 0, nrows=r.n),
    )
    # xlsx named csv done later; markdown-ish pipes
    r = rec(0.001, 100, 0, 9)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "106_pipes.txt",
        "csv-odd",
        text(["Time (s)|Voltage (V)|Displacement (µm)"] + rows("|", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "pipe as separator",
        chk=pdcsv(1, 2, 0, sep="|"),
    )


freestyle()


# =========================================================================== binary formats, readable
def binary():
    from scipy.io import savemat, loadmat, netcdf_file
    import h5py

    # v4
    r = rec(0.001, 100, 0, 9)
    savemat(path("107_v4.mat"), {"t": r.t, "u": r.u, "y": r.y}, format="4")

    def ck(p, U="u", Y="y", T="t"):
        m = loadmat(p)
        return m[U].ravel(), m[Y].ravel(), float(np.mean(np.diff(m[T].ravel())))

    add("107_v4.mat", "mat", None, E, r.ts, r.u, r.y, "MAT v4 with t, u, y", chk=ck)
    # Structure with time
    r = rec(0.0005, 100, 0, 9)
    sig = np.zeros((1, 2), dtype=[("values", "O"), ("dimensions", "O"), ("label", "O"), ("blockName", "O")])
    for k, (v, l) in enumerate(((r.y, "displacement [um]"), (r.u, "piezo voltage [V]"))):
        sig[0, k] = (v[:, None], np.array([[1.0]]), l, "piezo_model/To Workspace")
    savemat(
        path("108_simout.mat"),
        {"simout": {"time": r.t[:, None], "signals": sig, "blockName": "piezo_model/To Workspace"}},
        do_compression=True,
    )

    def ck(p):
        s = loadmat(p)["simout"][0, 0]
        return (
            s["signals"][0, 1]["values"].ravel(),
            s["signals"][0, 0]["values"].ravel(),
            float(np.mean(np.diff(s["time"].ravel()))),
        )

    add(
        "108_simout.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "Simulink Structure With Time, labels in signals(k).label, output first",
        chk=ck,
    )
    # timeseries-like
    r = rec(0.001, 100, 0, 9)
    mk = lambda n, v, un: {
        "Name": n,
        "Time": r.t[:, None],
        "Data": v[:, None],
        "DataInfo": {"Units": un},
        "TimeInfo": {"Units": "seconds", "Start": 0.0},
    }
    savemat(
        path("109_timeseries.mat"), {"ts_cmd": mk("PiezoCommand", r.u, "V"), "ts_pos": mk("StagePosition", r.y, "um")}
    )

    def ck(p):
        m = loadmat(p)
        return (
            m["ts_cmd"][0, 0]["Data"].ravel(),
            m["ts_pos"][0, 0]["Data"].ravel(),
            float(np.mean(np.diff(m["ts_cmd"][0, 0]["Time"].ravel()))),
        )

    add(
        "109_timeseries.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "timeseries turned into structs, each with its own time, units nested",
        chk=ck,
    )
    # dataset-like
    r = rec(0.002, 100, 0, 9)
    el = np.empty((1, 3), dtype=object)
    for k, (n, v) in enumerate((("u_piezo", r.u), ("temp_stack", 25 + 0 * r.u), ("y_disp", r.y))):
        el[0, k] = {"Name": n, "BlockPath": "ctrl/" + n, "Values": {"Time": r.t[:, None], "Data": v[:, None]}}
    savemat(
        path("110_logsout.mat"),
        {"logsout": {"Name": "logsout", "numElements": 3.0, "elements": el}, "Ts": 0.002},
        do_compression=True,
    )

    def ck(p):
        e = loadmat(p)["logsout"][0, 0]["elements"]
        return e[0, 0]["Values"][0, 0]["Data"][0, 0].ravel(), e[0, 2]["Values"][0, 0]["Data"][0, 0].ravel(), 0.002

    add(
        "110_logsout.mat",
        "mat-simulink",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "Dataset-like: cell of structs with Name and Values",
        chk=ck,
    )
    # dSPACE rec
    r = rec(0.001, 10, 0, 20)
    Y = np.zeros(
        (1, 2), dtype=[("Name", "O"), ("Type", "O"), ("Data", "O"), ("Unit", "O"), ("XIndex", "O"), ("Path", "O")]
    )
    Y[0, 0] = (
        '"Model Root"/"Sensor"/"Position"/"Out1"',
        4.0,
        r.y[None, :].astype(np.float64),
        "um",
        1.0,
        "Model Root/Sensor/Position",
    )
    Y[0, 1] = ('"Model Root"/"DAC"/"Piezo voltage"/"In1"', 4.0, r.u[None, :], "V", 1.0, "Model Root/DAC/Piezo voltage")
    Xs = np.zeros((1, 1), dtype=[("Name", "O"), ("Type", "O"), ("Data", "O"), ("Unit", "O")])
    Xs[0, 0] = ("time", 4.0, r.t[None, :], "s")
    savemat(
        path("111_rec1_042.mat"),
        {
            "rec1_042": {
                "X": Xs,
                "Y": Y,
                "Description": {"General": {"Version": 2.1, "DateTime": "11-Mar-2022 09:12:13"}},
                "RTProgram": "piezo_ctrl.sdf",
                "Capture": {"Length": 0.5, "SamplingPeriod": 0.001},
            }
        },
    )

    def ck(p):
        m = loadmat(p)["rec1_042"][0, 0]
        return (
            m["Y"][0, 1]["Data"].ravel(),
            m["Y"][0, 0]["Data"].ravel(),
            float(np.mean(np.diff(m["X"][0, 0]["Data"].ravel()))),
        )

    add(
        "111_rec1_042.mat",
        "dspace",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "dSPACE ControlDesk mat: X, Y(k).Name paths with quotes",
        chk=ck,
    )
    # Fs scalar
    r = rec(1 / 8000.0, 10, 0, 20)
    savemat(
        path("112_fs.mat"),
        {
            "Fs": 8000.0,
            "u": r.u[:, None],
            "y": r.y[:, None],
            "ref": np.round(r.y, 1)[:, None],
            "gain": 15.0,
            "operator": "mk",
            "units": "V, um",
        },
        do_compression=True,
    )
    add(
        "112_fs.mat",
        "mat",
        None,
        E,
        1 / 8000.0,
        r.u,
        r.y,
        "u, y and scalar Fs; reference of the same length beside",
        chk=lambda p: (loadmat(p)["u"].ravel(), loadmat(p)["y"].ravel(), 1 / float(loadmat(p)["Fs"][0, 0])),
    )
    # v7.3
    r = rec(0.0005, 100, 0, 9)
    p = path("113_v73.mat")
    with h5py.File(p, "w", userblock_size=512) as f:
        f.attrs  # root
        g = f.create_group("meas")
        g.attrs["MATLAB_class"] = np.bytes_("struct")
        for n, v in (("Time_s", r.t), ("Volt_V", r.u), ("Disp_um", r.y)):
            d = g.create_dataset(n, data=v[None, :])
            d.attrs["MATLAB_class"] = np.bytes_("double")
        d = g.create_dataset("Comment", data=np.frombuffer("stack 3".encode("utf-16-le"), np.uint16)[:, None])
        d.attrs["MATLAB_class"] = np.bytes_("char")
        d.attrs["MATLAB_int_decode"] = np.int32(2)
    with open(p, "r+b") as fh:
        h = b"MATLAB 7.3 MAT-file, Platform: PCWIN64, Created on: Wed Mar 01 10:10:10 2023 HDF5 schema 1.00 ."
        fh.write(h.ljust(116) + b"\0" * 8 + b"\x00\x02IM")
    add(
        "113_v73.mat",
        "mat",
        None,
        E,
        r.ts,
        r.u,
        r.y,
        "MAT v7.3 (HDF5 with userblock), struct, column vectors stored 1xN",
        chk=lambda p: (
            lambda f: (
                f["meas/Volt_V"][:].ravel(),
                f["meas/Disp_um"][:].ravel(),
                float(np.mean(np.diff(f["meas/Time_s"][:].ravel()))),
            )
        )(h5py.File(p, "r")),
    )
    # numpy
    r = rec(0.001, 100, 0, 9)
    a = np.zeros(r.n, dtype=[("timestamp_ns", "i8"), ("pzt_V", "f4"), ("disp_nm", "f8")])
    a["timestamp_ns"] = np.arange(r.n) * 1000000 + 1700000000000000000
    a["pzt_V"] = r.u
    a["disp_nm"] = r.y * 1000
    np.save(path("114_struct.npy"), a)
    add(
        "114_struct.npy",
        "numpy",
        None,
        E,
        0.001,
        a["pzt_V"].astype(float),
        a["disp_nm"],
        "structured npy; nanosecond epoch in int64; float32 voltage",
        chk=lambda p: (np.load(p)["pzt_V"].astype(float), np.load(p)["disp_nm"], 0.001),
    )
    r = rec(0.0004, 100, 0, 9)
    np.savez(path("115_run.npz"), dt=0.0004, voltage=r.u, displacement=r.y, meta=np.array("P-885.51"))
    add(
        "115_run.npz",
        "numpy",
        None,
        E,
        0.0004,
        r.u,
        r.y,
        "npz with dt and two named arrays",
        chk=lambda p: (np.load(p)["voltage"], np.load(p)["displacement"], float(np.load(p)["dt"])),
    )
    r = rec(1 / 25e3, 100, 0, 9)
    np.savez_compressed(
        path("116_run_fs.npz"),
        fs_Hz=np.array([25000]),
        V_drive=r.u[:, None],
        x_um=r.y[:, None],
        x_ref_um=r.y[:, None] * 1.02,
        trigger=np.zeros((r.n, 1), bool),
    )
    add(
        "116_run_fs.npz",
        "numpy",
        None,
        E,
        1 / 25e3,
        r.u,
        r.y,
        "npz, fs_Hz as array of one, column vectors, reference beside",
        chk=lambda p: (np.load(p)["V_drive"].ravel(), np.load(p)["x_um"].ravel(), 1 / 25e3),
    )
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
    # many segments + string channel group
    r = rec(0.001, 100, 0, 12, n=360)
    with TdmsWriter(path("124_segments.tdms")) as w:
        w.write_segment(
            [RootObject(), GroupObject("Events"), ChannelObject("Events", "Text", ["start", "ramp", "stop"])]
        )
        for k in range(0, 360, 45):
            w.write_segment(
                [
                    GroupObject("Messung"),
                    ChannelObject(
                        "Messung", "Piezospannung", r.u[k : k + 45], {"wf_increment": 0.001, "unit_string": "V"}
                    ),
                    ChannelObject("Messung", "Weg", r.y[k : k + 45], {"wf_increment": 0.001, "unit_string": "µm"}),
                ]
            )
    add(
        "124_segments.tdms",
        "tdms",
        None,
        E,
        0.001,
        r.u,
        r.y,
        "TDMS in eight segments, a group with a text channel before, German names",
        chk=lambda p: (TdmsFile.read(p)["Messung"]["Piezospannung"][:], TdmsFile.read(p)["Messung"]["Weg"][:], 0.001),
    )

    # xlsx
    import openpyxl

    r = rec(0.001, 100, 0, 12)
    wb = openpyxl.Workbook()
    ws = wb.active
    ws.title = "Info"
    for z in (("Prüfling", "P-888.91"), ("Datum", dt.date(2023, 3, 1)), ("Abtastrate", "1 kHz"), ("Umax", 100)):
        ws.append(z)
    ws = wb.create_sheet("Messdaten")
    ws.append(["Piezoaktor Kennlinie"])
    ws.append([])
    ws.append(["Zeit", "Spannung", "Weg", "Bemerkung"])
    ws.append(["s", "V", "µm", None])
    tv, uv, yv = [round(float(v), 6) for v in r.t], [round(float(v), 4) for v in r.u], [round(float(v), 5) for v in r.y]
    for i in range(r.n):
        ws.append([tv[i], uv[i], yv[i], "Start" if i == 0 else None])
    wb.create_sheet("Tabelle3")
    wb.save(path("125_Kennlinie.xlsx"))

    def ckx(p, sheet, r0, cu, cy):
        w = openpyxl.load_workbook(p)[sheet]
        d = list(w.iter_rows(min_row=r0, values_only=True))
        return np.array([a[cu] for a in d], float), np.array([a[cy] for a in d], float), None

    add(
        "125_Kennlinie.xlsx",
        "xlsx",
        None,
        E,
        0.001,
        uv,
        yv,
        "info sheet first, empty sheet last, title and units rows, a remark in one cell",
        chk=lambda p: ckx(p, "Messdaten", 5, 1, 2),
    )
    r = rec(0.02, 100, 0, 12)
    wb = openpyxl.Workbook()
    ws = wb.active
    ws.append(["Elapsed", "Drive (V)", "Displacement (um)"])
    uv, yv = [round(float(v), 3) for v in r.u], [round(float(v), 4) for v in r.y]
    for i in range(r.n):
        ws.append([i * 0.02 / 86400, uv[i], yv[i]])
        ws.cell(i + 2, 1).number_format = "mm:ss.000"
    wb.save(path("126_elapsed_cells.xlsx"))
    add(
        "126_elapsed_cells.xlsx",
        "xlsx",
        None,
        E,
        0.02,
        uv,
        yv,
        "time cells are Excel times (fractions of a day, format mm:ss.000)",
        chk=lambda p: ckx(p, "Sheet", 2, 1, 2),
    )
    # xlsx named csv
    r = rec(0.001, 100, 0, 12)
    wb = openpyxl.Workbook()
    ws = wb.active
    ws.append(["Time (s)", "Voltage (V)", "Displacement (um)"])
    tv, uv, yv = [round(float(v), 6) for v in r.t], [round(float(v), 3) for v in r.u], [round(float(v), 4) for v in r.y]
    for z in zip(tv, uv, yv):
        ws.append(z)
    wb.save(path("tmp.xlsx"))
    os.rename(path("tmp.xlsx"), path("127_export.csv"))
    add(
        "127_export.csv",
        "wrong-extension",
        None,
        E,
        0.001,
        uv,
        yv,
        "an xlsx workbook named .csv",
        "refuse: ending and content differ",
    )
    import pandas as pd

    r = rec(0.001, 100, 0, 12)
    tv, uv, yv = [round(float(v), 6) for v in r.t], [round(float(v), 3) for v in r.u], [round(float(v), 4) for v in r.y]
    pd.DataFrame({"Zeit (s)": tv, "Spannung (V)": uv, "Hub (µm)": yv}).to_excel(
        path("128_calc.ods"), engine="odf", index=False
    )
    add(
        "128_calc.ods",
        "ods",
        None,
        E,
        0.001,
        uv,
        yv,
        "LibreOffice Calc workbook; Hub (stroke)",
        "refuse: format not supported",
        chk=lambda p: (lambda d: (d.iloc[:, 1].to_numpy(float), d.iloc[:, 2].to_numpy(float), 0.001))(
            pd.read_excel(p, engine="odf")
        ),
    )
    # mf4
    from asammdf import MDF, Signal

    r = rec(0.001, 10, 0, 12)
    m = MDF(version="4.10")
    m.append(
        [
            Signal(r.u, r.t, unit="V", name="Model Root/DAC/u_piezo"),
            Signal(r.y, r.t, unit="um", name="Model Root/ADC/displacement"),
        ],
        comment="ControlDesk",
    )
    m.save(path("129_recording.mf4"), overwrite=True)
    m.close()
    add(
        "129_recording.mf4",
        "mdf4",
        None,
        E,
        0.001,
        r.u,
        r.y,
        "ASAM MDF 4.1 with a master time",
        "refuse: format not supported",
        chk=lambda p: (
            lambda f: (f.get("Model Root/DAC/u_piezo").samples, f.get("Model Root/ADC/displacement").samples, 0.001)
        )(MDF(p)),
    )

    # WAV with INFO
    r = rec(1 / 8000.0, 0.9, 0, 0.7)
    i16 = np.column_stack([np.round(r.u * 32767), np.round(r.y * 32767)]).astype("<i2")

    def wav(data, fs, extra=b""):
        fmt = b"fmt " + struct.pack("<IHHIIHH", 16, 1, 2, fs, fs * 4, 4, 16)
        d = data.tobytes()
        body = b"WAVE" + fmt + extra + b"data" + struct.pack("<I", len(d)) + d
        return b"RIFF" + struct.pack("<I", len(body)) + body

    add(
        "130_soundcard.wav",
        "wav",
        wav(i16, 8000),
        X,
        1 / 8000.0,
        [],
        [],
        "WAV of two channels, nothing says which is what",
    )
    r = rec(1 / 8000.0, 0.9, 0, 0.7)
    i16 = np.column_stack([np.round(r.u * 32767), np.round(r.y * 32767)]).astype("<i2")
    add("131_sound.csv", "wrong-extension", wav(i16, 8000), X, 1 / 8000.0, [], [], "a WAV named .csv, no channel names")


binary()


# =========================================================================== refuse
def refuse():
    from scipy.io import savemat
    import h5py, openpyxl
    from nptdms import TdmsWriter, ChannelObject, GroupObject, RootObject

    r = rec(0.001)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "132_two_voltages_same_name.csv",
        "ambiguous",
        text(["Time (s),Voltage (V),Voltage (V),Displacement (um)"] + rows(",", t, u, S("%.3f", r.u * 0.98 + 0.3), y)),
        X,
        0.001,
        [],
        [],
        "two different channels of the same name Voltage (V)",
    )
    r = rec(0.001)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "133_command_monitor.csv",
        "ambiguous",
        text(
            ["Time (s),Command voltage (V),Monitor voltage (V),Displacement (um)"]
            + rows(",", S("%.3f", r.t), S("%.4f", r.u / 20), S("%.4f", r.u / 20 * 0.99), y)
        ),
        X,
        0.001,
        [],
        [],
        "command and monitor voltage both there",
    )
    r = rec(0.001)
    r2 = rec(0.001, n=r.n)
    add(
        "134_xy_stage.csv",
        "ambiguous",
        text(
            ["t_s,Vx_V,Vy_V,Px_um,Py_um"]
            + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r2.u), S("%.4f", r.y), S("%.4f", r2.y))
        ),
        X,
        0.001,
        [],
        [],
        "two axes, both driven",
    )
    r = rec(0.001)
    add(
        "135_two_sensors.csv",
        "ambiguous",
        text(
            ["Time [s];Piezo [V];Sensor 1 [µm];Sensor 2 [µm]"]
            + rows(";", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y), S("%.4f", r.y * 0.8 + 0.3))
        ),
        X,
        0.001,
        [],
        [],
        "two sensors, neither preferred",
    )
    r = rec(0.001)
    add(
        "136_velocity.csv",
        "no-output",
        text(
            ["Zeit (s);Spannung (V);Geschwindigkeit (mm/s)"]
            + rows(";", C(S("%.3f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", np.gradient(r.y, r.ts) / 1e3)))
        ),
        X,
        0.001,
        [],
        [],
        "velocity, no displacement",
    )
    r = rec(0.001)
    add(
        "137_no_time.csv",
        "no-rate",
        text(["voltage [V],displacement [µm]"] + rows(",", S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "no time and no rate",
    )
    r = rec(0.001)
    add(
        "138_index_only.csv",
        "no-rate",
        text(
            ["# Hysterese Piezo 3, 4.5.2022", "Sample;Spannung (V);Weg (µm)"]
            + rows(";", [str(i) for i in range(r.n)], S("%.3f", r.u), S("%.4f", r.y))
        ),
        X,
        None,
        [],
        [],
        "sample number, rate nowhere",
    )
    r = rec(0.001)
    a = r.n // 2
    tt = r.t.copy()
    tt[a:] += 0.857
    add(
        "139_gap.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.3f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "a gap of 0.857 s in the middle at 1 ms steps",
    )
    r = rec(0.001)
    tt = r.t.copy()
    k = r.n // 2
    tt[k:] -= tt[k]
    add(
        "140_two_runs.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.3f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "two runs in one table, time starts again at 0",
    )
    r = rec(0.01)
    tt = np.cumsum(r.g.exponential(0.01, r.n))
    add(
        "141_random_times.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.5f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "random sampling instants (exponential gaps)",
    )
    r = rec(0.001)
    add(
        "142_time_stuck.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", ["12.000"] * r.n, S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "time is the same in all rows",
    )
    r = rec(0.1)
    iso = [(dt.datetime(2023, 6, 1, 10, 0, 0) + dt.timedelta(seconds=float(v))).strftime("%d.%m.%Y %H:%M") for v in r.t]
    add(
        "143_clock_minutes.csv",
        "bad-time",
        text(["Zeitstempel;Spannung [V];Weg [µm]"] + rows(";", iso, S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "Excel showed the time stamps to minutes only: the step is lost",
    )
    r = rec(0.001)
    add("144_one_column.txt", "no-data", text(S("%.5f", r.y)), X, None, [], [], "one column")
    add("145_empty.csv", "no-data", b"", X, None, [], [], "empty file")
    add(
        "146_header_only.csv",
        "no-data",
        text(["Zeit [s];Spannung [V];Weg [µm]"], "cp1252", "\r\n"),
        X,
        None,
        [],
        [],
        "header only",
    )
    add(
        "147_download.csv",
        "not-data",
        b"<!DOCTYPE html>\n<html><head><title>Login</title></head><body>\n<h1>401 Unauthorized</h1>\n<table><tr><td>1</td><td>2</td><td>3</td></tr></table>\n<p>Session expired, please sign in.</p>\n</body></html>\n"
        * 3,
        X,
        None,
        [],
        [],
        "HTML login page saved as csv",
    )
    add(
        "148_settings.json",
        "not-data",
        json.dumps(
            {
                "sample_rate": 1000,
                "channels": [
                    {"name": "voltage", "unit": "V", "range": [0, 100]},
                    {"name": "displacement", "unit": "um", "range": [0, 12]},
                ],
                "time": "2023-01-01T10:00:00",
            },
            indent=1,
        ).encode(),
        X,
        None,
        [],
        [],
        "JSON settings without data",
    )
    bio = io.BytesIO()
    with zipfile.ZipFile(bio, "w") as z:
        z.writestr("readme.txt", "see run1.csv, run2.csv")
        for k in (1, 2):
            r = rec(0.001)
            z.writestr(
                "run%d.csv" % k, "\n".join(["t_s,u_V,y_um"] + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)))
            )
    add("149_runs.zip", "not-data", bio.getvalue(), X, None, [], [], "zip with two runs")
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig = plt.figure(figsize=(3, 2))
    plt.plot([0, 1], [0, 1])
    plt.savefig(path("tmp.png"), dpi=60)
    plt.close(fig)
    os.rename(path("tmp.png"), path("150_plot.csv"))
    add("150_plot.csv", "not-data", None, X, None, [], [], "a PNG named csv")
    g = np.random.default_rng(1)
    add(
        "151_dump.dat", "not-data", g.integers(0, 256, 9000).astype(np.uint8).tobytes(), X, None, [], [], "random bytes"
    )
    add("152_nulls.csv", "not-data", b"\0" * 12288, X, None, [], [], "preallocated file of NUL bytes after a crash")
    # NULs in the middle
    r = rec(0.001)
    b = text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)))
    k = len(b) // 2
    add(
        "153_nul_block.csv",
        "damaged",
        b[:k] + b"\0" * 1024 + b[k + 1024 :],
        X,
        None,
        [],
        [],
        "a block of 1024 NUL bytes overwrote rows in the middle",
    )
    # comma decimal and comma separator
    r = rec(0.0005)
    add(
        "154_comma_comma.csv",
        "damaged",
        text(["Zeit [s],Spannung [V],Weg [µm]"] + rows(",", C(S("%.4f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", r.y)))),
        X,
        None,
        [],
        [],
        "decimal comma and comma separator without quotes: 3 names, 6 fields",
    )
    # Excel dates
    r = rec(0.001)
    mon = ["Jan", "Feb", "Mrz", "Apr", "Mai", "Jun", "Jul", "Aug", "Sep", "Okt", "Nov", "Dez"]

    def exd(v):
        d, m = int(v), int(round((v - int(v)) * 10))
        return "%02d. %s" % (d, mon[m - 1]) if 1 <= m <= 9 and 1 <= d <= 28 else "%d,%d" % (d, m)

    add(
        "155_excel_dates.csv",
        "damaged",
        text(
            ["Zeit [s];Spannung [V];Weg [µm]"] + rows(";", C(S("%.3f", r.t)), C(S("%.2f", r.u)), [exd(v) for v in r.y]),
            "cp1252",
            "\r\n",
        ),
        X,
        None,
        [],
        [],
        "Excel turned the displacement numbers into dates (03. Mai)",
    )
    # overload text
    r = rec(0.001)
    add(
        "156_overload.csv",
        "damaged",
        text(
            ["Time (s),Voltage (V),Displacement (um)"]
            + rows(",", S("%.3f", r.t), S("%.3f", r.u), ["OVERLOAD" if v > np.median(r.y) else "%.4f" % v for v in r.y])
        ),
        X,
        0.001,
        [],
        [],
        "half of the displacement values are OVERLOAD",
    )
    r = rec(0.001)
    add(
        "157_y_empty.csv",
        "no-output",
        text(["Time (s);Voltage (V);Displacement (um)"] + ["%s;%s;" % z for z in zip(S("%.3f", r.t), S("%.3f", r.u))]),
        X,
        0.001,
        [],
        [],
        "the displacement column is empty",
    )
    r = rec(0.001)
    add(
        "158_contradiction.csv",
        "ambiguous",
        text(["Time [s],Voltage [µm],Displacement [V]"] + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        0.001,
        [],
        [],
        "names and units contradict each other",
    )
    r = rec(0.0005)
    add(
        "159_counts.csv",
        "ambiguous",
        text(
            ["t_ms,adc0,adc1"]
            + rows(",", S("%.1f", r.t * 1e3), ["%d" % v for v in r.u * 40], ["%d" % v for v in r.y * 400])
        ),
        X,
        0.0005,
        [],
        [],
        "two unnamed ADC channels in counts",
    )
    r = rec(0.001)
    r2 = rec(0.001)
    blk = lambda r: ["# t[s] U[V] x[um]"] + rows(" ", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y))
    add(
        "160_two_datasets.dat",
        "ambiguous",
        text(blk(r) + ["", ""] + blk(r2)),
        X,
        0.001,
        [],
        [],
        "gnuplot file with two data sets (index 0 and 1), both from t = 0",
    )
    # npy, mat
    r = rec(0.001)
    np.save(path("161_plain.npy"), np.column_stack([r.t, r.u, r.y]))
    add("161_plain.npy", "numpy", None, X, None, [], [], "plain N x 3 array without names")
    savemat(path("162_matrix.mat"), {"data": np.column_stack([r.t, r.u, r.y])})
    add("162_matrix.mat", "mat", None, X, None, [], [], 'one matrix "data" N x 3 without names')
    r = rec(0.001)
    savemat(path("163_no_rate.mat"), {"u": r.u, "y": r.y, "gain": 15.0, "n": float(r.n)})
    add("163_no_rate.mat", "mat", None, X, None, [], [], "u and y without time or rate")
    r = rec(0.001)
    sg = np.zeros((1, 1), dtype=[("values", "O"), ("dimensions", "O"), ("label", "O")])
    sg[0, 0] = (np.column_stack([r.u, r.y]), np.array([[2.0]]), "")
    savemat(path("164_ScopeData.mat"), {"ScopeData": {"time": r.t[:, None], "signals": sg, "blockName": "model/Scope"}})
    add(
        "164_ScopeData.mat",
        "mat-simulink",
        None,
        X,
        0.001,
        [],
        [],
        "Simulink scope, two unlabelled signals muxed in one matrix",
    )
    r = rec(0.001, n=380)
    savemat(path("tmp.mat"), {"t": r.t, "u": r.u, "y": r.y}, do_compression=True)
    b = open(path("tmp.mat"), "rb").read()
    os.remove(path("tmp.mat"))
    add("165_truncated.mat", "damaged", b[: len(b) * 2 // 3], X, None, [], [], "MAT v7 cut at two thirds")
    with TdmsWriter(path("166_two_runs.tdms")) as w:
        ch = []
        for k in (1, 2):
            r = rec(0.001)
            ch += [
                GroupObject("Run %d" % k),
                ChannelObject("Run %d" % k, "Voltage", r.u, {"wf_increment": 0.001, "unit_string": "V"}),
                ChannelObject("Run %d" % k, "Displacement", r.y, {"wf_increment": 0.001, "unit_string": "um"}),
            ]
        w.write_segment([RootObject()] + ch)
    add("166_two_runs.tdms", "tdms", None, X, 0.001, [], [], "two groups with the same channels: which run?")
    r = rec(0.001)
    with TdmsWriter(path("167_no_rate.tdms")) as w:
        w.write_segment(
            [
                RootObject(),
                GroupObject("Untitled"),
                ChannelObject("Untitled", "Voltage (V)", r.u),
                ChannelObject("Untitled", "Displacement (um)", r.y),
            ]
        )
    add("167_no_rate.tdms", "tdms", None, X, None, [], [], "TDMS without wf_increment and time")
    r = rec(0.001)
    with TdmsWriter(path("tmp.tdms")) as w:
        w.write_segment(
            [
                RootObject(),
                GroupObject("G"),
                ChannelObject("G", "Voltage", r.u, {"wf_increment": 0.001, "unit_string": "V"}),
                ChannelObject("G", "Displacement", r.y, {"wf_increment": 0.001, "unit_string": "um"}),
            ]
        )
    b = open(path("tmp.tdms"), "rb").read()
    os.remove(path("tmp.tdms"))
    for q in os.listdir(OUT):
        if q.endswith("tdms_index"):
            os.remove(path(q))
    add("168_truncated.tdms", "damaged", b[: len(b) - r.n * 5], X, 0.001, [], [], "TDMS cut inside the second channel")
    r = rec(0.001)
    r2 = rec(0.001, n=r.n)
    with h5py.File(path("169_xy.h5"), "w") as f:
        f.attrs["fs"] = 1000.0
        for n, v, un in (
            ("x/voltage", r.u, "V"),
            ("x/displacement", r.y, "um"),
            ("y/voltage", r2.u, "V"),
            ("y/displacement", r2.y, "um"),
        ):
            f.create_dataset(n, data=v).attrs["unit"] = un
    add("169_xy.h5", "hdf5", None, X, 0.001, [], [], "HDF5 with two axes")
    b = open(path("117_daq.h5"), "rb").read()
    add("170_truncated.h5", "damaged", b[: len(b) * 3 // 5], X, None, [], [], "HDF5 cut at 60 %")
    wb = openpyxl.Workbook()
    for k in (1, 2):
        r = rec(0.001)
        ws = wb.active if k == 1 else wb.create_sheet()
        ws.title = "Messung %d" % k
        ws.append(["Zeit [s]", "Spannung [V]", "Weg [µm]"])
        for z in zip(r.t, r.u, r.y):
            ws.append([round(float(v), 5) for v in z])
    wb.save(path("171_zwei_Messungen.xlsx"))
    add("171_zwei_Messungen.xlsx", "xlsx", None, X, 0.001, [], [], "two sheets with equally good runs")
    b = open(path("171_zwei_Messungen.xlsx"), "rb").read()
    add("172_truncated.xlsx", "damaged", b[: len(b) // 2], X, None, [], [], "xlsx cut in half")
    r = rec(0.001)
    add(
        "173_ai.csv",
        "ambiguous",
        text(["Time (s),Dev1/ai0 (V),Dev1/ai1 (V)"] + rows(",", S("%.3f", r.t), S("%.5f", r.u / 10), S("%.5f", r.y))),
        X,
        0.001,
        [],
        [],
        "NI device channels ai0 and ai1, both V",
    )
    r = rec(0.001)
    add(
        "174_force.csv",
        "no-output",
        text(
            ["Time (s),Piezo voltage (V),Blocking force (N),Temperature (°C)"]
            + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r.y * 80), S("%.2f", 22 + 0 * r.u))
        ),
        X,
        0.001,
        [],
        [],
        "blocking force, no displacement",
    )


refuse()

# --------------------------------------------------------------------------- write truth, verify
for q in list(os.listdir(OUT)):
    if q.endswith(".tdms_index"):
        os.remove(path(q))
names = [e["file"] for e in TRUTH]
assert len(set(names)) == len(names)
extra = set(os.listdir(OUT)) - set(names)
assert not extra, extra
with open(OUT + "/truth.json", "w") as fh:
    json.dump(TRUTH, fh, ensure_ascii=False, allow_nan=False, indent=None)

if "--check" in sys.argv:
    import re

    def lines(p, enc="utf-8"):
        return re.split("\r\n|\r|\n", open(p, "rb").read().decode(enc))

    num = lambda a: np.array([float(x) for x in a])

    def c_igor(p):
        L = lines(p)
        d = [l.split() for l in L[L.index("BEGIN") + 1 : L.index("END")]]
        return num([a[0] for a in d]), num([a[1] for a in d]), None

    def c_oct(p):
        B = open(p).read().split("# name: ")[1:]
        v = {b.split()[0]: num(b.split("columns: 1")[1].split()) for b in B}
        return v["u"], v["y"], np.mean(np.diff(v["t"]))

    def c_kv(p):
        d = re.findall("millis=(.*)\tdac_V=(.*)\tpos_um=(.*)", open(p).read())
        return num([a[1] for a in d]), num([a[2] for a in d]), (float(d[-1][0]) - float(d[0][0])) / (len(d) - 1) / 1e3

    def c_long(p):
        import pandas as pd

        d = pd.read_csv(p).pivot(index="time_s", columns="channel", values="value")
        return d["piezo_voltage"].to_numpy(), d["displacement"].to_numpy(), np.mean(np.diff(d.index))

    def c_tr(p):
        d = [num(l.split(",")[1:]) for l in lines(p)[:3]]
        return d[1], d[2], np.mean(np.diff(d[0]))

    def c_nox(p):
        d = [l.split("\t")[1:] for l in lines(p) if re.match("\t[-0-9]", l)]
        return num([a[-1] for a in d]), num([a[-2] for a in d]), None

    def c_seg(p):
        d = [l.split("\t")[1:] for l in lines(p) if re.match("\t[-0-9]", l)]
        return num([a[0] for a in d]), num([a[1] for a in d]), None

    def c_gl(p):
        d = [l.replace(" ", "").split(",") for l in lines(p)[16:] if l]
        return num([a[3] for a in d]), num([a[4] for a in d]), np.mean(np.diff(num([a[2] for a in d]))) / 1e3

    def c_fort(p):
        d = [num([l[i : i + 15].replace("D", "e") for i in (0, 15, 30)]) for l in lines(p)[1:] if l]
        d = np.array(d)
        return d[:, 1], d[:, 2], (d[-1, 0] - d[0, 0]) / (len(d) - 1)

    def c_rep(p):
        d = np.array([num(l.split(",")) for l in lines(p) if l and l[0] != "T"])
        return d[:, 1], d[:, 2], np.mean(np.diff(d[:, 0]))

    def c_127(p):
        import openpyxl

        d = np.array(list(openpyxl.load_workbook(open(p, "rb")).active.iter_rows(min_row=2, values_only=True)), float)
        return d[:, 1], d[:, 2], np.mean(np.diff(d[:, 0]))

    CHECKS += [
        ("20_igor.itx", c_igor),
        ("24_octave.txt", c_oct),
        ("25_serial_monitor.log", c_kv),
        ("26_influx_long.csv", c_long),
        ("27_transposed.csv", c_tr),
        ("30_nox.lvm", c_nox),
        ("31_segments.lvm", c_seg),
        ("56_220519-132007.CSV", c_gl),
        ("74_NEWPORT.PRN", c_fort),
        ("88_repeated_header.csv", c_rep),
        ("127_export.csv", c_127),
    ]
    by = {e["file"]: e for e in TRUTH}
    bad = 0
    for name, f in CHECKS:
        e = by[name]
        try:
            u, y, ts = f(path(name))
            ok = (
                len(u) == len(e["u"])
                and np.array_equal(np.asarray(u, float), np.array(e["u"]))
                and np.array_equal(np.asarray(y, float), np.array(e["y"]))
            )
            if not ok and len(u) == len(e["u"]):
                d = max(np.max(np.abs(np.asarray(u, float) - e["u"])), np.max(np.abs(np.asarray(y, float) - e["y"])))
                ok = d < 1e-9 * max(np.ptp(e["y"]), np.ptp(e["u"]))
                if ok:
                    pass
            if ts is not None and abs(ts / e["ts"] - 1) > 1e-6:
                ok = False
                print("ts", name, ts, e["ts"])
            if not ok:
                bad += 1
                print("DIFF", name, len(u), len(e["u"]))
        except Exception as ex:
            bad += 1
            print("ERR", name, repr(ex)[:200])
    nr = sum(e["expect"] == "read" for e in TRUTH)
    chk = {n for n, _ in CHECKS}
    print(
        len(TRUTH),
        "files;",
        nr,
        "read;",
        len(TRUTH) - nr,
        "refuse;",
        sum(bool(e["also_ok"]) for e in TRUTH),
        "also_ok;",
        len(CHECKS),
        "checked; bad",
        bad,
    )
    print("read but unchecked:", [e["file"] for e in TRUTH if e["expect"] == "read" and e["file"] not in chk])
