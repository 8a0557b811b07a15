"""Text: numbers and clocks of countries and programs."""

import datetime as dt

from common import *

H = "Time (s),Voltage (V),Displacement (um)"


def std(name, *a, ft="%.4f", fu="%.5f", fy="%.5f", **k):
    r = Rec(name, *a, **k)
    return r, S(r.t, ft), S(r.u, fu), S(r.y, fy)


# ---- numbers
def ungroup(th, dec):
    return lambda d: d.map(lambda x: float(str(x).replace(th, "").replace(dec, ".")))


@case(
    "de_points_grouped.csv",
    "locale",
    "German: decimal comma with grouping points (12.345,67), units row with an empty cell, time in ms.",
    check=ck(0, 2, 3, 1e-3, sep=";", skiprows=3, dtype=str, fix=lambda d: ungroup(".", ",")(d)),
)
def _(p):
    r, t, u, y = std("de1", 1e-2, 900, 15000, ft="%.4f", fy="%.2f")
    t = S(r.t * 1e3, "%.1f")
    c = lambda s: group(s, ".", ",")
    wr(
        p,
        ["Messprotokoll Stapelaktor 7", "Zeit;Nr;Spannung;Auslenkung", "ms;;V;nm"]
        + rows(c(t), [str(i) for i in range(r.n)], c(u), c(y), sep=";"),
        nl="\r\n",
    )
    return ok(1e-2, V(u), V(y))


@case(
    "ch_apostrophe.csv",
    "locale",
    "Swiss grouping with apostrophe (12'345.67).",
    check=ck(0, 1, 2, sep=";", skiprows=1, dtype=str, fix=lambda d: ungroup("'", ".")(d)),
)
def _(p):
    r, t, u, y = std("ch", 1e-3, 1450, 15000, fy="%.2f")
    c = lambda s: group(s, "'", ".")
    wr(p, ["Zeit [s];Spannung [mV];Weg [nm]"] + rows(t, c(u), c(y), sep=";"))
    return ok(1e-3, V(u), V(y))


@case(
    "fr_nnbsp.csv",
    "locale",
    "French: narrow no-break space as grouping (12 345,67), decimal comma.",
    check=ck(0, 1, 2, sep=";", skiprows=1, dtype=str, fix=lambda d: ungroup("\u202f", ",")(d)),
)
def _(p):
    r, t, u, y = std("fr", 1e-3, 1450, 15000, fy="%.2f")
    c = lambda s: group(s, "\u202f", ",")
    wr(p, ["Temps (s);Tension (mV);Déplacement (nm)"] + rows(comma(t), c(u), c(y), sep=";"), nl="\r\n")
    return ok(1e-3, V(u), V(y))


@case(
    "us_quoted_grouped.csv",
    "locale",
    'US: grouped numbers with decimals in quotes only where they reach 1000 ("12,345.67").',
    check=ck(0, 1, 2, skiprows=1, thousands=","),
)
def _(p):
    r, t, u, y = std("us", 1e-3, 1450, 15000, fy="%.2f")
    q = lambda s: [f'"{x}"' if "," in x else x for x in group(s, ",", ".")]
    wr(p, ["Time (s),Voltage (mV),Displacement (nm)"] + rows(t, q(u), q(y)))
    return ok(1e-3, V(u), V(y))


@case(
    "de_three_decimals.csv",
    "locale",
    "Semicolon and comma with exactly three decimals (12,345): 0,001 in the time column shows that the comma is decimal.",
    check=ck(0, 1, 2, sep=";", decimal=",", skiprows=1),
)
def _(p):
    r, t, u, y = std("de3", 1e-3, 100, 12, ft="%.3f", fu="%.3f", fy="%.3f")
    wr(p, ["Zeit (s);Spannung (V);Weg (um)"] + rows(comma(t), comma(u), comma(y), sep=";"))
    return ok(1e-3, V(u), V(y))


