"""Read the files back with other libraries and compare with truth.json.

Usage: python3 check.py DIR

Text files are read by pandas with options given by hand in check_text.py.
Binary files are read by scipy, numpy, h5py, npTDMS, pyarrow, asammdf,
openpyxl and scipy.io.wavfile. Nothing is guessed here.
"""
import json
import os
import sys
import wave

import h5py
import numpy as np
import pandas as pd
from nptdms import TdmsFile
from scipy.io import loadmat, wavfile

from check_text import TABLES, read_table, special_text


def step(t):
    return float(np.median(np.diff(np.asarray(t, float).ravel())))


def mat(path, get):
    m = loadmat(path, squeeze_me=True, struct_as_record=False)
    return get(m)


MAT = {
    "mat_column.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_row.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_compressed.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_v4.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_v4_big_endian.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_single.mat": lambda m: (step(m["t"]), m["u"], m["y"]),
    "mat_int16.mat": lambda m: (1 / m["fs"], m["u"], m["y"]),
    "mat_fs_names.mat": lambda m: (1 / m["fs"], m["voltage"],
                                   m["position"]),
    "mat_matrix_3col.mat": lambda m: (step(m["data"][:, 0]),
                                      *m["data"][:, 1:].T),
    "mat_struct.mat": lambda m: (step(m["data"].t), m["data"].u,
                                 m["data"].y),
    "mat_nested.mat": lambda m: (
        step(m["meas"].time), m["meas"].signals.voltage.values,
        m["meas"].signals.displacement.values),
    "mat_three_runs.mat": lambda m: (step(m["run"][0].t), m["run"][0].u,
                                     m["run"][0].y),
    "mat_iddata_struct.mat": lambda m: (m["z"].Ts, m["z"].InputData,
                                        m["z"].OutputData),
    "mat_simulink_struct_time.mat": lambda m: (
        step(m["ScopeData"].time), m["ScopeData"].signals[0].values,
        m["ScopeData"].signals[1].values),
    "dspace_run7.mat": lambda m: (
        step(m["dspace_run7"].X[0].Data), m["dspace_run7"].Y[1].Data,
        m["dspace_run7"].Y[2].Data),
}

H5 = {
    "mat_v73.mat": lambda f: (step(f["t"]), f["u"][0], f["y"][0]),
    "mat_v73_struct.mat": lambda f: (step(f["data/time"]),
                                     f["data/voltage"][0],
                                     f["data/displacement"][0]),
    "mat_v73_hdf5storage.mat": lambda f: (step(f["t"]), np.ravel(f["u"]),
                                          np.ravel(f["y"])),
    "h5_root.h5": lambda f: (step(f["t"]), f["u"], f["y"]),
    "h5_gzip.h5": lambda f: (step(f["t"]), f["u"], f["y"]),
    "h5_lzf.h5": lambda f: (step(f["t"]), f["u"], f["y"]),
    "h5_latest.hdf5": lambda f: (step(f["t"]), f["u"], f["y"]),
    "h5_groups.h5": lambda f: (
        step(f["measurement/run7/time"]), f["measurement/run7/voltage"],
        f["measurement/run7/displacement"]),
    "h5_two_runs.h5": lambda f: (step(f["run1/t"]), f["run1/u"],
                                 f["run1/y"]),
    "h5_compound.h5": lambda f: (step(f["log"]["time"]), f["log"]["voltage"],
                                 f["log"]["displacement"]),
    "h5_matrix_columns.h5": lambda f: (
        step(f["data"][:, 0]), f["data"][:, 2], f["data"][:, 1]),
    "h5_rate_attribute.h5": lambda f: (1 / f.attrs["sampling_rate_Hz"],
                                       f["voltage"], f["displacement"]),
    "h5_dimension_scale.h5": lambda f: (step(f["voltage"].dims[0][0]),
                                        f["voltage"], f["position"]),
    "h5_no_time.h5": lambda f: (None, f["u"], f["y"]),
}


def npz3(z, t="t", u="u", y="y"):
    return step(z[t]), z[u], z[y]


NUMPY = {
    "npy_2d.npy": lambda a: (step(a[:, 0]), a[:, 1], a[:, 2]),
    "npy_fortran.npy": lambda a: (step(a[:, 0]), a[:, 1], a[:, 2]),
    "npy_3rows.npy": lambda a: (step(a[0]), a[1], a[2]),
    "npy_structured.npy": lambda a: npz3(a, "time", "voltage",
                                         "displacement"),
    "npy_structured_big_endian.npy": lambda a: npz3(
        a, "time_s", "voltage_V", "displacement_um"),
    "npy_structured_latin1.npy": lambda a: npz3(a, "Zeit_s", "Spannung_V",
                                                "Weg_\u00b5m"),
    "npy_structured_utf8.npy": lambda a: npz3(a, "Zeit_s", "Spannung_V",
                                              "Weg_\u03bcm"),
    "npz_tuy.npz": npz3,
    "npz_compressed_float32.npz": lambda z: npz3(z, "time", "voltage",
                                                 "displacement"),
    "npz_fs.npz": lambda z: (1 / z["fs"], z["u"], z["y"]),
    "npz_columns.npz": lambda z: (step(z["data"][:, 0]), z["data"][:, 1],
                                  z["data"][:, 2]),
    "npz_no_time.npz": lambda z: (None, z["u"], z["y"]),
}


