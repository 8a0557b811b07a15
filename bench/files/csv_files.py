"""CSV as found, part 1: encodings, line ends, separators and numbers.

Excel writes the list separator and decimal sign of the Windows region
("Save as CSV": cp1252, "CSV UTF-8": BOM, "Unicode Text": UTF-16 LE with tabs;
Microsoft support, "File formats that are supported in Excel"). The line
"sep=;" is read by Excel only. pandas: DataFrame.to_csv. numpy: savetxt.
MATLAB: writetable, writematrix (R2019a and later). R: write.csv.
"""
import io

import numpy as np

from common import HAND, REAL, RECALL, Ch, record, rows

BOM8 = b"\xef\xbb\xbf"
T = ("Time (s)", "time", "s")
V = Ch("Voltage (V)", "Voltage", "V")
D = Ch("Displacement (um)", "Displacement", "um")
HEAD = "Time (s),Voltage (V),Displacement (um)"


def text(name, **kw):
    """The record of this file as text; kw as in Rec.text."""
    ts = kw.pop("ts", 0.0005)
    return record(name, ts).text(**kw)


def plain(b):
    name, why = "csv_plain.csv", "nothing; the reference case"
    d = text(name)
    b.lines(name, ["time_s,voltage_V,displacement_um"] + rows([d.t, d.u, d.y]))
    b.read(name, d, Ch("voltage_V", "voltage", "V"),
           Ch("displacement_um", "displacement", "um"), why, "a script")


def excel_german(b):
    name = "excel_german_cp1252.csv"
    d = text(name)
    temp = ["%.1f" % (23 + 0.001 * i) for i in range(len(d.t))]
    head = "Zeit [s];Spannung [V];Weg [µm];Temperatur [°C]"
    b.lines(name, [head] + rows([d.t, d.u, d.y, temp], ";", ","), "cp1252",
            "\r\n")
    b.read(name, d, Ch("Spannung [V]", "Spannung", "V"),
           Ch("Weg [µm]", "Weg", "µm"),
           "cp1252 bytes B5 and B0, decimal comma, extra temperature column",
           "after layout: Excel (German region) save as CSV")


def excel_bom(b):
    name = "excel_utf8_bom.csv"
    d = text(name)
    head = "Time (s),Voltage (V),Displacement (µm)"
    b.lines(name, [head] + rows([d.t, d.u, d.y]), eol="\r\n", bom=BOM8)
    b.read(name, d, V, Ch("Displacement (µm)", "Displacement", "µm"),
           "byte order mark before the first header cell",
           "after layout: Excel CSV UTF-8")


def excel_unicode_text(b):
    name = "excel_unicode_text.txt"
    d = text(name)
    head = "Zeit (s)\tSpannung (V)\tAuslenkung (µm)"
    b.lines(name, [head] + rows([d.t, d.u, d.y], "\t", ","), "utf-16-le",
            "\r\n", bom=b"\xff\xfe")
    b.read(name, d, Ch("Spannung (V)", "Spannung", "V"),
           Ch("Auslenkung (µm)", "Auslenkung", "µm"),
           "UTF-16 LE with BOM, tabs, decimal comma",
           "after layout: Excel Unicode Text")


def sep_line(b):
    name = "excel_sep_line.csv"
    d = text(name)
    b.lines(name, ["sep=;", "Time (s);Voltage (V);Displacement (um)"]
            + rows([d.t, d.u, d.y], ";"), eol="\r\n")
    b.read(name, d, V, D, "first line names the separator, it is no data",
           "after layout: sep= line for Excel")


def micro_signs(b):
    for tag, mu in (("micro_b5", "\u00b5"), ("greek_mu", "\u03bc")):
        name = "csv_%s.csv" % tag
        d = text(name)
        cell = "Displacement (%sm)" % mu
        b.lines(name, ["Time (s),Voltage [V]," + cell]
                + rows([d.t, d.u, d.y]))
        b.read(name, d, Ch("Voltage [V]", "Voltage", "V"),
               Ch(cell, "Displacement", mu + "m"),
               "micro sign is U+%04X; mixed brackets" % ord(mu), "a script")


