"""CSV as found, part 2: headers, columns, gaps and time columns.

Nobody documents these files. They are what people get from small scripts,
loggers and spreadsheets, in English, German and French.
"""
from datetime import datetime, timedelta

from common import Ch, record, rows

V = Ch("Voltage (V)", "Voltage", "V")
D = Ch("Displacement (um)", "Displacement", "um")
HEAD = "Time (s),Voltage (V),Displacement (um)"
START = datetime(2024, 3, 5, 14, 7, 9)


def text(name, **kw):
    ts = kw.pop("ts", 0.0005)
    return record(name, ts).text(**kw)


def simple(b, name, head, u, y, why, order="tuy", sep=",", dec=".",
           enc="utf-8", **kw):
    """Header lines, then three columns in the given order."""
    d = text(name, **kw)
    body = rows([getattr(d, c) for c in order], sep, dec)
    b.lines(name, head + body, enc)
    b.read(name, d, u, y, why, "a script")


def header_styles(b):
    simple(b, "csv_unit_row.csv",
           ["Time,Voltage,Displacement", "s,V,um"],
           Ch("Voltage", unit="V"), Ch("Displacement", unit="um"),
           "second row holds the units")
    simple(b, "csv_unit_row_brackets.csv",
           ["Time;Voltage;Displacement", "[ms];[V];[nm]"],
           Ch("Voltage", unit="V"), Ch("Displacement", unit="nm"),
           "unit row in brackets; time in ms", sep=";", ft="%.1f", kt=1e3,
           ky=1e3, fy="%.2f")
    simple(b, "csv_two_header_rows.csv",
           ["Timer,Amplifier,Sensor", "t,u_out,x_cap", "s,V,um"],
           Ch("u_out", unit="V"), Ch("x_cap", unit="um"),
           "a row of groups above the names and the units")
    simple(b, "csv_units_slash.csv", ["t/s;U/V;x/µm"], Ch("U/V", "U", "V"),
           Ch("x/µm", "x", "µm"), "unit after a slash (DIN 1313)", sep=";")
    simple(b, "csv_units_comma.csv",
           ['"Time, s","Voltage, V","Displacement, um"'],
           Ch("Voltage, V", "Voltage", "V"),
           Ch("Displacement, um", "Displacement", "um"),
           "a comma inside the quoted names")
    simple(b, "csv_upper_case.csv", ["TIME,VOLTAGE,DISPLACEMENT"],
           Ch("VOLTAGE"), Ch("DISPLACEMENT"), "upper case, no units")
    simple(b, "csv_mixed_case.csv", ["tIme_S,Piezo_VOLTAGE_v,position_UM"],
           Ch("Piezo_VOLTAGE_v", "Piezo_VOLTAGE", "v"),
           Ch("position_UM", "position", "UM"), "case of units is wrong")
    simple(b, "csv_kilovolt_nm.csv", ["t (s),HV (kV),Displacement (nm)"],
           Ch("HV (kV)", "HV", "kV"),
           Ch("Displacement (nm)", "Displacement", "nm"),
           "units kV and nm", ku=1e-3, fu="%.6f", ky=1e3, fy="%.1f")


def languages(b):
    simple(b, "csv_german.csv", ["Zeit;Spannung;Weg"], Ch("Spannung"),
           Ch("Weg"), "German names, decimal comma, no units", sep=";",
           dec=",")
    simple(b, "csv_french_cp1252.csv", ["Temps;Tension;Déplacement"],
           Ch("Tension"), Ch("Déplacement"),
           "French names in cp1252, decimal comma", sep=";", dec=",",
           enc="cp1252")
    simple(b, "csv_french_utf8.csv",
           ["Temps (s);Tension (V);Déplacement (µm)"],
           Ch("Tension (V)", "Tension", "V"),
           Ch("Déplacement (µm)", "Déplacement", "µm"),
           "French names in UTF-8", sep=";", dec=",")


def orders(b):
    simple(b, "csv_y_before_u.csv", ["time_s,displacement_um,voltage_V"],
           Ch("voltage_V", "voltage", "V"),
           Ch("displacement_um", "displacement", "um"),
           "output stands before input", order="tyu")
    simple(b, "csv_time_last.csv",
           ["Displacement (um)\tVoltage (V)\tTime (s)"], V, D,
           "time is the last column, tabs", order="yut", sep="\t")


