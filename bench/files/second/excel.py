"""Spreadsheets of several countries."""

from common import *


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
