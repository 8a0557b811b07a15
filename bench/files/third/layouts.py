"""Text: encodings, what stands above, between and below the rows, and which columns there are."""

import base64

from common import *

H = "Time (s),Voltage (V),Displacement (um)"


def std(name, *a, ft="%.4f", fu="%.5f", fy="%.5f", **k):
    r = Rec(name, *a, **k)
    return r, S(r.t, ft), S(r.u, fu), S(r.y, fy)


# ---- encodings
@case(
    "utf16be.txt",
    "encoding",
    "UTF-16 big endian with byte order mark, tabs (Excel 'Unicode text' of an old Mac).",
    check=ck(0, 1, 2, sep="\t", skiprows=1, encoding="utf-16"),
)
def _(p):
    r, t, u, y = std("u16", 1e-3)
    L = "\ufeffTime (s)\tVoltage (V)\tDisplacement (µm)\r\n" + "\r\n".join(rows(t, u, y, sep="\t")) + "\r\n"
    wr(p, L, enc="utf-16-be")
    return ok(1e-3, V(u), V(y))


@case(
    "cp1251_ru.csv",
    "encoding",
    "cp1251: 'Время, с;Напряжение, В;Перемещение, мкм' with decimal comma.",
    check=ck(0, 1, 2, sep=";", decimal=",", skiprows=1, encoding="cp1251"),
)
def _(p):
    r, t, u, y = std("ru", 1e-3)
    wr(
        p,
        ["Время, с;Напряжение, В;Перемещение, мкм"] + rows(comma(t), comma(u), comma(y), sep=";"),
        enc="cp1251",
        nl="\r\n",
    )
    return ok(1e-3, V(u), V(y))


@case(
    "gbk_cn.csv",
    "encoding",
    "GBK: 序号,时间(ms),位移(μm),电压(V): index first, displacement before voltage.",
    check=ck(1, 3, 2, 1e-3, skiprows=1, encoding="gbk"),
)
def _(p):
    r, _, u, y = std("cn", 2e-3)
    t = S(r.t * 1e3, "%.1f")
    wr(p, ["序号,时间(ms),位移(μm),电压(V)"] + rows([str(k + 1) for k in range(r.n)], t, y, u), enc="gbk", nl="\r\n")
    return ok(2e-3, V(u), V(y))


@case(
    "macroman_fr.txt",
    "encoding",
    "Mac Roman (é is 0x8E) with CR line ends and decimal comma.",
    check=ck(0, 1, 2, sep="\t", decimal=",", skiprows=1, encoding="mac_roman", lineterminator="\r"),
)
def _(p):
    r, t, u, y = std("mac", 1e-3)
    wr(
        p,
        ["Temps (s)\tTension appliquée (V)\tDéplacement (µm)"] + rows(comma(t), comma(u), comma(y), sep="\t"),
        enc="mac_roman",
        nl="\r",
    )
    return ok(1e-3, V(u), V(y))


# ---- preambles, tables around, comments
@case(
    "preamble_base64.csv",
    "preamble",
    "A base64 screenshot of about 120 KB on one line stands before the columns.",
    check=ck(0, 1, 2, skiprows=5),
)
def _(p):
    r, t, u, y = std("b64", 1e-3)
    b = base64.b64encode(r.g.bytes(90000)).decode()
    wr(p, ["Instrument,DAQ-9", "Screenshot,data:image/png;base64," + b, "Operator,mk", "", H] + rows(t, u, y))
    return ok(1e-3, V(u), V(y))


@case(
    "preamble_4000_comments.csv",
    "preamble",
    "4000 comment lines with numbers (an instrument state dump) before the columns, > 64 KB.",
    check=ck(0, 1, 2, skiprows=4001),
)
def _(p):
    r, t, u, y = std("cmt", 1e-3)
    wr(p, [f"# reg 0x{k:04x}, {k * 7 % 991}, {k * 0.013:.3f}, {k % 5}" for k in range(4000)] + [H] + rows(t, u, y))
    return ok(1e-3, V(u), V(y))


@case(
    "calibration_table_first.csv",
    "preamble",
    "A calibration table (V, um; 20 rows) with its own header stands before the record.",
    check=ck(0, 1, 2, skiprows=26),
)
def _(p):
    r, t, u, y = std("cal", 1e-3)
    wr(
        p,
        ["Actuator,P-840.20", "Static calibration 2023-11-02", "Voltage (V),Displacement (um)"]
        + [f"{5 * k:.1f},{0.612 * k + 0.004 * k * k:.3f}" for k in range(20)]
        + ["", "Dynamic record", H]
        + rows(t, u, y),
    )
    return ok(1e-3, V(u), V(y))


