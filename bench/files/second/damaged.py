"""Damaged files, and others that should be refused."""

from common import *


def damaged():
    import h5py
    import openpyxl
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
    from scipy.io import savemat

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
