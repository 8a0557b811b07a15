"""What all modules share: the test signal, text helpers and the truth list.

The signal is made here and comes from no instrument. Each file gets its own
record (the seed is the file name), so that a mix-up of two files shows.
"""
import json
import os
import zlib
from dataclasses import dataclass, field

import numpy as np

# How sure the layout of a file is.
REAL = "real writer"        # the named library wrote the bytes
SEEN = "layout seen"        # a public example of such a file was at hand
MANUAL = "layout in manual"  # the maker's manual describes the layout
RECALL = "layout recalled"  # written from memory, treat with doubt
HAND = "hand-made"          # the sort of file people type or script


@dataclass
class Ch:
    """A channel: full header text, name without the unit, unit as written."""
    header: str
    name: str = ""
    unit: str = ""

    def __post_init__(self):
        self.name = self.name or self.header


@dataclass
class Rec:
    """One record of numbers: time in s, voltage in V, displacement in um."""
    ts: float
    t: np.ndarray
    u: np.ndarray
    y: np.ndarray

    @property
    def n(self):
        return len(self.t)

    def text(self, ft="%.4f", fu="%.3f", fy="%.4f", kt=1, ku=1, ky=1, t0=0):
        """Format to text; kt, ku, ky change the unit (1e3 for ms, mV, nm),
        t0 is the time of the first sample (before the trigger: negative)."""
        t = np.round(self.t + t0, 9)
        return Text(self.ts, cells(t * kt, ft), cells(self.u * ku, fu),
                    cells(self.y * ky, fy))


@dataclass
class Text:
    """The same record as decimal text, one list of strings per channel."""
    ts: float
    t: list
    u: list
    y: list


def play(u, width):
    """Play operator: the output follows the input behind a dead band."""
    out, z = np.empty_like(u), 0.0
    for i, v in enumerate(u):
        z = min(max(z, v - width), v + width)
        out[i] = z
    return out


def record(name, ts=0.0005, n=None, amp=60.0, gain=0.11):
    """A sine that rises cycle by cycle, and a hysteretic answer to it."""
    seed = zlib.crc32(name.encode())
    rng = np.random.default_rng(seed)
    n = n or 200 + seed % 150
    k = np.arange(n)
    cycles = 3 + seed % 3
    u = 20 + amp * (k + 1) / n * np.sin(2 * np.pi * cycles * k / n)
    u = np.round(u, 4)
    y = gain * (0.7 * u + 0.3 * (play(u, 4.0) + play(u, 12.0)) / 2)
    y = np.round(y + 0.002 * rng.standard_normal(n), 6)
    return Rec(ts, np.round(k * ts, 9), u, y)


def cells(values, fmt):
    """Numbers to text, one string per number."""
    return [fmt % v for v in values]


def rows(columns, sep=",", dec=".", end=""):
    """Join columns of text to lines. dec replaces the decimal point."""
    out = []
    for parts in zip(*columns):
        if dec != ".":
            parts = [p.replace(".", dec) for p in parts]
        out.append(sep.join(parts) + end)
    return out


def number(x):
    """Truth of a cell: a float, or None where the cell holds no number."""
    try:
        v = float(x)
    except (TypeError, ValueError):
        return None
    return v if np.isfinite(v) else None


@dataclass
class Book:
    """Writes the files into one directory and keeps the truth list."""
    folder: str
    truth: list = field(default_factory=list)

    def path(self, name):
        full = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(full) or ".", exist_ok=True)
        return full

    def raw(self, name, data):
        with open(self.path(name), "wb") as f:
            f.write(data)

    def lines(self, name, lines, enc="utf-8", eol="\n", bom=b"", last=True):
        """Write text lines with the given encoding and line end."""
        text = eol.join(lines) + (eol if last else "")
        self.raw(name, bom + text.encode(enc))

    def read(self, name, data, u, y, why, writer, source=HAND, **more):
        """Note a file which a careful reader understands without help."""
        self._note(name, writer, source, "read", data, u, y, why, **more)

    def refuse(self, name, why, needs, writer, source=HAND, data=None,
               u=Ch(""), y=Ch(""), **more):
        """Note a file which a reader must decline. With data: what the file
        means once the user has given the facts listed in needs."""
        self._note(name, writer, source, "refuse", data, u, y, why,
                   needs=needs, **more)

    def _note(self, name, writer, source, expect, data, u, y, why, **more):
        ts = more.pop("ts", data.ts if data is not None else None)
        entry = {
            "file": name, "writer": writer, "source": source,
            "expect": expect, "ts": ts,
            "u": [number(v) for v in data.u] if data is not None else [],
            "y": [number(v) for v in data.y] if data is not None else [],
            "u_name": u.name, "y_name": y.name,
            "u_header": u.header, "y_header": y.header,
            "u_unit": u.unit, "y_unit": y.unit, "why": why,
        }
        entry.update(more)
        if entry.pop("only", None):  # a file with one channel
            entry[{"u": "y", "y": "u"}[more["only"]]] = []
        self.truth.append(entry)

    def save(self):
        """Write truth.json, one line per file."""
        body = ",\n".join(json.dumps(e, ensure_ascii=False)
                          for e in self.truth)
        self.raw("truth.json", ("[\n" + body + "\n]\n").encode())