def line_ends(b):
    for tag, eol in (("crlf", "\r\n"), ("cr_only", "\r")):
        name = "csv_%s.csv" % tag
        d = text(name)
        b.lines(name, [HEAD] + rows([d.t, d.u, d.y]), eol=eol)
        b.read(name, d, V, D, "line end is " + repr(eol), "a script")
    name = "csv_no_last_newline.csv"
    d = text(name)
    b.lines(name, [HEAD] + rows([d.t, d.u, d.y]), last=False)
    b.read(name, d, V, D, "no line end after the last row", "a script")


def quoting(b):
    name = "csv_quoted_all.csv"
    d = text(name)
    quoted = [['"%s"' % v for v in c] for c in (d.t, d.u, d.y)]
    head = ",".join('"%s"' % h for h in HEAD.split(","))
    b.lines(name, [head] + rows(quoted))
    b.read(name, d, V, D, "every field quoted, numbers too", "a script")
    name = "libreoffice_comma_quoted.csv"
    d = text(name)
    quoted = [['"%s"' % v.replace(".", ",") for v in c]
              for c in (d.t, d.u, d.y)]
    b.lines(name, ["Zeit in s,Spannung in V,Weg in µm"] + rows(quoted))
    b.read(name, d, Ch("Spannung in V", "Spannung", "V"),
           Ch("Weg in µm", "Weg", "µm"),
           "comma is both separator and decimal sign; the quotes tell",
           "after layout: LibreOffice Calc, German, field separator comma")


def comma_both(b):
    name = "csv_comma_comma.csv"
    d = text(name)
    b.lines(name, ["Zeit,Spannung,Weg"] + rows([d.t, d.u, d.y], ",", ","))
    b.refuse(name, "comma is separator and decimal sign, nothing is quoted: "
             "3 names, 6 cells a row", ["export again with another separator "
             "or a decimal point"], "a script with a German locale",
             data=d, u=Ch("Spannung"), y=Ch("Weg"))


def trailing_delimiter(b):
    name = "csv_trailing_delimiter.csv"
    d = text(name)
    b.lines(name, [HEAD + ","] + rows([d.t, d.u, d.y], end=","))
    b.read(name, d, V, D, "a separator ends each row: empty fourth column",
           "a script")


def thousands(b):
    def group(cells, mark, dec):
        return [("{:,.1f}".format(float(c))).replace(",", "#")
                .replace(".", dec).replace("#", mark) for c in cells]
    cases = (("de", ".", ",", ";", '%s'), ("us", ",", ".", ",", '"%s"'),
             ("fr_nbsp", "\u202f", ",", ";", '%s'))
    for tag, mark, dec, sep, quote in cases:
        name = "csv_thousands_%s.csv" % tag
        d = text(name, fu="%.1f", fy="%.1f", ku=1e3, ky=1e3)
        cu = [quote % c for c in group(d.u, mark, dec)]
        cy = [quote % c for c in group(d.y, mark, dec)]
        ct = [c.replace(".", dec) for c in d.t]
        b.lines(name, [sep.join(("Time (s)", "Voltage (mV)",
                                 "Displacement (nm)"))]
                + rows([ct, cu, cy], sep))
        b.read(name, d, Ch("Voltage (mV)", "Voltage", "mV"),
               Ch("Displacement (nm)", "Displacement", "nm"),
               "thousands mark %r with decimal sign %r" % (mark, dec),
               "spreadsheet cells formatted with a thousands mark")


def exponents(b):
    name = "fortran_d_exponent.txt"
    d = text(name, ft="%.6E", fu="%.6E", fy="%.6E")
    cols = [["%15s" % c.replace("E", "D") for c in col]
            for col in (d.t, d.u, d.y)]
    b.lines(name, ["           TIME        VOLTAGE   DISPLACEMENT"]
            + rows(cols, ""))
    b.read(name, d, Ch("VOLTAGE"), Ch("DISPLACEMENT"),
           "exponent letter D, columns of fixed width",
           "after layout: Fortran WRITE with format D15.6")
    name = "csv_exponent_comma.csv"
    d = text(name, ft="%.4E", fu="%.5E", fy="%.6E")
    b.lines(name, ["t [s];U [V];x [µm]"] + rows([d.t, d.u, d.y], ";", ","))
    b.read(name, d, Ch("U [V]", "U", "V"), Ch("x [µm]", "x", "µm"),
           "decimal comma inside numbers with exponent", "a script")
    name = "csv_plus_signs.csv"
    d = text(name, ft="%+.4E", fu="%+.4E", fy="%+.5E")
    b.lines(name, ["Time (s), Voltage (V), Displacement (um)"]
            + rows([d.t, d.u, d.y], ", "))
    b.read(name, d, V, D, "plus signs and a blank after each comma",
           "a script")


