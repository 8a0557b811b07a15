"""Sensors, and programs beside them."""

from common import *


@case(
    "thorlabs_quoted.csv",
    "Thorlabs",
    "Quoted column names that hold commas ('Time, s').",
    check=ck(0, 1, 2, skiprows=3),
)
def _(p):
    r = Rec("thor", 1e-2, 75, 20)
    t, u, y = S(r.t, "%.3f"), S(r.u, "%.4f"), S(r.y, "%.4f")
    wr(
        p,
        [
            '"KPZ101 29501234, KSG101 59001234"',
            '"Exported 5/2/2024 10:11:12 AM"',
            '"Time, s","Output voltage, V","Strain gauge position, µm"',
        ]
        + rows(t, u, y),
        nl="\r\n",
    )
    return ok(1e-2, V(u), V(y))


@case(
    "polytec_velocity.txt",
    "Polytec",
    "Polytec: a velocity column named V in mm/s beside the voltage U; units line '[ s ]'; displacement in m.",
    check=ck(0, 1, 3, sep="\t", skiprows=7),
)
def _(p):
    r = Rec("poly", 2e-5, 20, 3e-6)
    t, u, y = S(r.t, "%.6e"), S(r.u, "%.8e"), S(r.y, "%.8e")
    v = S(np.gradient(r.y, r.ts) * 1e3, "%.6e")
    wr(
        p,
        [
            "Source File Name:\tC:\\Polytec\\stack.pvd",
            "Point Index:\t1",
            "Usr Signal: Vib & Ref1",
            "Component: Single Point",
            "",
            "Time\tU\tV\tD",
            "[ s ]\t[ V ]\t[ mm/s ]\t[ m ]",
        ]
        + rows(t, u, v, y, sep="\t"),
        nl="\r\n",
    )
    return ok(2e-5, V(u), V(y))


@case(
    "keyence_sjis.csv",
    "Keyence",
    "Shift-JIS: Japanese names, time in ms, displacement in μm, an output-judgement column HI/GO/LO as text.",
    check=ck(0, 1, 2, 1e-3, skiprows=3, encoding="shift_jis"),
)
def _(p):
    r = Rec("key", 2e-4, 130, 16)
    t, u, y = S(r.t * 1e3, "%.1f"), S(r.u, "%.3f"), S(r.y, "%.4f")
    j = ["HI" if v > 9 else "GO" if v > 2 else "LO" for v in r.y]
    wr(
        p,
        ["LK-Navigator2 データ収集", "サンプリング周期,200μs", "時間[ms],印加電圧[V],変位[μm],判定"] + rows(t, u, y, j),
        enc="shift_jis",
        nl="\r\n",
    )
    return ok(2e-4, V(u), V(y))


@case(
    "microepsilon_de.csv",
    "Micro-Epsilon",
    "cp1252, title lines, decimal comma, 'Messrate;2,5 kHz', time in ms, distance in µm named Abstand before the voltage.",
    check=ck(0, 2, 1, 1e-3, sep=";", decimal=",", skiprows=6, encoding="cp1252"),
)
def _(p):
    r = Rec("me", 4e-4, 100, 25)
    t, u, y = S(r.t * 1e3, "%.1f"), S(r.u, "%.4f"), S(r.y + 180, "%.4f")
    wr(
        p,
        [
            "capaNCDT 6200 – Messwertdatei",
            "Seriennr.;1234567",
            "Messrate;2,5 kHz",
            "Messbereich;500 µm",
            "",
            "Zeit [ms];Abstand Kanal 1 [µm];Aktorspannung [V]",
        ]
        + rows(comma(t), comma(y), comma(u), sep=";"),
        enc="cp1252",
        nl="\r\n",
    )
    return ok(4e-4, V(u), V(y))


@case(
    "sios_grouped_rate.txt",
    "SIOS",
    "No time column; the rate stands as 'Messfrequenz: 5.000,0 Hz' with German grouping (5000 Hz, not 5 Hz).",
    check=ck(None, 0, 1, sep="\t", decimal=",", skiprows=6, encoding="cp1252"),
    tsrx=(r"Messfrequenz: (\S+) Hz", lambda x: 1 / DEC(x.replace(".", ""))),
)
def _(p):
    r = Rec("sios", 2e-4, 100, 12000)
    u, y = S(r.u, "%.4f"), S(r.y, "%.2f")
    wr(
        p,
        [
            "SIOS Meßtechnik GmbH – INFAS-Vibro",
            "Messung vom 02.05.2024 10:11:12",
            "Messfrequenz: 5.000,0 Hz",
            f"Anzahl Messwerte: {r.n}",
            "",
            "Piezospannung [V]\tLänge [nm]",
        ]
        + rows(comma(u), comma(y), sep="\t"),
        enc="cp1252",
        nl="\r\n",
    )
    return ok(2e-4, V(u), V(y))


