"""Reads files of the second set back with other libraries."""

import re

from common import *


def check():
    """Prints what differs."""

    def lines(p, enc="utf-8"):
        return re.split("\r\n|\r|\n", open(p, "rb").read().decode(enc))

    num = lambda a: np.array([float(x) for x in a])

    def c_igor(p):
        L = lines(p)
        d = [l.split() for l in L[L.index("BEGIN") + 1 : L.index("END")]]
        return num([a[0] for a in d]), num([a[1] for a in d]), None

    def c_oct(p):
        B = open(p).read().split("# name: ")[1:]
        v = {b.split()[0]: num(b.split("columns: 1")[1].split()) for b in B}
        return v["u"], v["y"], np.mean(np.diff(v["t"]))

    def c_kv(p):
        d = re.findall("millis=(.*)\tdac_V=(.*)\tpos_um=(.*)", open(p).read())
        return num([a[1] for a in d]), num([a[2] for a in d]), (float(d[-1][0]) - float(d[0][0])) / (len(d) - 1) / 1e3

    def c_long(p):
        import pandas as pd

        d = pd.read_csv(p).pivot(index="time_s", columns="channel", values="value")
        return d["piezo_voltage"].to_numpy(), d["displacement"].to_numpy(), np.mean(np.diff(d.index))

    def c_tr(p):
        d = [num(l.split(",")[1:]) for l in lines(p)[:3]]
        return d[1], d[2], np.mean(np.diff(d[0]))

    def c_nox(p):
        d = [l.split("\t")[1:] for l in lines(p) if re.match("\t[-0-9]", l)]
        return num([a[-1] for a in d]), num([a[-2] for a in d]), None

    def c_seg(p):
        d = [l.split("\t")[1:] for l in lines(p) if re.match("\t[-0-9]", l)]
        return num([a[0] for a in d]), num([a[1] for a in d]), None

    def c_gl(p):
        d = [l.replace(" ", "").split(",") for l in lines(p)[16:] if l]
        return num([a[3] for a in d]), num([a[4] for a in d]), np.mean(np.diff(num([a[2] for a in d]))) / 1e3

    def c_fort(p):
        d = [num([l[i : i + 15].replace("D", "e") for i in (0, 15, 30)]) for l in lines(p)[1:] if l]
        d = np.array(d)
        return d[:, 1], d[:, 2], (d[-1, 0] - d[0, 0]) / (len(d) - 1)

    def c_rep(p):
        d = np.array([num(l.split(",")) for l in lines(p) if l and l[0] != "T"])
        return d[:, 1], d[:, 2], np.mean(np.diff(d[:, 0]))

    def c_127(p):
        import openpyxl

        d = np.array(list(openpyxl.load_workbook(open(p, "rb")).active.iter_rows(min_row=2, values_only=True)), float)
        return d[:, 1], d[:, 2], np.mean(np.diff(d[:, 0]))

    CHECKS.extend(
        [
            ("20_igor.itx", c_igor),
            ("24_octave.txt", c_oct),
            ("25_serial_monitor.log", c_kv),
            ("26_influx_long.csv", c_long),
            ("27_transposed.csv", c_tr),
            ("30_nox.lvm", c_nox),
            ("31_segments.lvm", c_seg),
            ("56_220519-132007.CSV", c_gl),
            ("74_NEWPORT.PRN", c_fort),
            ("88_repeated_header.csv", c_rep),
            ("127_export.csv", c_127),
        ]
    )
    by = {e["file"]: e for e in TRUTH}
    bad = 0
    for name, f in CHECKS:
        e = by[name]
        try:
            u, y, ts = f(path(name))
            ok = (
                len(u) == len(e["u"])
                and np.array_equal(np.asarray(u, float), np.array(e["u"]))
                and np.array_equal(np.asarray(y, float), np.array(e["y"]))
            )
            if not ok and len(u) == len(e["u"]):
                d = max(np.max(np.abs(np.asarray(u, float) - e["u"])), np.max(np.abs(np.asarray(y, float) - e["y"])))
                ok = d < 1e-9 * max(np.ptp(e["y"]), np.ptp(e["u"]))
                if ok:
                    pass
            if ts is not None and abs(ts / e["ts"] - 1) > 1e-6:
                ok = False
                print("ts", name, ts, e["ts"])
            if not ok:
                bad += 1
                print("DIFF", name, len(u), len(e["u"]))
        except Exception as ex:
            bad += 1
            print("ERR", name, repr(ex)[:200])
    nr = sum(e["expect"] == "read" for e in TRUTH)
    chk = {n for n, _ in CHECKS}
    print(
        len(TRUTH),
        "files;",
        nr,
        "read;",
        len(TRUTH) - nr,
        "refuse;",
        sum(bool(e["also_ok"]) for e in TRUTH),
        "also_ok;",
        len(CHECKS),
        "checked; bad",
        bad,
    )
    print("read but unchecked:", [e["file"] for e in TRUTH if e["expect"] == "read" and e["file"] not in chk])