def comments(b):
    note = ["piezo stack, run 7", "amplifier gain 10, date 2024-03-05",
            "room 23.4 C, 2 cables"]
    simple(b, "csv_hash_comments.csv", ["# " + n for n in note] + [HEAD], V,
           D, "comment lines with numbers and commas before the header")
    simple(b, "csv_percent_comments.txt",
           ["%% " + note[0], "% " + note[1],
            "% time [s]   voltage [V]   displacement [um]"],
           Ch("voltage [V]", "voltage", "V"),
           Ch("displacement [um]", "displacement", "um"),
           "MATLAB comments; the last one holds the names", sep="   ")
    name = "csv_key_value_head.csv"
    simple(b, name, ["Operator: N.N.", "Sample: PZT-5H, 18 mm",
                     "Sample rate: 2000 Hz", "", HEAD], V, D,
           "free text lines without a comment sign before the header")
    name = "csv_footer.csv"
    d = text(name)
    b.lines(name, [HEAD] + rows([d.t, d.u, d.y])
            + ["", "Mean,21.3,2.4", "End of data"])
    b.read(name, d, V, D, "a summary and a closing line after the data",
           "a script")


def extra_columns(b):
    name = "csv_extra_columns.csv"
    d = text(name)
    trig = ["%d" % (i >= 20) for i in range(len(d.t))]
    temp = ["%.2f" % (23.4 + 1e-4 * i) for i in range(len(d.t))]
    b.lines(name, ["time_s,trigger,temperature_C,voltage_V,displacement_um,"
                   "comment"]
            + rows([d.t, trig, temp, d.u, d.y, ["ok"] * len(d.t)]))
    b.read(name, d, Ch("voltage_V", "voltage", "V"),
           Ch("displacement_um", "displacement", "um"),
           "trigger, temperature and a text column besides", "a script")


def setpoints(b):
    name = "csv_setpoint_measured.csv"
    d = text(name)
    setp = ["%.4f" % (0.11 * float(v)) for v in d.u]
    b.lines(name, ["time_s,setpoint_um,measured_um,voltage_V"]
            + rows([d.t, setp, d.y, d.u]))
    b.read(name, d, Ch("voltage_V", "voltage", "V"),
           Ch("measured_um", "measured", "um"),
           "two columns in um: the set point is not the output", "a script")
    name = "csv_command_and_monitor.csv"
    d = text(name)
    cmd = ["%.5f" % (0.1 * float(v)) for v in d.u]
    b.lines(name, ["time_s,command_V,hv_monitor_V,position_um"]
            + rows([d.t, cmd, d.u, d.y]))
    b.refuse(name, "two inputs in V: amplifier command and HV monitor",
             ["which channel is the input"], "a script", data=d,
             u=Ch("hv_monitor_V", "hv_monitor", "V"),
             y=Ch("position_um", "position", "um"))
    name = "csv_two_actuators.csv"
    d = text(name)
    u2, y2 = d.u[::-1], d.y[::-1]
    b.lines(name, ["t (s),U1 (V),x1 (um),U2 (V),x2 (um)"]
            + rows([d.t, d.u, d.y, u2, y2]))
    b.refuse(name, "two actuators in one file", ["which pair is meant"],
             "a script", data=d, u=Ch("U1 (V)", "U1", "V"),
             y=Ch("x1 (um)", "x1", "um"))
    simple(b, "csv_drive_sensor_volts.csv",
           ["Time (s),Drive (V),Position sensor (V)"],
           Ch("Drive (V)", "Drive", "V"),
           Ch("Position sensor (V)", "Position sensor", "V"),
           "output is a sensor voltage; its scale is not in the file",
           ky=0.1, fy="%.5f")


def no_header(b):
    for n, cols in ((2, "uy"), (3, "tuy")):
        name = "csv_no_header_%dcol.csv" % n
        d = text(name)
        b.lines(name, rows([getattr(d, c) for c in cols]))
        needs = ["which column is the input and which the output", "units"]
        needs += ["sampling period"] if n == 2 else []
        b.refuse(name, "%d columns of numbers and no names" % n, needs,
                 "a script", data=d, ts=None if n == 2 else d.ts)


