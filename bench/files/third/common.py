"""Registry of cases, signals and small text helpers."""

import zlib

import numpy as np
import pandas as pd

CASES = []


def case(file, family, why, expect="read", also_ok="", check=None, tol=1e-9, tstol=1e-6, tsrx=None):
    def deco(f):
        assert all(c["file"] != file for c in CASES), file
        CASES.append(
            dict(
                file=file,
                family=family,
                why=why,
                expect=expect,
                also_ok=also_ok,
                check=check,
                tol=tol,
                tstol=tstol,
                tsrx=tsrx,
                make=f,
            )
        )
        return f

    return deco


DEC = lambda x: float(
    x.replace(",", ".")
)  # for tsrx = (pattern of the period or rate in the file, text -> period in s)


def refuse(file, family, why):
    return case(file, family, why, expect="refuse")


class Rec:
    """Rising sine voltage and a play-operator displacement."""

    def __init__(self, name, ts=1e-4, amp=100.0, span=12.0, n=None, t0=0.0, cycles=3, bias=0.0):
        g = np.random.default_rng(zlib.crc32(name.encode()))
        self.n = n or int(g.integers(150, 401))
        k = np.arange(self.n)
        self.ts, self.g, self.k = ts, g, k
        self.t = t0 + k * ts
        ph = 2 * np.pi * cycles * k / self.n
        u = amp * (0.25 + 0.75 * k / self.n) * 0.5 * (1 - np.cos(ph)) + bias
        y = 0.62 * (u - bias)
        for w, r in zip((0.2, 0.14, 0.09), (0.05, 0.12, 0.25)):
            z, out = 0.0, []
            for v in u - bias:
                z = max(v - r * abs(amp), min(v + r * abs(amp), z))
                out.append(z)
            y = y + w * np.array(out)
        self.u = u + g.normal(0, 2e-4 * abs(amp), self.n)
        self.y = span / abs(amp) * y + g.normal(0, 2e-4 * abs(span), self.n) + 0.031 * abs(span)


def S(a, f="%.6f"):
    return [f % v for v in a]


def V(s):
    return [float(x) for x in s]


def rows(*cols, sep=","):
    return [sep.join(r) for r in zip(*cols)]


def comma(s):
    return [x.replace(".", ",") for x in s]


def group(s, th, dec):
    """'12345.67' -> '12<th>345<dec>67'."""
    o = []
    for x in s:
        neg = x.startswith("-")
        i, _, d = x.lstrip("-").partition(".")
        o.append(("-" if neg else "") + f"{int(i):,}".replace(",", th) + (dec + d if d else ""))
    return o


def wr(path, lines, enc="utf-8", nl="\n", end=True):
    t = lines if isinstance(lines, str) else nl.join(lines) + (nl if end else "")
    with open(path, "wb") as f:
        f.write(t.encode(enc))


def ok(ts, u, y):
    return dict(ts=float(ts), u=[float(v) for v in u], y=[float(v) for v in y])


def ck(t, u, y, ts=1.0, fix=None, **kw):
    """Checker through pandas.read_csv: column positions and time factor."""

    def run(path):
        kw.setdefault("header", None)
        d = pd.read_csv(path, **kw)
        if fix:
            d = fix(d)
        g = lambda c: d.iloc[:, c].astype(float).to_numpy()
        return (None if t is None else g(t) * ts), g(u), g(y)

    return run


def ckt(tf, u, y, **kw):
    """As ck, the time column through tf (strings -> seconds)."""

    def run(path):
        kw.setdefault("header", None)
        d = pd.read_csv(path, **kw)
        g = lambda c: d.iloc[:, c].astype(float).to_numpy()
        return np.asarray(tf(d.iloc[:, 0].astype(str))), g(u), g(y)

    return run


C = dict(chunks=True, compression="gzip", shuffle=True)
"""Options of h5py for a data set."""
