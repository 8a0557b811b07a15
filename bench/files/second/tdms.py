"""TDMS and WAV."""

from common import *


def tdms():
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter

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
