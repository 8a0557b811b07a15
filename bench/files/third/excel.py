"""Workbooks (openpyxl)."""

import datetime as dt
import re
import zipfile

import openpyxl

from common import *


def save(wb, p):
    d = dt.datetime(2024, 5, 2)
    wb.properties.created = wb.properties.modified = d
    wb.save(p)
    with zipfile.ZipFile(p) as z:
        it = [(i.filename, z.read(i)) for i in z.infolist()]
    with zipfile.ZipFile(p, "w", zipfile.ZIP_DEFLATED) as z:
        for n, b in it:
            if n == "docProps/core.xml":
                b = re.sub(rb"20\d\d-\d\d-\d\dT[\d:]+Z", b"2024-05-02T00:00:00Z", b)
            i = zipfile.ZipInfo(n, (2024, 5, 2, 0, 0, 0))
            i.compress_type = zipfile.ZIP_DEFLATED
            z.writestr(i, b)


def xl(p, sheet, r0, cols, n, f=1.0):
    d = pd.read_excel(p, sheet_name=sheet, header=None, skiprows=r0, nrows=n)
    a = [d.iloc[:, c].astype(float).to_numpy() for c in cols]
    return a[0] * f, a[1], a[2]


@case(
    "xlsx_title_units_footer.xlsx",
    "Excel",
    "Title lines, data from column C with an empty column between, units row with empty cells, mean/min/max below, a second sheet with a summary.",
    check=lambda p: xl(p, "Messung", 5, (2, 4, 5), 210, 1e-3),
)
def _(p):
    r = Rec("xl1", 2e-3, 100, 12, n=210)
    u, y = np.round(r.u, 4), np.round(r.y, 5)
    wb = openpyxl.Workbook()
    w = wb.active
    w.title = "Auswertung"
    for a in (["Kennwert", "Wert"], ["Hysterese %", 13.2], ["Hub µm", 11.9]):
        w.append(a)
    w = wb.create_sheet("Messung")
    w["A1"] = "Aktor 12, 3 Zyklen"
    w["A2"] = dt.datetime(2024, 5, 2, 10, 0)
    for c, s in zip("CEFG", ("Zeit", "Spannung", "Weg", "Bemerkung")):
        w[f"{c}4"] = s
    w["C5"], w["F5"], w["E5"] = "ms", "µm", "V"
    for k in range(r.n):
        w.cell(6 + k, 3, round(2.0 * k, 3))
        w.cell(6 + k, 5, float(u[k]))
        w.cell(6 + k, 6, float(y[k]))
    for j, (s, f) in enumerate((("Mittelwert", np.mean), ("Min", np.min), ("Max", np.max))):
        w.cell(7 + r.n + j, 2, s)
        w.cell(7 + r.n + j, 5, float(f(u)))
        w.cell(7 + r.n + j, 6, float(f(y)))
    save(wb, p)
    return ok(2e-3, u, y)


@case(
    "xlsx_serial_dates.xlsx",
    "Excel",
    "Time as Excel date cells (serial numbers, format with ms) in 0.1 s steps.",
    tstol=1e-4,
    check=lambda p: (
        lambda d: (
            (pd.to_datetime(d.iloc[:, 0]) - pd.to_datetime(d.iloc[0, 0])).dt.total_seconds().to_numpy(),
            d.iloc[:, 1].to_numpy(),
            d.iloc[:, 2].to_numpy(),
        )
    )(pd.read_excel(p)),
)
def _(p):
    r = Rec("xl2", 0.1, 100, 12)
    u, y = np.round(r.u, 4), np.round(r.y, 5)
    wb = openpyxl.Workbook()
    w = wb.active
    w.append(["Date/Time", "Voltage (V)", "Displacement (µm)"])
    for k in range(r.n):
        w.append([45414.42 + k * 0.1 / 86400, float(u[k]), float(y[k])])
        w.cell(k + 2, 1).number_format = "yyyy-mm-dd hh:mm:ss.000"
    save(wb, p)
    return ok(0.1, u, y)


@refuse(
    "xlsx_formula_no_cache.xlsx",
    "Excel",
    "Displacement is a formula without stored result (written by a script): the file holds no numbers for it.",
)
def _(p):
    r = Rec("xl3", 1e-3)
    wb = openpyxl.Workbook()
    w = wb.active
    w.append(["Time (s)", "Voltage (V)", "Sensor (counts)", "Displacement (um)"])
    for k in range(r.n):
        w.append([round(k * 1e-3, 4), float(round(r.u[k], 4)), int(r.y[k] * 1000), f"=C{k + 2}/1000-Cal!B2"])
    wb.create_sheet("Cal").append(["offset", 0.37])
    save(wb, p)


@refuse(
    "xlsx_two_runs.xlsx", "Excel", "Two sheets Run1 and Run2 with complete records: which one is meant is not known."
)
def _(p):
    wb = openpyxl.Workbook()
    wb.remove(wb.active)
    for s, a in (("Run1", 100), ("Run2", 80)):
        r = Rec("xl4" + s, 1e-3, a, a * 0.12, n=200)
        w = wb.create_sheet(s)
        w.append(["Time (s)", "Voltage (V)", "Displacement (um)"])
        for k in range(r.n):
            w.append([round(k * 1e-3, 4), float(round(r.u[k], 4)), float(round(r.y[k], 5))])
    save(wb, p)


@refuse("xlsx_na_cells.xlsx", "Excel", "#N/A error cells in the used displacement column.")
def _(p):
    r = Rec("xl5", 1e-3)
    wb = openpyxl.Workbook()
    w = wb.active
    w.append(["Time (s)", "Voltage (V)", "Displacement (um)"])
    for k in range(r.n):
        w.append([round(k * 1e-3, 4), float(round(r.u[k], 4)), "#N/A" if 60 <= k < 66 else float(round(r.y[k], 5))])
    save(wb, p)
