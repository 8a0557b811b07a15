"""Text with long heads, and headers in words."""

from common import *


def long_heads():
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