def tdms(path, truth):
    """The header says Group/Channel. Time by wf_increment or a channel."""
    f = TdmsFile.read(path)
    group = truth["u_header"].split("/")[0]
    ch = f[group]
    u, y = ch[truth["u_name"]], ch[truth["y_name"]]
    names = [c.name for c in ch.channels()]
    if "wf_increment" in u.properties:
        ts = u.properties["wf_increment"]
    elif "Time" in names:
        ts = step(ch["Time"][:])
    elif "Timestamp" in names:
        t = ch["Timestamp"][:]
        ts = step((t - t[0]) / np.timedelta64(1, "us")) * 1e-6
    else:
        ts = None
    if u.properties.get("unit_string", "") != truth["u_unit"]:
        raise ValueError("unit_string")
    return ts, u[:], y[:]


def wav24(path):
    with wave.open(path) as w:
        raw = np.frombuffer(w.readframes(w.getnframes()), "u1")
        v = raw.reshape(-1, 3).astype("i4")
        v = v[:, 0] | v[:, 1] << 8 | v[:, 2] << 16
        v = np.where(v >= 1 << 23, v - (1 << 24), v).reshape(-1, 2)
        return 1 / w.getframerate(), v[:, 0], v[:, 1]


def other(path, name):
    if name == "wav_int24.wav":
        return wav24(path)
    if name.endswith(".wav"):
        fs, a = wavfile.read(path)
        return 1 / fs, a[:, 0], a[:, 1]
    if name in ("table.parquet", "table.feather"):
        f = pd.read_parquet if "parquet" in name else pd.read_feather
        t = f(path)
        return step(t.time), t.voltage, t.displacement
    if name == "excel_workbook.xlsx":
        t = pd.read_excel(path).to_numpy()
        return step(t[:, 0]), t[:, 1], t[:, 2]
    if name == "asam.mf4":
        import asammdf
        with asammdf.MDF(path) as m:
            u, y = m.get("voltage"), m.get("displacement")
        return step(u.timestamps), u.samples, y.samples
    if name == "diadem/diadem.dat":
        a = np.fromfile(path.replace(".dat", ".r64")).reshape(2, -1)
        return 0.0005, a[0], a[1]
    return None


def fetch(folder, e):
    """(ts, u, y) by an independent reader, or None when there is none."""
    name, path = e["file"], os.path.join(folder, e["file"])
    if name in TABLES:
        return read_table(path, **TABLES[name])
    if name in MAT:
        return mat(path, MAT[name])
    if name in H5:
        with h5py.File(path) as f:
            ts, u, y = H5[name](f)
            return ts, np.array(u), np.array(y)
    if name in NUMPY:
        return NUMPY[name](np.load(path))
    if name.endswith(".tdms") and e["u"]:
        return tdms(path, e)
    found = other(path, name)
    return found if found is not None else special_text(path, name)


TEXT = ("csv_files", "csv_heads", "scopes", "scopes2", "loggers", "vendors")


def names_stand(folder, e):
    """The names and units of a text file occur in its bytes as written."""
    if e["family"] not in TEXT:
        return True
    with open(os.path.join(folder, e["file"]), "rb") as f:
        data = f.read()
    words = [e[c + k] for c in "uy" for k in ("_header", "_name", "_unit")]
    return any(all(w.encode(enc, "replace") in data for w in words)
               for enc in ("utf-8", "cp1252", "utf-16-le"))


def same(got, want):
    got = [float(v) for v in np.ravel(got)]
    if len(got) != len(want):
        return False
    return all(w is None or abs(g - w) <= 1e-12 * max(1.0, abs(w))
               for g, w in zip(got, want)) and all(
        np.isnan(g) or np.isinf(g) for g, w in zip(got, want) if w is None)


def main(folder):
    with open(os.path.join(folder, "truth.json"), encoding="utf-8") as f:
        truth = json.load(f)
    good, skipped, bad = 0, [], []
    for e in truth:
        if not names_stand(folder, e):
            bad.append(e["file"] + ": a name or unit is not in the file")
        try:
            got = fetch(folder, e)
        except Exception as x:
            bad.append("%s: %r" % (e["file"], x))
            continue
        if got is None:
            skipped.append(e["file"])
            continue
        ts, u, y = got
        ok_ts = ts is None or e["ts"] is None or abs(
            ts / e["ts"] - 1) < 1e-4
        ok = [ok_ts] + [w == [] or same(g, w) for g, w in
                        ((u, e["u"]), (y, e["y"]))]
        if all(ok):
            good += 1
        else:
            bad.append("%s: ts, u, y %s" % (e["file"], ok))
    print("agree: %d, differ: %d, no reader here: %d"
          % (good, len(bad), len(skipped)))
    print("no reader:", ", ".join(skipped))
    for line in bad:
        print("DIFFERS", line)
    return len(bad)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
