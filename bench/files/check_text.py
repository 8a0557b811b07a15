"""Options by hand for the text files, for check.py.

skip: lines before the data. cols: columns of time, input, output (time None
when the file has none). k: seconds per unit of the time column. ts: period
as it stands in the head, copied by hand. stamp: time is a date or clock.
"""
import csv

import numpy as np
import pandas as pd

TUY = (0, 1, 2)
NA = ["OVER", "---", "∞"]


def read_table(path, skip=1, cols=TUY, sep=",", dec=".", enc="utf-8", k=1.0,
               ts=None, stamp=False, rows=None, thousands=None, swap=None,
               strip=False):
    """Read by pandas; all cells as text first, then to numbers."""
    t = pd.read_csv(path, sep=sep, skiprows=skip, header=None, encoding=enc,
                    engine="python", dtype=str, nrows=rows,
                    skip_blank_lines=True, keep_default_na=True,
                    na_values=NA, skipinitialspace=True,
                    names=range(24) if strip else None)
    def num(i):
        s = t[i].str.strip()
        if thousands:
            s = s.str.replace(thousands, "", regex=False)
        if swap:
            s = s.str.replace(swap, "E", regex=False)
        return s.str.replace(dec, ".", regex=False).astype(float).to_numpy()
    it, iu, iy = cols
    if stamp:
        when = pd.to_datetime(t[it], utc=True).dt.tz_localize(None)
        ts = float(np.median(np.diff(when) / np.timedelta64(1, "ns"))) * 1e-9
    elif it is not None:
        ts = float(np.median(np.diff(num(it)))) * k
    return (ts, num(iu) if iu is not None else [],
            num(iy) if iy is not None else [])


def opt(**kw):
    return kw


P = opt()
DE = opt(sep=";", dec=",")
TABLES = {name: P for name in (
    "csv_plain.csv", "excel_utf8_bom.csv", "csv_micro_b5.csv",
    "csv_greek_mu.csv", "csv_crlf.csv", "csv_cr_only.csv",
    "csv_no_last_newline.csv", "csv_quoted_all.csv",
    "csv_trailing_delimiter.csv", "csv_plus_signs.csv", "csv_upper_case.csv",
    "csv_mixed_case.csv", "csv_kilovolt_nm.csv", "csv_units_comma.csv",
    "csv_drive_sensor_volts.csv", "csv_two_actuators.csv", "csv_gap_nan.csv",
    "csv_gap_empty_cells.csv", "csv_gap_over_na.csv", "csv_gap_dashes.csv",
    "csv_time_jump.csv", "matlab_writetable.csv", "rigol_dho800.csv",
    "rs_rtb2000.csv", "packed.csv.gz", "packed.zip")}