@refuse(
    "ambiguous_grouping.csv",
    "locale",
    "Tab-separated; voltage and displacement only as d,ddd or dd,ddd, time in whole ms: the comma may be decimal or grouping (factor 1000).",
)
def _(p):
    r = Rec("amb", 1, 90000, 40000)
    g = lambda a: group(S(np.abs(a) + 1100, "%.0f"), ",", ".")
    wr(p, ["Time (ms)\tVoltage (mV)\tDisplacement (nm)"] + rows(S(r.k, "%d"), g(r.u), g(r.y), sep="\t"))


@case(
    "fortran_d_exponent.txt",
    "locale",
    "Fortran exponents (1.25D+01) in fixed columns, names after a #.",
    check=lambda p: tuple(
        pd.read_csv(p, sep=r"\s+", comment="#", header=None, dtype=str)
        .map(lambda x: float(x.replace("D", "E")))
        .iloc[:, c]
        .to_numpy()
        for c in range(3)
    ),
)
def _(p):
    r = Rec("fort", 5e-4, 100, 12)
    t, u, y = (S(a, "%15.8E") for a in (r.t, r.u, r.y))
    wr(p, ["#     time_s        voltage_V        displ_um"] + [x.replace("E", "D") for x in rows(t, u, y, sep=" ")])
    return ok(5e-4, V(u), V(y))


@case(
    "unicode_minus_ramp.csv",
    "locale",
    "Negative-going ramp written with the Unicode minus U+2212.",
    check=ck(0, 1, 2, skiprows=1, dtype=str, fix=lambda d: d.map(lambda x: float(x.replace("\u2212", "-")))),
)
def _(p):
    r = Rec("umin", 1e-3, -80, 9)
    t, u, y = S(r.t, "%.3f"), S(r.u, "%.4f"), S(r.y, "%.4f")
    m = lambda s: [x.replace("-", "\u2212") for x in s]
    wr(p, [H] + rows(t, m(u), m(y)))
    return ok(1e-3, V(u), V(y))


@refuse(
    "decimal_mark_changes.csv",
    "damaged",
    "Decimal mark changes from point to comma in the middle of the file (two PCs).",
)
def _(p):
    r, t, u, y = std("dmc", 1e-3)
    h = r.n // 2
    R = rows(t, u, y, sep=";")
    wr(p, [H.replace(",", ";")] + R[:h] + comma(R[h:]))


# ---- clocks
def clock_mmss(s):
    return [60 * float(x.split(":")[0]) + float(x.split(":")[1]) for x in s]


@case(
    "clock_mmss.csv",
    "clock",
    "Excel clock mm:ss.0 with 0.5 s steps that pass full minutes.",
    check=ckt(clock_mmss, 1, 2, skiprows=1),
)
def _(p):
    r, _, u, y = std("mmss", 0.5, 100, 12)
    s = 192.5 + r.t
    wr(
        p,
        ["Time,Voltage (V),Displacement (um)"] + rows([f"{int(v // 60):02d}:{v % 60:04.1f}" for v in s], u, y),
        nl="\r\n",
    )
    return ok(0.5, V(u), V(y))


@case(
    "clock_ampm_noon.csv",
    "clock",
    "Clock times with AM/PM that pass noon (11:59:59.5 AM, 12:00:00.0 PM).",
    check=ckt(
        lambda s: (pd.to_datetime(s, format="%I:%M:%S.%f %p") - pd.Timestamp("1900-01-01")).dt.total_seconds(),
        1,
        2,
        skiprows=1,
    ),
)
def _(p):
    r, _, u, y = std("ampm", 0.5, 100, 12, n=300)
    b = dt.datetime(2024, 5, 2, 11, 58, 40)
    tt = [b + dt.timedelta(milliseconds=500 * k) for k in range(r.n)]
    wr(
        p,
        ["Time of day,Voltage (V),Displacement (um)"]
        + rows([f"{(x.hour - 1) % 12 + 1}:{x:%M:%S}.{x.microsecond // 100000} {x:%p}" for x in tt], u, y),
    )
    return ok(0.5, V(u), V(y))