def gaps(b):
    cases = (("nan", {30: "NaN", 31: "nan"}),
             ("empty_cells", {12: "", 13: "", 80: ""}),
             ("over_na", {45: "OVER", 46: "OVER", 90: "#N/A"}),
             ("dashes", {10: "---", 100: "---"}))
    for tag, marks in cases:
        name = "csv_gap_%s.csv" % tag
        d = text(name)
        for i, mark in marks.items():
            d.y[i] = mark
        b.lines(name, [HEAD] + rows([d.t, d.u, d.y]))
        b.read(name, d, V, D, "no number in rows %s of the output: %s" % (
               sorted(marks), sorted(set(marks.values()))), "a script",
               gaps=sorted(marks), also_ok="refuse and name the rows")


def stamps(b, name, fmt, cut, ts, why):
    """Time stamps in the first column. cut: digits dropped at the end."""
    d = text(name, ts=ts)
    when = [(START + timedelta(seconds=i * ts)).strftime(fmt)
            for i in range(len(d.t))]
    if cut:
        when = [w[:-cut] for w in when]
    b.lines(name, ["Timestamp,Voltage (V),Displacement (um)"]
            + rows([when, d.u, d.y]))
    return d


def timestamps(b):
    cases = (("csv_iso_ms.csv", "%Y-%m-%dT%H:%M:%S.%f", 3, 0.01,
              "ISO 8601 with ms"),
             ("csv_iso_us.csv", "%Y-%m-%d %H:%M:%S.%f", 0, 0.0005,
              "ISO 8601 with a blank and microseconds"),
             ("csv_iso_zone.csv", "%Y-%m-%dT%H:%M:%S.%f+01:00", 0, 0.0005,
              "ISO 8601 with a time zone"))
    for name, fmt, cut, ts, why in cases:
        d = stamps(b, name, fmt, cut, ts, why)
        b.read(name, d, V, D, why, "a script")
    name = "csv_iso_too_coarse.csv"
    d = stamps(b, name, "%Y-%m-%dT%H:%M:%S.%f", 3, 0.0005, "")
    b.refuse(name, "stamps have 1 ms steps, samples come every 0.5 ms: each "
             "stamp appears twice", ["sampling period"], "a script", data=d,
             u=V, y=D, ts=None, also_ok="read with the mean period 0.0005")
    name = "csv_clock_midnight.csv"
    d = text(name)
    day = datetime(2024, 3, 5, 23, 59, 59, 950000)
    when = [(day + timedelta(seconds=i * d.ts)).strftime("%H:%M:%S.%f")
            for i in range(len(d.t))]
    b.lines(name, ["Clock,Voltage (V),Displacement (um)"]
            + rows([when, d.u, d.y]))
    b.read(name, d, V, D, "clock time passes midnight", "a script")


def time_units(b):
    simple(b, "csv_time_ms.csv", ["Time (ms),Voltage (V),Displacement (um)"],
           V, D, "time in ms", kt=1e3, ft="%.1f")
    simple(b, "csv_time_us.csv", ["time_us,Voltage (V),Displacement (um)"],
           V, D, "time in whole microseconds", kt=1e6, ft="%.0f")
    name = "csv_sample_rate_comment.csv"
    d = text(name)
    num = ["%d" % i for i in range(len(d.t))]
    body = rows([num, d.u, d.y])
    head = "sample,Voltage (V),Displacement (um)"
    b.lines(name, ["# sampling rate: 2000 Hz", head] + body)
    b.read(name, d, V, D, "sample numbers; the rate is in a comment",
           "a script")
    name = "csv_sample_number.csv"
    d = text(name)
    num = ["%d" % (i + 1) for i in range(len(d.t))]
    b.lines(name, [head] + rows([num, d.u, d.y]))
    b.refuse(name, "sample numbers and no rate", ["sampling period"],
             "a script", data=d, u=V, y=D, ts=None)
    name = "csv_time_jump.csv"
    d = text(name)
    late = ["%.4f" % (float(t) + (0.3 if i >= 60 else 0))
            for i, t in enumerate(d.t)]
    b.lines(name, [HEAD] + rows([late, d.u, d.y]))
    b.refuse(name, "time jumps by 0.3 s after row 60: samples are lost",
             ["which part to use"], "a script", data=d, u=V, y=D)


def make(b):
    for f in (header_styles, languages, orders, comments, extra_columns,
              setpoints, no_header, gaps, timestamps, time_units):
        f(b)