TABLES.update({
    "excel_german_cp1252.csv": opt(sep=";", dec=",", enc="cp1252"),
    "excel_unicode_text.txt": opt(sep="\t", dec=",", enc="utf-16"),
    "excel_sep_line.csv": opt(skip=2, sep=";"),
    "libreoffice_comma_quoted.csv": opt(dec=","),
    "csv_thousands_de.csv": opt(sep=";", dec=",", thousands="."),
    "csv_thousands_us.csv": opt(thousands=","),
    "csv_thousands_fr_nbsp.csv": opt(sep=";", dec=",", thousands="\u202f"),
    "fortran_d_exponent.txt": opt(sep=r"\s+", swap="D"),
    "csv_exponent_comma.csv": DE,
    "csv_blank_lines.csv": opt(skip=2),
    "columns_aligned.dat": opt(sep=r"\s+"),
    "pandas_index.csv": opt(cols=(1, 2, 3)),
    "numpy_savetxt_header.txt": opt(sep=" "),
    "numpy_savetxt_bare.txt": opt(skip=0, sep=" "),
    "matlab_writematrix.txt": opt(skip=0),
    "r_write_csv.csv": opt(cols=(1, 2, 3)),
    "csv_unit_row.csv": opt(skip=2),
    "csv_unit_row_brackets.csv": opt(skip=2, sep=";", k=1e-3),
    "csv_two_header_rows.csv": opt(skip=3),
    "csv_units_slash.csv": opt(sep=";"),
    "csv_german.csv": DE, "csv_french_utf8.csv": DE,
    "csv_french_cp1252.csv": opt(sep=";", dec=",", enc="cp1252"),
    "csv_y_before_u.csv": opt(cols=(0, 2, 1)),
    "csv_time_last.csv": opt(sep="\t", cols=(2, 1, 0)),
    "csv_hash_comments.csv": opt(skip=4),
    "csv_percent_comments.txt": opt(skip=3, sep=r"\s+"),
    "csv_key_value_head.csv": opt(skip=5),
    "csv_extra_columns.csv": opt(cols=(0, 3, 4)),
    "csv_setpoint_measured.csv": opt(cols=(0, 3, 2)),
    "csv_command_and_monitor.csv": opt(cols=(0, 2, 3)),
    "csv_no_header_2col.csv": opt(skip=0, cols=(None, 0, 1)),
    "csv_no_header_3col.csv": opt(skip=0),
    "csv_iso_ms.csv": opt(stamp=True), "csv_iso_us.csv": opt(stamp=True),
    "csv_iso_zone.csv": opt(stamp=True),
    "csv_iso_too_coarse.csv": opt(cols=(None, 1, 2)),
    "csv_time_ms.csv": opt(k=1e-3), "csv_time_us.csv": opt(k=1e-6),
    "csv_sample_rate_comment.csv": opt(skip=2, k=1 / 2000),
    "csv_sample_number.csv": opt(cols=(None, 1, 2)),
    "utf16_no_bom.csv": opt(enc="utf-16-le"),
    "tek_tds/F0003CH1.CSV": opt(skip=0, cols=(3, 4, None)),
    "tek_tds/F0003CH2.CSV": opt(skip=0, cols=(3, None, 4)),
    "tek_mso_labels.csv": opt(skip=21), "tek_mso_plain.csv": opt(skip=21),
    "keysight_infiniivision.csv": opt(skip=2),
    "keysight_benchvue.csv": opt(skip=6),
    "rigol_ds1000z.csv": opt(skip=2, cols=(0, 1, 2), k=0.0005),
    "rigol_mso5000.csv": opt(cols=(None, 0, 1), ts=0.0005),
    "siglent_x_u.csv": opt(skip=12), "siglent_screen.csv": opt(skip=2),
    "siglent_bin2csv.csv": opt(skip=6, cols=(0, 1, None)),
    "picoscope_channels.csv": opt(skip=3, k=1e-3),
    "picoscope_named.csv": opt(skip=3, k=1e-3),
    "picoscope_over_range.csv": opt(skip=3, k=1e-3),
    "lecroy_C1Trace00000.txt": opt(skip=5, cols=(0, 1, None)),
    "yokogawa_dlm.csv": opt(skip=15, cols=(None, 1, 2), ts=0.0005),
    "yokogawa_dl1540.csv": opt(skip=16, cols=(None, 0, 1), ts=1 / 2000),
    "hioki_8807.txt": opt(skip=9),
    "digilent_waveforms_channels.csv": opt(skip=10),
    "digilent_waveforms_named.csv": opt(skip=10),
    "analog_discovery_logger.txt": opt(skip=7, sep="\t"),
    "red_pitaya_stream.csv": opt(cols=(None, 0, 1)),
    "moku_data_logger.csv": opt(skip=8),
    "labone_demod.csv": opt(sep=";", cols=(1, 2, 3), k=1 / 60e6),
    "labview_one.lvm": opt(skip=23, sep="\t"),
    "labview_no.lvm": opt(skip=23, sep="\t", cols=(None, 1, 2), ts=0.0005),
    "labview_multi.lvm": opt(skip=23, sep="\t", cols=(0, 1, 3)),
    "labview_comma.lvm": opt(skip=23, sep="\t", dec=","),
    "labview_untitled.lvm": opt(skip=23, sep="\t"),
    "ni_signalexpress.txt": opt(skip=7, sep="\t", cols=(None, 0, 1),
                                ts=0.0005),
    "labview_export_waveforms.txt": opt(skip=5, sep="\t", cols=(None, 1, 3)),
    "dspace_controldesk.csv": opt(skip=5, sep=";"),
    "hbm_catman.asc": opt(sep="\t", dec=",", enc="cp1252"),
    "dewesoft_export.txt": opt(skip=9, sep="\t"),
    "polytec_vibsoft.txt": opt(skip=5, sep="\t", cols=(0, 2, 1)),
    "pi_gcs_named.txt": opt(skip=10, sep=" ", cols=(None, 0, 1), ts=5e-5),
    "pi_gcs_no_names.txt": opt(skip=8, sep=" ", cols=(None, 0, 1)),
    "pi_gcs_tabs.dat": opt(skip=12, sep="\t", cols=(None, 2, 1), ts=2e-4),
    "pi_gcs_no_sample_time.txt": opt(skip=9, sep=" ", cols=(None, 0, 1)),
    "pi_gcs_cut.txt": opt(skip=10, sep=" ", cols=(None, 0, 1), ts=5e-5),
    "jena_nv200_recorder.csv": opt(sep=";", enc="cp1252", k=1e-3),
    "attocube_ids.csv": opt(skip=3, sep=";", cols=(0, None, 1)),
    "thorlabs_bpc303.txt": opt(skip=3, sep="\t"),
})


def clock(path):
    """csv_clock_midnight.csv: seconds of the day, unwrapped."""
    with open(path, encoding="utf-8") as f:
        body = list(csv.reader(f))[1:]
    t = [sum(float(p) * w for p, w in zip(r[0].split(":"), (3600, 60, 1)))
         for r in body]
    t = np.unwrap(t, period=86400)
    return (float(np.median(np.diff(t))), [float(r[1]) for r in body],
            [float(r[2]) for r in body])


def footer(path):
    with open(path, encoding="utf-8") as f:
        n = f.read().split("\n\n")[0].count("\n")
    return read_table(path, rows=n)


def doubled_head(path):
    with open(path, encoding="cp1252") as f:
        body = [r for r in csv.reader(f, delimiter=";")
                if not r[0].startswith("Zeit")]
    a = np.array([[float(c.replace(",", ".")) for c in r] for r in body])
    return float(np.median(np.diff(a[:, 0]))), a[:, 1], a[:, 2]


def field_rows(path):
    with open(path, encoding="utf-8") as f:
        r = {line[3]: np.array(line[4:], float)
             for line in list(csv.reader(f, delimiter=";"))[1:]}
    return (float(np.median(np.diff(r["grid"]))), r["auxin0"], r["auxin1"])


def special_text(path, name):
    """Files for which pandas options alone will not do."""
    readers = {"csv_clock_midnight.csv": clock, "csv_footer.csv": footer,
               "capacitive_sensor_log.csv": doubled_head,
               "labone_rows.csv": field_rows}
    return readers[name](path) if name in readers else None
