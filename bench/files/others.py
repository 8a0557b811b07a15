"""Other containers: WAV, Parquet, Feather, MDF4, xlsx, LTspice and junk.

Most of these must be declined. The reason and the way out are in truth.json.
"""
import gzip
import io
import json
import pickle
import re
import struct
import zipfile

import numpy as np

from common import HAND, REAL, RECALL, Ch, record

CSV = ["an export as CSV"]
U, Y = Ch("u", unit="V"), Ch("y", unit="um")
DATE = (2024, 3, 5, 14, 7, 8)


def full_scale(name, ts):
    """Record scaled to -1..1, as a sound card would store it."""
    r = record(name, ts)
    r.u, r.y = r.u / 100, r.y / 10
    return r


def riff(kind, rate, bits, data):
    """A two-channel RIFF WAVE file. kind: 1 PCM, 3 IEEE float."""
    block = 2 * bits // 8
    fmt = struct.pack("<HHIIHH", kind, 2, rate, rate * block, block, bits)
    body = b"WAVEfmt " + struct.pack("<I", 16) + fmt
    body += b"data" + struct.pack("<I", len(data)) + data
    return b"RIFF" + struct.pack("<I", len(body)) + body


def wav(b):
    """Multimedia Programming Interface 1.0, IBM and Microsoft, 1991."""
    for bits, kind in ((16, 1), (24, 1), (32, 3)):
        name = "wav_%s%d.wav" % ("float" if kind == 3 else "int", bits)
        r = full_scale(name, 1 / 8000)
        two = np.column_stack([r.u, r.y])
        if kind == 3:
            two = two.astype("<f4")
            data = two.tobytes()
        else:
            two = np.round(two * (2 ** (bits - 1) - 1)).astype("<i4")
            wide = two.view("u1").reshape(-1, 4)[:, :bits // 8]
            data = wide.tobytes()
        r.u, r.y = two[:, 0], two[:, 1]
        b.raw(name, riff(kind, 8000, bits, data))
        b.refuse(name, "two channels without names and units; the values "
                 "here are the stored ones, not divided by full scale",
                 ["which channel is the input", "scale of both channels"],
                 "after layout: RIFF WAVE", HAND, data=r, u=Ch("channel 1"),
                 y=Ch("channel 2"))


def arrow(b):
    """Parquet and Feather by pyarrow; units as field metadata."""
    import pyarrow as pa
    from pyarrow import feather, parquet
    for name in ("table.parquet", "table.feather"):
        r = record(name)
        fields = [pa.field(k, pa.float64(), metadata={"unit": x})
                  for k, x in (("time", "s"), ("voltage", "V"),
                               ("displacement", "um"))]
        table = pa.table([r.t, r.u, r.y], schema=pa.schema(fields))
        if name.endswith("parquet"):
            parquet.write_table(table, b.path(name))
        else:
            feather.write_feather(table, b.path(name), compression="lz4")
        b.read(name, r, Ch("voltage", unit="V"),
               Ch("displacement", unit="um"), "binary column format",
               "pyarrow %s" % pa.__version__, REAL,
               also_ok="refuse and advise an export as CSV")


def mdf4(b):
    """ASAM MDF 4.10 by asammdf. The time in the history block is fixed."""
    from datetime import datetime, timezone
    import asammdf
    name = "asam.mf4"
    r = record(name, 0.001)
    with asammdf.MDF(version="4.10") as m:
        m.start_time = datetime(*DATE, tzinfo=timezone.utc)
        m.append([asammdf.Signal(v, r.t, unit=x, name=k)
                  for k, v, x in (("voltage", r.u, "V"),
                                  ("displacement", r.y, "um"))])
        f = io.BytesIO()
        m.save(f, overwrite=True)
    data = bytearray(f.getvalue())
    for m in re.finditer(b"##FH", bytes(data)):
        data[m.start() + 40:m.start() + 52] = struct.pack(
            "<Qhh", 1709647628 * 10 ** 9, 0, 0)
    b.raw(name, bytes(data))
    b.refuse(name, "MDF4 measurement data of the car industry",
             ["an export as CSV or MAT from the measuring program"],
             "asammdf %s" % asammdf.__version__, REAL, data=r,
             u=Ch("voltage", unit="V"), y=Ch("displacement", unit="um"),
             also_ok="read")


def xlsx(b):
    """Excel workbook by openpyxl, packed again with a fixed date."""
    import openpyxl
    name = "excel_workbook.xlsx"
    r = record(name)
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Time (s)", "Voltage (V)", "Displacement (um)"])
    for row in zip(r.t, r.u, r.y):
        sheet.append([float(v) for v in row])
    f = io.BytesIO()
    book.save(f)
    b.raw(name, fixed_zip(f.getvalue()))
    b.refuse(name, "a workbook is no text file",
             ["save the sheet as CSV in Excel"],
             "openpyxl %s" % openpyxl.__version__, REAL, data=r,
             u=Ch("Voltage (V)", "Voltage", "V"),
             y=Ch("Displacement (um)", "Displacement", "um"),
             also_ok="read")


def fixed_zip(data):
    """The same archive with fixed dates, also in docProps/core.xml."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, \
            zipfile.ZipFile(out, "w") as new:
        for n in old.namelist():
            body = re.sub(rb"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ",
                          b"2024-03-05T14:07:08Z", old.read(n))
            info = zipfile.ZipInfo(n, DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            new.writestr(info, body)
    return out.getvalue()


def ltspice(b):
    """LTspice .raw: UTF-16 LE head, time as f8, traces as f4. Recalled,
    after readers such as ltspice and spicelib."""
    name = "ltspice_tran.raw"
    r = record(name)
    head = ["Title: * piezo driver", "Date: Tue Mar  5 14:07:09 2024",
            "Plotname: Transient Analysis", "Flags: real forward",
            "No. Variables: 3", "No. Points: %12d" % r.n,
            "Offset:   0.0000000000000000e+000", "Command: LTspice XVII",
            "Variables:", "\t0\ttime\ttime", "\t1\tV(piezo)\tvoltage",
            "\t2\tV(x)\tvoltage", "Binary:", ""]
    a = np.zeros(r.n, dtype=[("t", "<f8"), ("u", "<f4"), ("y", "<f4")])
    a["t"], a["u"], a["y"] = r.t, r.u, r.y
    b.raw(name, "\n".join(head).encode("utf-16-le") + a.tobytes())
    r.u, r.y = a["u"], a["y"]
    b.refuse(name, "a simulation; V(x) is a node, not a displacement",
             ["an export as text from LTspice", "which trace is the "
              "displacement"], "after layout: LTspice XVII raw", RECALL,
             data=r, u=Ch("V(piezo)"), y=Ch("V(x)"))


def table_text(name):
    d = record(name).text()
    head = "Time (s),Voltage (V),Displacement (um)"
    return d, "\n".join([head] + [",".join(p) for p in
                                  zip(d.t, d.u, d.y)]) + "\n"


def packed(b):
    """A good CSV in a gzip, in a zip, and in JSON."""
    v, x = Ch("Voltage (V)", "Voltage", "V"), Ch(
        "Displacement (um)", "Displacement", "um")
    name = "packed.csv.gz"
    d, body = table_text(name)
    b.raw(name, gzip.compress(body.encode(), mtime=0))
    b.refuse(name, "a gzip archive", ["unpack it"], "gzip", REAL, data=d,
             u=v, y=x, also_ok="read")
    name = "packed.zip"
    d, body = table_text(name)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as z:
        z.writestr(zipfile.ZipInfo("run7.csv", DATE), body)
    b.raw(name, out.getvalue())
    b.refuse(name, "a zip archive with a CSV in it, not an npz",
             ["unpack it"], "zipfile", REAL, data=d, u=v, y=x,
             also_ok="read")
    name = "arrays.json"
    r = record(name)
    text = json.dumps({k: [float(v) for v in getattr(r, k)] for k in "tuy"})
    b.raw(name, text.encode())
    b.refuse(name, "JSON arrays t, u, y", CSV, "json", REAL, data=r,
             u=Ch("u"), y=Ch("y"), also_ok="read")
    name = "arrays.pkl"
    b.raw(name, pickle.dumps({"t": [0.0, 0.5], "u": [1.0, 2.0]}, 4))
    b.refuse(name, "a pickle runs code when it is read", CSV, "pickle", REAL)


def no_data(b):
    """Files which hold no record at all."""
    cases = (
        ("empty.csv", b"", "zero bytes"),
        ("only_bom.csv", b"\xef\xbb\xbf", "a byte order mark, no more"),
        ("only_header.csv", b"Time (s),Voltage (V),Displacement (um)\r\n",
         "a header and no rows"),
        ("one_row.csv", b"Time (s),Voltage (V),Displacement (um)\n0,1,2\n",
         "one sample gives no sampling period"),
        ("prose.txt", b"Measurement of 5 March 2024.\n\nThe stack was driven "
         b"with 100 V, 3 cycles, and moved 11.2 um.\nData see server, folder "
         b"7.\n", "prose with numbers, no table"),
        ("git_lfs_pointer.csv", b"version https://git-lfs.github.com/spec/v1"
         b"\noid sha256:" + b"4d7a" * 16 + b"\nsize 12345\n",
         "a Git LFS pointer in place of the data"),
        ("error_page.csv", b"<!DOCTYPE html>\n<html><head><title>403 "
         b"Forbidden</title></head>\n<body><h1>Forbidden</h1></body></html>"
         b"\n", "a web page saved as CSV"),
        ("words_only.csv", b"Time (s),Voltage (V),Displacement (um)\n"
         + b"n/a,n/a,n/a\n" * 50, "no cell holds a number"),
    )
    for name, data, why in cases:
        b.raw(name, data)
        b.refuse(name, why, ["a file with data"], "none")


def picture(b):
    """A small baseline JPEG by Pillow, named like a table."""
    from PIL import Image
    f = io.BytesIO()
    shade = (np.add.outer(np.arange(64), np.arange(64)) * 2).astype("u1")
    Image.fromarray(shade).save(f, "JPEG", quality=80)
    b.raw("photo.csv", f.getvalue())
    b.refuse("photo.csv", "a JPEG picture", ["a file with data"], "Pillow",
             REAL)


def damaged(b):
    """Good files which were cut or mixed up on the way."""
    with open(b.path("mat_compressed.mat"), "rb") as f:
        b.raw("mat_cut.mat", f.read()[:-400])
    b.refuse("mat_cut.mat", "the deflated stream ends early",
             ["the whole file"], "scipy savemat, then cut")
    with open(b.path("h5_gzip.h5"), "rb") as f:
        b.raw("h5_cut.h5", f.read()[:3000])
    b.refuse("h5_cut.h5", "the file is shorter than its end address",
             ["the whole file"], "h5py, then cut")
    d, body = table_text("ragged.csv")
    lines = body.splitlines()
    lines[40] = lines[40][:9]
    lines[41] = lines[41] + ",7.7,8.8"
    b.lines("ragged.csv", lines)
    b.refuse("ragged.csv", "row 41 is cut, row 42 has two cells too many",
             ["mend or drop the two rows"], "a script, then damaged")
    d, body = table_text("utf16_no_bom.csv")
    b.raw("utf16_no_bom.csv", body.encode("utf-16-le"))
    b.read("utf16_no_bom.csv", d, Ch("Voltage (V)", "Voltage", "V"),
           Ch("Displacement (um)", "Displacement", "um"),
           "UTF-16 LE without BOM: every second byte is zero", "a script",
           also_ok="refuse and name the encoding")


def make(b):
    """Packages which are missing leave their files out, with a note."""
    for f in (wav, arrow, mdf4, xlsx, ltspice, packed, no_data, picture,
              damaged):
        try:
            f(b)
        except ImportError as e:
            print("left out: %s (%s)" % (f.__name__, e))