@case(
    "footer_statistics.csv",
    "footer",
    "Statistics lines Mean/Std/Min/Max after an empty line, with numbers under the columns.",
    check=lambda p: ck(0, 1, 2, skiprows=1, nrows=sum(1 for _ in open(p)) - 6)(p),
)
def _(p):
    r, t, u, y = std("foot", 1e-3)
    f = lambda n, g: f"{n},{g(r.u):.5f},{g(r.y):.5f}"
    wr(p, [H] + rows(t, u, y) + ["", f("Mean", np.mean), f("Std", np.std), f("Min", np.min), f("Max", np.max)])
    return ok(1e-3, V(u), V(y))


@case(
    "footer_peak_table.csv",
    "footer",
    "After the data a table of loop peaks with the same number of columns, all cells numbers, under its own header.",
    check=lambda p: ck(0, 1, 2, skiprows=1, nrows=sum(1 for _ in open(p)) - 7)(p),
)
def _(p):
    r, t, u, y = std("peak", 1e-3)
    wr(
        p,
        [H]
        + rows(t, u, y)
        + ["", "Summary", "Cycle,U peak (V),y peak (um)", "1,50.1,5.9", "2,75.2,8.8", "3,100.0,11.7"],
    )
    return ok(1e-3, V(u), V(y))


@case(
    "comments_between.csv",
    "comments",
    "Comment lines and blank lines between data rows; time goes on evenly.",
    check=ck(0, 1, 2, skiprows=1, comment="#"),
)
def _(p):
    r, t, u, y = std("cb", 1e-3)
    o = [H]
    for k, x in enumerate(rows(t, u, y)):
        if k and k % 50 == 0:
            o += ["", f"# T = {22 + k / 1000:.3f} degC at row {k}"]
        o.append(x)
    wr(p, o)
    return ok(1e-3, V(u), V(y))


@case(
    "note_column.csv",
    "comments",
    "A last column with free text in three rows only, with a quoted comma in it.",
    check=ck(0, 1, 2, skiprows=1),
)
def _(p):
    r, t, u, y = std("note", 1e-3)
    R = [x + "," for x in rows(t, u, y)]
    R[0] += '"start, cold"'
    R[90] += "door slammed"
    R[-1] += "end"
    wr(p, [H + ",Note"] + R)
    return ok(1e-3, V(u), V(y))


@refuse(
    "two_runs_appended.csv", "damaged", "A second run with its own header was appended; its time starts again at zero."
)
def _(p):
    a, b = std("run1", 1e-3, n=160), std("run2", 1e-3, 70, 8, n=160)
    wr(p, [H] + rows(*a[1:]) + [H] + rows(*b[1:]))


@refuse(
    "two_runs_time_continues.csv",
    "damaged",
    "A second run (own header, new actuator) appended with a time column that goes on evenly: the join is a false record.",
)
def _(p):
    a, b = std("run1c", 1e-3, n=160), std("run2c", 1e-3, 70, 8, n=160, t0=0.160)
    wr(p, ["Actuator: S1", H] + rows(*a[1:]) + ["", "Actuator: S2", H] + rows(*b[1:]))


# ---- columns
@case(
    "wide_320_columns.csv",
    "columns",
    "323 named columns; voltage and displacement are at 201 and 77, beside temperatures and strains.",
    check=lambda p: (lambda d: (d["time_s"], d["piezo_voltage_V"], d["displacement_um"]))(pd.read_csv(p)),
)
def _(p):
    r, t, u, y = std("wide", 1e-2, n=150)
    cols = [(f"tc{k:03d}_degC", S(20 + r.g.normal(0, 0.1, r.n), "%.2f")) for k in range(160)] + [
        (f"sg{k:03d}_ustrain", S(r.g.normal(0, 5, r.n), "%.1f")) for k in range(160)
    ]
    cols.insert(0, ("time_s", t))
    cols.insert(77, ("displacement_um", y))
    cols.insert(201, ("piezo_voltage_V", u))
    wr(p, [",".join(c[0] for c in cols)] + rows(*[c[1] for c in cols]))
    return ok(1e-2, V(u), V(y))