def blank_lines(b):
    name = "csv_blank_lines.csv"
    d = text(name)
    body = rows([d.t, d.u, d.y])
    out = ["", HEAD, ""]
    for i, line in enumerate(body):
        out += [line, ""] if i % 50 == 49 else [line]
    b.lines(name, out + ["", ""])
    b.read(name, d, V, D, "blank lines before, between and after", "a script")


def fixed_width(b):
    name = "columns_aligned.dat"
    d = text(name)
    cols = [["%12s" % c for c in col] for col in (d.t, d.u, d.y)]
    b.lines(name, ["    Time[s]   Voltage[V]     Disp[um]"] + rows(cols, " "))
    b.read(name, d, Ch("Voltage[V]", "Voltage", "V"),
           Ch("Disp[um]", "Disp", "um"),
           "a varying number of blanks between the columns", "a script")


def by_pandas(b):
    import pandas as pd
    name = "pandas_index.csv"
    r = record(name)
    d = r.text("%.6f", "%.6f", "%.6f")
    frame = pd.DataFrame({"time": r.t, "voltage": r.u, "displacement": r.y})
    b.raw(name, frame.to_csv(float_format="%.6f",
                             lineterminator="\n").encode())
    b.read(name, d, Ch("voltage"), Ch("displacement"),
           "first column is a row number without a name; no units",
           "pandas %s to_csv" % pd.__version__, REAL)


def by_numpy(b):
    for tag, head in (("header", "time voltage displacement"), ("bare", "")):
        name = "numpy_savetxt_%s.txt" % tag
        r = record(name)
        d = r.text("%.18e", "%.18e", "%.18e")
        f = io.BytesIO()
        np.savetxt(f, np.column_stack([r.t, r.u, r.y]), header=head)
        b.raw(name, f.getvalue())
        who = "numpy savetxt"
        if head:
            b.read(name, d, Ch("voltage"), Ch("displacement"),
                   "the names stand in a comment line", who, REAL)
        else:
            b.refuse(name, "three columns without names", ["which column "
                     "is time, voltage, displacement", "units"], who, REAL,
                     data=d)


def by_matlab(b):
    name = "matlab_writetable.csv"
    d = text(name, ft="%.15g", fu="%.15g", fy="%.15g")
    b.lines(name, ["t,u,y"] + rows([d.t, d.u, d.y]))
    b.read(name, d, Ch("u"), Ch("y"), "only t, u, y as names; no units",
           "after layout: MATLAB writetable", RECALL)
    name = "matlab_writematrix.txt"
    d = text(name, ft="%.15g", fu="%.15g", fy="%.15g")
    b.lines(name, rows([d.t, d.u, d.y]))
    b.refuse(name, "writematrix writes no names",
             ["which column is time, voltage, displacement", "units"],
             "after layout: MATLAB writematrix", RECALL, data=d)


def by_r(b):
    name = "r_write_csv.csv"
    d = text(name, ft="%.15g", fu="%.15g", fy="%.15g")
    number = ['"%d"' % (i + 1) for i in range(len(d.t))]
    b.lines(name, ['"","time_s","voltage_V","position_um"']
            + rows([number, d.t, d.u, d.y]))
    b.read(name, d, Ch("voltage_V", "voltage", "V"),
           Ch("position_um", "position", "um"),
           "quoted row names in a column with an empty name",
           "after layout: R 4 write.csv", HAND)


def make(b):
    for f in (plain, excel_german, excel_bom, excel_unicode_text, sep_line,
              micro_signs, line_ends, quoting, comma_both,
              trailing_delimiter, thousands, exponents, blank_lines,
              fixed_width, by_pandas, by_numpy, by_matlab, by_r):
        f(b)