@case(
    "attocube_pm.csv",
    "Attocube",
    "Displacement in pm stands before the voltage; 10-digit integers; time in us as integers.",
    check=ck(0, 1, 2, 1e-6, sep=";", skiprows=1, fix=lambda d: d.iloc[:, [0, 2, 1]]),
)
def _(p):
    r = Rec("atto", 1e-3, 55, 4.2e9, t0=12.5)
    t, u, y = S(r.t * 1e6, "%.0f"), S(r.u, "%.4f"), S(r.y, "%.0f")
    wr(p, ["time [us];IDS3010 displacement axis 0 [pm];ANC300 voltage [V]"] + rows(t, y, u, sep=";"))
    return ok(1e-3, V(u), V(y))


@case(
    "igor_cr.itx",
    "Igor",
    "Igor text with CR line ends; names and period only in WAVES and SetScale lines after the data.",
    check=lambda p: _itx(p),
    tsrx=(r"SetScale/P x 0.002,([\d.]+)", float),
)
def _(p):
    r = Rec("itx", 1e-4, 100, 10)
    u, y = S(r.u, "%.8g"), S(r.y, "%.8g")
    wr(
        p,
        ["IGOR", f"WAVES/D/N=({r.n})\tPiezoVoltage, Displacement", "BEGIN"]
        + ["\t" + x for x in rows(u, y, sep="\t")]
        + [
            "END",
            'X SetScale/P x 0.002,0.0001,"s", PiezoVoltage; SetScale y 0,0,"V", PiezoVoltage',
            'X SetScale/P x 0.002,0.0001,"s", Displacement; SetScale y 0,0,"um", Displacement',
            'X Note PiezoVoltage, "3 cycles, 20 degC"',
        ],
        nl="\r",
    )
    return ok(1e-4, V(u), V(y))


def _itx(p):
    L = open(p, newline="").read().split("\r")
    a, b = L.index("BEGIN"), L.index("END")
    d = np.loadtxt(L[a + 1 : b])
    return None, d[:, 0], d[:, 1]


@refuse(
    "igor_two_scales.itx",
    "Igor",
    "Two waves of equal length with different x increments: u and y have different sampling.",
)
def _(p):
    r = Rec("itx2", 1e-4)
    o = ["IGOR"]
    for n, v, dx in (("PiezoVoltage", r.u, "0.0001"), ("Displacement", r.y, "0.0002")):
        o += [f"WAVES/D\t{n}", "BEGIN"] + ["\t" + x for x in S(v)] + ["END", f'X SetScale/P x 0,{dx},"s", {n}']
    wr(p, o, nl="\r\n")


@case(
    "jena_cells_with_units.csv",
    "piezosystem jena",
    "Every cell carries its unit ('12.5 V'), the same in all rows.",
    check=lambda p: tuple(
        pd.read_csv(p, sep=";", skiprows=1).iloc[:, c].str.split(" ").str[0].astype(float).to_numpy() * f
        for c, f in ((0, 1e-3), (1, 1), (2, 1))
    ),
)
def _(p):
    r = Rec("jena", 1e-3, 130, 80)
    t, u, y = S(r.t * 1e3, "%.1f"), S(r.u, "%.3f"), S(r.y, "%.3f")
    wr(
        p,
        ["d-Drive PX 100 SG", "time;actuator voltage;stroke"] + [f"{a} ms;{b} V;{c} µm" for a, b, c in zip(t, u, y)],
        nl="\r\n",
    )
    return ok(1e-3, V(u), V(y))


@refuse(
    "cells_mixed_prefix.csv",
    "logger",
    "Cells carry units whose prefix changes (980 mV, then 1.02 V): the column has no single unit.",
)
def _(p):
    r = Rec("mixp", 1e-2, 6, 3)
    f = lambda v: f"{v * 1e3:.1f} mV" if abs(v) < 1 else f"{v:.4f} V"
    wr(p, ["time;voltage;displacement"] + [f"{a:.2f} s;{f(b)};{c:.4f} um" for a, b, c in zip(r.t, r.u, r.y)])
