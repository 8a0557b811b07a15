"""Signals, numbers as text, and the list of files of the second set."""

import os, io, json, struct, zipfile, shutil, datetime as dt, math, wave, sys
import numpy as np

ROOT = sys.argv[1]
OUT = ROOT
os.makedirs(OUT, exist_ok=True)
TRUTH = []
CHECKS = []  # (file, function(path) -> (u, y, ts or None))
_seed = [4000]


class Rec:
    pass


def rec(ts, umax=100.0, umin=0.0, stroke=10.0, f=None, n=None, noise=2e-4, unoise=0.0, rising=0.75, y0=0.0):
    """Sine of rising amplitude and a hysteretic answer (play operators, lag, some creep).
    stroke: displacement at full voltage, in the unit wanted for y."""
    _seed[0] += 1
    g = np.random.default_rng(_seed[0])
    if n is None:
        n = int(g.integers(150, 401))
    if f is None:
        f = float(g.uniform(2.5, 4.5)) / (n * ts)
    k = np.arange(n)
    t = k * ts
    amp = (1 - rising) + rising * k / (n - 1)
    s = amp * 0.5 * (1 - np.cos(2 * np.pi * f * t))
    u = umin + (umax - umin) * s + unoise * (umax - umin) * g.standard_normal(n)
    # Prandtl-Ishlinskii
    x = (u - umin) / (umax - umin)
    rs = np.array([0.02, 0.06, 0.12, 0.2, 0.3, 0.42])
    ws = np.array([0.10, 0.08, 0.07, 0.06, 0.05, 0.04])
    st = np.zeros(6)
    y = np.empty(n)
    lag = 0.0
    a = 0.35
    cr = 0.0
    for i in range(n):
        st = np.maximum(x[i] - rs, np.minimum(x[i] + rs, st))
        z = 0.72 * x[i] + float(ws @ st)
        cr += 0.002 * (z - cr)
        lag += a * (z + 0.02 * cr - lag)
        y[i] = lag
    y = y0 + stroke * (y + noise * g.standard_normal(n))
    r = Rec()
    r.t, r.u, r.y, r.n, r.ts, r.g, r.f = t, u, y, n, ts, g, f
    return r


def S(spec, arr):
    return [spec % float(v) for v in arr]


def V(strs, dec=".", th=""):
    out = []
    for s in strs:
        s = s.strip().strip('"').replace(" ", "")
        if th:
            s = s.replace(th, "")
        if dec != ".":
            s = s.replace(dec, ".")
        s = s.replace("D", "E").replace("d", "e")
        out.append(float(s))
    return out


def C(strs):
    """decimal comma"""
    return [s.replace(".", ",") for s in strs]


def rows(sep, *cols):
    return [sep.join(r) for r in zip(*cols)]


def path(name):
    p = os.path.join(OUT, name)
    return p


def text(lines, enc="utf-8", eol="\n", final=True, bom=b""):
    s = eol.join(lines) + (eol if final else "")
    return bom + s.encode(enc)


def add(name, family, data, expect, ts, u, y, why, also_ok="", chk=None):
    if data is not None:
        with open(path(name), "wb") as fh:
            fh.write(data)
    assert os.path.exists(path(name)), name
    assert expect in ("read", "refuse")
    assert also_ok == "" or also_ok.startswith("refuse")
    if expect == "refuse":
        u, y = [], []
    else:
        assert len(u) == len(y) and len(u) >= 150, (name, len(u), len(y))
    conv = lambda a: [None if (isinstance(v, float) and math.isnan(v)) else float(v) for v in a]
    TRUTH.append(
        dict(
            file=name,
            family=family,
            expect=expect,
            ts=None if ts is None else float(ts),
            u=conv(u),
            y=conv(y),
            why=why,
            also_ok=also_ok,
        )
    )
    if chk is not None:
        CHECKS.append((name, chk))


def pdcsv(uc, yc, tc=None, tscale=1.0, **kw):
    """check by pandas"""

    def f(p):
        import pandas as pd

        d = pd.read_csv(p, **kw)
        u = pd.to_numeric(d.iloc[:, uc] if isinstance(uc, int) else d[uc]).to_numpy(float)
        y = pd.to_numeric(d.iloc[:, yc] if isinstance(yc, int) else d[yc]).to_numpy(float)
        ts = None
        if tc is not None:
            t = pd.to_numeric(d.iloc[:, tc] if isinstance(tc, int) else d[tc]).to_numpy(float) * tscale
            ts = (t[-1] - t[0]) / (len(t) - 1)
        return u, y, ts

    return f


BOM = b"\xef\xbb\xbf"
E = "read"
X = "refuse"