@case(
    "trigger_temperature.csv",
    "columns",
    "Trigger columns of 0/1, a temperature with '---' in every second row, raw counts beside the displacement in um.",
    check=lambda p: (lambda d: (d["t [s]"], d["Drive [V]"], d["Displacement [um]"]))(pd.read_csv(p)),
)
def _(p):
    r, t, u, y = std("trig", 1e-3)
    tr = ["1" if k % 40 < 2 else "0" for k in r.k]
    tc = ["---" if k % 2 else "22.%d" % (k % 7) for k in r.k]
    wr(
        p,
        ["t [s],Trig in,T [degC],Drive [V],Sensor raw [counts],Displacement [um],Trig out"]
        + rows(t, tr, tc, u, S(r.y * 2730 + 1200, "%.0f"), y, tr[::-1]),
    )
    return ok(1e-3, V(u), V(y))


@case(
    "setpoint_and_measured.csv",
    "columns",
    "Set and measured voltage, commanded and actual position beside each other: the measured ones are meant.",
    also_ok="refuse: two voltages",
    check=lambda p: (lambda d: (d.iloc[:, 0], d.iloc[:, 2], d.iloc[:, 4]))(pd.read_csv(p)),
)
def _(p):
    r, t, u, y = std("sp", 1e-3)
    wr(
        p,
        ["Time (s),Voltage setpoint (V),Voltage measured (V),Position setpoint (um),Position measured (um)"]
        + rows(t, S(np.round(r.u / 0.5) * 0.5 + 1, "%.5f"), u, S(r.u * 0.12, "%.5f"), y),
    )
    return ok(1e-3, V(u), V(y))


@case(
    "units_kV_mm.txt",
    "columns",
    "Voltage in kV, displacement in mm, blanks as separators, units on a line of their own; time starts at 3600 s.",
    check=ck(0, 1, 2, sep=r"\s+", skiprows=3),
)
def _(p):
    r = Rec("kv", 1e-3, 1.5, 0.18, t0=3600)
    t, u, y = S(r.t, "%12.3f"), S(r.u, "%12.6f"), S(r.y, "%12.7f")
    wr(
        p,
        ["HV stack test", "        time      voltage displacement", "           s           kV           mm"]
        + rows(t, u, y, sep=" "),
    )
    return ok(1e-3, V(u), V(y))


@refuse(
    "two_sensors.csv",
    "columns",
    "Two displacement sensors without any word which is the reference: two records are possible.",
)
def _(p):
    r, t, u, y = std("2s", 1e-3)
    wr(p, ["Time (s),Voltage (V),Displacement 1 (um),Displacement 2 (um)"] + rows(t, u, y, S(r.y * 0.93 + 0.2, "%.5f")))


@refuse("dac_counts.csv", "columns", "The drive is only given as a 16-bit DAC code without scale: no voltage.")
def _(p):
    r, t, u, y = std("dac", 1e-3)
    wr(p, ["Time (s),DAC code (counts),Displacement (um)"] + rows(t, S(np.clip(r.u, 0, None) * 436.9, "%.0f"), y))


@refuse(
    "no_header_y_first.txt", "columns", "Three number columns without names: displacement first, but nothing says so."
)
def _(p):
    r, t, u, y = std("nh", 1e-3)
    wr(p, rows(y, u, t, sep="\t"))


@refuse(
    "runs_side_by_side.csv",
    "columns",
    "Two runs side by side under the same names: duplicate columns with different values.",
)
def _(p):
    a, b = std("ss1", 1e-3, n=200), std("ss2", 1e-3, 70, 8, n=200)
    wr(p, [",".join([H, H])] + rows(*a[1:], *b[1:]))


@refuse("gap_ind.csv", "gap", "1.#IND and OVER stand in rows of the used displacement column.")
def _(p):
    r, t, u, y = std("gap", 1e-3)
    y[70] = y[71] = "1.#IND"
    y[130] = "OVER"
    wr(p, [H] + rows(t, u, y))


@refuse("gap_dashes_last.csv", "gap", "'---' in the voltage of five rows in the middle and in none of the others.")
def _(p):
    r, t, u, y = std("gap2", 1e-3)
    for k in range(100, 105):
        u[k] = "---"
    wr(p, [H] + rows(t, u, y))


@refuse(
    "mixed_column_counts.csv",
    "damaged",
    "From row 90 a fourth column was inserted after the time (logger reconfigured), names unchanged.",
)
def _(p):
    r, t, u, y = std("mcc", 1e-3)
    R = rows(t, u, y)
    R[90:] = rows(t[90:], S(22 + 0 * r.t[90:], "%.1f"), u[90:], y[90:])
    wr(p, [H] + R)
