#!/usr/bin/env python3
"""A third set of records as other programs write them, by someone who had not seen the readers.

usage: make.py DIR            writes the files and truth.json
       make.py --check DIR    reads the files back with other libraries
"""

import importlib
import json
import os
import re
import sys
import warnings

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import common

warnings.filterwarnings("ignore")
FAMILIES = "scope controllers labview sensors locales layouts excel tdms matlab hdf5 arrays"
for family in FAMILIES.split():
    importlib.import_module(family)


def write(out):
    os.makedirs(out, exist_ok=True)
    truth = []
    for c in common.CASES:
        got = c["make"](os.path.join(out, c["file"]))
        assert (got is not None) == (c["expect"] == "read"), c["file"]
        got = got or dict(ts=None, u=[], y=[])
        assert len(got["u"]) == len(got["y"]) and all(np.isfinite(got["u"] + got["y"])), c["file"]
        assert c["expect"] == "refuse" or 150 <= len(got["u"]) <= 400, c["file"]
        truth.append(
            dict(file=c["file"], family=c["family"], expect=c["expect"], **got, why=c["why"], also_ok=c["also_ok"])
        )
    with open(os.path.join(out, "truth.json"), "w", encoding="utf-8") as f:
        json.dump(truth, f, ensure_ascii=False, indent=0)
    n = sum(t["expect"] == "read" for t in truth)
    print(
        len(truth),
        "files,",
        n,
        "read,",
        len(truth) - n,
        "refuse,",
        sum(bool(t["also_ok"]) for t in truth),
        "with also_ok",
    )


def check(out):
    truth = {t["file"]: t for t in json.load(open(os.path.join(out, "truth.json"), encoding="utf-8"))}
    bad = done = 0
    for c in common.CASES:
        if c["expect"] != "read":
            continue
        t = truth[c["file"]]
        msg = ""
        try:
            tt, u, y = (
                None if a is None else np.asarray(a, float).ravel() for a in c["check"](os.path.join(out, c["file"]))
            )
            for nm, a, b in (("u", u, t["u"]), ("y", y, t["y"])):
                if len(a) != len(b):
                    msg += f" {nm}: {len(a)} samples, truth {len(b)}"
                elif not np.allclose(a, b, rtol=c["tol"], atol=c["tol"] * np.ptp(b)):
                    msg += f" {nm} differs by {np.max(np.abs(a - b)):g}"
            if tt is not None:
                d = np.diff(tt)
                ts = (tt[-1] - tt[0]) / (len(tt) - 1)
                if abs(ts / t["ts"] - 1) > c["tstol"]:
                    msg += f" ts {ts!r}, truth {t['ts']!r}"
                if np.ptp(d) > 0.05 * t["ts"]:
                    msg += f" uneven time, {np.ptp(d):g}"
            if c["tsrx"]:
                s = float(
                    c["tsrx"][1](
                        re.search(
                            c["tsrx"][0], open(os.path.join(out, c["file"]), encoding="latin-1", newline="").read()
                        ).group(1)
                    )
                )
                if abs(s / t["ts"] - 1) > 1e-9:
                    msg += f" ts in file {s}, truth {t['ts']}"
            elif tt is None:
                msg += " period not checked"
        except Exception as e:
            msg = f" {type(e).__name__}: {e}"
        done += 1
        bad += bool(msg)
        if msg:
            print("BAD", c["file"], msg)
    print("checked", done, "read files, bad:", bad)
    return bad


if __name__ == "__main__":
    a = [x for x in sys.argv[1:] if x != "--check"]
    if "--check" in sys.argv:
        sys.exit(bool(check(a[0])))
    write(a[0])