@case(
    "clock_iso_dst.csv",
    "clock",
    "ISO times with zone across the change to summer time: the wall clock jumps one hour, the instants do not.",
    check=ckt(
        lambda s: (
            pd.to_datetime(s, utc=True).astype("int64").to_numpy()
            * {"ns": 1e-9, "us": 1e-6, "ms": 1e-3}[pd.to_datetime(s, utc=True).dt.unit]
        ),
        1,
        2,
        skiprows=1,
    ),
    tstol=1e-5,
)
def _(p):
    r, _, u, y = std("dst", 0.01, 100, 12, n=260)
    b = dt.datetime(2024, 3, 31, 0, 59, 58, 700000)
    o = []
    for k in range(r.n):
        z = b + dt.timedelta(milliseconds=10 * k)
        h = 2 if z >= dt.datetime(2024, 3, 31, 1) else 1
        o.append((z + dt.timedelta(hours=h)).isoformat(timespec="milliseconds") + f"+0{h}:00")
    wr(p, ["timestamp,voltage_V,displacement_um"] + rows(o, u, y))
    return ok(0.01, V(u), V(y))


@case(
    "clock_epoch_ns.csv",
    "clock",
    "Unix time in ns as 19-digit integers, 100 µs steps, first column a row index without name.",
    check=ck(1, 2, 3, 1e-9, skiprows=1, fix=lambda d: _rel(d)),
)
def _(p):
    r, _, u, y = std("ns", 1e-4, 100, 12)
    t = [str(1714637472123456000 + 100000 * k) for k in range(r.n)]
    wr(p, [",timestamp_ns,voltage_V,displacement_um"] + rows([str(k) for k in range(r.n)], t, u, y))
    return ok(1e-4, V(u), V(y))


def _rel(d):
    d[1] = d[1] - d[1].iloc[0]
    return d


@case(
    "matlab_writetimetable.csv",
    "MATLAB text",
    "writetimetable: row times as durations with text ('0.0005 sec').",
    check=ckt(lambda s: [float(x.split()[0]) for x in s], 1, 2, skiprows=1),
)
def _(p):
    r, _, u, y = std("wtt", 5e-4, 100, 12, fu="%.12g", fy="%.12g")
    wr(p, ["Time,Voltage_V,Displacement_um"] + rows(["%.10g sec" % v for v in r.t], u, y))
    return ok(5e-4, V(u), V(y))


@refuse(
    "matlab_datetime_seconds.csv",
    "MATLAB text",
    "writetable wrote datetime with whole seconds at about 100 Hz (the count per second varies): the period is not known.",
)
def _(p):
    r, _, u, y = std("wdt", 1 / 97.3)
    b = dt.datetime(2024, 5, 2, 10, 11, 12)
    wr(
        p,
        ["Time,Voltage_V,Displacement_um"]
        + rows([(b + dt.timedelta(seconds=int(v + 0.37))).strftime("%d-%b-%Y %H:%M:%S") for v in r.t], u, y),
    )


@refuse(
    "time_reversed.csv",
    "damaged",
    "Time runs backwards: rows were sorted or the file reversed; hysteresis would be read in the wrong sense.",
)
def _(p):
    r, t, u, y = std("rev", 1e-3)
    wr(p, [H] + rows(t, u, y)[::-1])


@refuse("rate_changes.csv", "damaged", "The time step changes from 1 ms to 2 ms half way.")
def _(p):
    r, t, u, y = std("rc", 1e-3)
    h = r.n // 2
    tt = np.concatenate([r.t[:h], r.t[h] + 2e-3 * np.arange(r.n - h)])
    wr(p, [H] + rows(S(tt, "%.4f"), u, y))


@refuse("dropped_block.csv", "damaged", "37 rows in the middle were lost: the time column jumps once.")
def _(p):
    r, t, u, y = std("drop", 1e-3, n=300)
    R = rows(t, u, y)
    wr(p, [H] + R[:120] + R[157:])


@refuse("rate_header_contradicts.csv", "damaged", "The header says 10 kHz, the time column in s has 1 ms steps.")
def _(p):
    r, t, u, y = std("rhc", 1e-3)
    wr(p, ["# Sampling rate: 10000 Hz", H] + rows(t, u, y))
