"""Files that should be refused."""

from common import *


def refuse():

    r = rec(0.001)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "132_two_voltages_same_name.csv",
        "ambiguous",
        text(["Time (s),Voltage (V),Voltage (V),Displacement (um)"] + rows(",", t, u, S("%.3f", r.u * 0.98 + 0.3), y)),
        X,
        0.001,
        [],
        [],
        "two different channels of the same name Voltage (V)",
    )
    r = rec(0.001)
    t, u, y = S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)
    add(
        "133_command_monitor.csv",
        "ambiguous",
        text(
            ["Time (s),Command voltage (V),Monitor voltage (V),Displacement (um)"]
            + rows(",", S("%.3f", r.t), S("%.4f", r.u / 20), S("%.4f", r.u / 20 * 0.99), y)
        ),
        X,
        0.001,
        [],
        [],
        "command and monitor voltage both there",
    )
    r = rec(0.001)
    r2 = rec(0.001, n=r.n)
    add(
        "134_xy_stage.csv",
        "ambiguous",
        text(
            ["t_s,Vx_V,Vy_V,Px_um,Py_um"]
            + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.3f", r2.u), S("%.4f", r.y), S("%.4f", r2.y))
        ),
        X,
        0.001,
        [],
        [],
        "two axes, both driven",
    )
    r = rec(0.001)
    add(
        "135_two_sensors.csv",
        "ambiguous",
        text(
            ["Time [s];Piezo [V];Sensor 1 [µm];Sensor 2 [µm]"]
            + rows(";", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y), S("%.4f", r.y * 0.8 + 0.3))
        ),
        X,
        0.001,
        [],
        [],
        "two sensors, neither preferred",
    )
    r = rec(0.001)
    add(
        "136_velocity.csv",
        "no-output",
        text(
            ["Zeit (s);Spannung (V);Geschwindigkeit (mm/s)"]
            + rows(";", C(S("%.3f", r.t)), C(S("%.3f", r.u)), C(S("%.4f", np.gradient(r.y, r.ts) / 1e3)))
        ),
        X,
        0.001,
        [],
        [],
        "velocity, no displacement",
    )
    r = rec(0.001)
    add(
        "137_no_time.csv",
        "no-rate",
        text(["voltage [V],displacement [µm]"] + rows(",", S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "no time and no rate",
    )
    r = rec(0.001)
    add(
        "138_index_only.csv",
        "no-rate",
        text(
            ["# Hysterese Piezo 3, 4.5.2022", "Sample;Spannung (V);Weg (µm)"]
            + rows(";", [str(i) for i in range(r.n)], S("%.3f", r.u), S("%.4f", r.y))
        ),
        X,
        None,
        [],
        [],
        "sample number, rate nowhere",
    )
    r = rec(0.001)
    a = r.n // 2
    tt = r.t.copy()
    tt[a:] += 0.857
    add(
        "139_gap.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.3f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "a gap of 0.857 s in the middle at 1 ms steps",
    )
    r = rec(0.001)
    tt = r.t.copy()
    k = r.n // 2
    tt[k:] -= tt[k]
    add(
        "140_two_runs.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.3f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "two runs in one table, time starts again at 0",
    )
    r = rec(0.01)
    tt = np.cumsum(r.g.exponential(0.01, r.n))
    add(
        "141_random_times.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", S("%.5f", tt), S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "random sampling instants (exponential gaps)",
    )
    r = rec(0.001)
    add(
        "142_time_stuck.csv",
        "bad-time",
        text(["time (s),voltage (V),displacement (um)"] + rows(",", ["12.000"] * r.n, S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "time is the same in all rows",
    )
    r = rec(0.1)
    iso = [(dt.datetime(2023, 6, 1, 10, 0, 0) + dt.timedelta(seconds=float(v))).strftime("%d.%m.%Y %H:%M") for v in r.t]
    add(
        "143_clock_minutes.csv",
        "bad-time",
        text(["Zeitstempel;Spannung [V];Weg [µm]"] + rows(";", iso, S("%.3f", r.u), S("%.4f", r.y))),
        X,
        None,
        [],
        [],
        "Excel showed the time stamps to minutes only: the step is lost",
    )
    r = rec(0.001)
    add("144_one_column.txt", "no-data", text(S("%.5f", r.y)), X, None, [], [], "one column")
    add("145_empty.csv", "no-data", b"", X, None, [], [], "empty file")
    add(
        "146_header_only.csv",
        "no-data",
        text(["Zeit [s];Spannung [V];Weg [µm]"], "cp1252", "\r\n"),
        X,
        None,
        [],
        [],
        "header only",
    )
    add(
        "147_download.csv",
        "not-data",
        b"<!DOCTYPE html>\n<html><head><title>Login</title></head><body>\n<h1>401 Unauthorized</h1>\n<table><tr><td>1</td><td>2</td><td>3</td></tr></table>\n<p>Session expired, please sign in.</p>\n</body></html>\n"
        * 3,
        X,
        None,
        [],
        [],
        "HTML login page saved as csv",
    )
    add(
        "148_settings.json",
        "not-data",
        json.dumps(
            {
                "sample_rate": 1000,
                "channels": [
                    {"name": "voltage", "unit": "V", "range": [0, 100]},
                    {"name": "displacement", "unit": "um", "range": [0, 12]},
                ],
                "time": "2023-01-01T10:00:00",
            },
            indent=1,
        ).encode(),
        X,
        None,
        [],
        [],
        "JSON settings without data",
    )
    bio = io.BytesIO()
    with zipfile.ZipFile(bio, "w") as z:
        z.writestr("readme.txt", "see run1.csv, run2.csv")
        for k in (1, 2):
            r = rec(0.001)
            z.writestr(
                "run%d.csv" % k, "\n".join(["t_s,u_V,y_um"] + rows(",", S("%.3f", r.t), S("%.3f", r.u), S("%.4f", r.y)))
            )
    add("149_runs.zip", "not-data", bio.getvalue(), X, None, [], [], "zip with two runs")
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig = plt.figure(figsize=(3, 2))
    plt.plot([0, 1], [0, 1])
    plt.savefig(path("tmp.png"), dpi=60)
    plt.close(fig)
    os.rename(path("tmp.png"), path("150_plot.csv"))
    add("150_plot.csv", "not-data", None, X, None, [], [], "a PNG named csv")
    g = np.random.default_rng(1)
    add(
        "151_dump.dat", "not-data", g.integers(0, 256, 9000).astype(np.uint8).tobytes(), X, None, [], [], "random bytes"
    )
    add("152_nulls.csv", "not-data", b"\0" * 12288, X, None, [], [], "preallocated file of NUL bytes after a crash")
