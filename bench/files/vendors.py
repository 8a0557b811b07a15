"""Text files of piezo controllers and displacement sensors.

PI GCS array: header keys after "GCS Array Data Format", SM146E, and the
reader ReadGcsArray.m of PI; record names after the E-712 list of record
options ("Target Position of axis", "Current Position of axis", "Control
Voltage of output chan"). All other makers publish no layout; these files are
recalled or guessed and marked so.
"""
from common import MANUAL, RECALL, Ch, record, rows


def gcs_head(device, n, ts, names, sep=32, note=()):
    head = ["# REM " + device] + ["# REM " + t for t in note]
    head += ["# VERSION = 1", "# TYPE = 1", "# SEPARATOR = %d" % sep,
             "# DIM = %d" % (len(names) or 2)]
    head += ["# SAMPLE_TIME = %.6f" % ts] if ts else []
    head += ["# NDATA = %d" % n]
    head += ["# NAME%d = %s" % (i, s) for i, s in enumerate(names)]
    return head + ["# END_HEADER"]


def pi_gcs(b):
    """Two tables with names; then without; then three tables with tabs."""
    who = "after layout: PI GCS array (DRR?)"
    name = "pi_gcs_named.txt"
    d = record(name, 0.00005).text("%.6f", "%.5f", "%.5f")
    names = ["Control Voltage of Axis1", "Current Position of Axis1"]
    b.lines(name, gcs_head("E-709.CHG", len(d.t), d.ts, names)
            + rows([d.u, d.y], " ", end=" "))
    b.read(name, d, Ch(names[0]), Ch(names[1]),
           "time only as SAMPLE_TIME; names in the head; no units; a blank "
           "ends each row", who, MANUAL)
    name = "pi_gcs_no_names.txt"
    d = record(name, 0.00005).text("%.6f", "%.5f", "%.5f")
    b.lines(name, gcs_head("E-709.CHG", len(d.t), d.ts, [])
            + rows([d.u, d.y], " "))
    b.refuse(name, "no NAME keys", ["which column is the voltage and which "
             "the position"], who, MANUAL, data=d)
    name = "pi_gcs_tabs.dat"
    d = record(name, 0.0002).text("%.6f", "%.5f", "%.5f")
    names = ["Target Position of axis 1", "Current Position of axis 1",
             "Voltage of output chan 1"]
    target = ["%.5f" % (0.11 * float(v)) for v in d.u]
    b.lines(name, gcs_head("E-712", len(d.t), d.ts, names, 9,
                           ["recorded 2024-03-05, 23.4 C"])
            + rows([target, d.y, d.u], "\t"), eol="\r\n")
    b.read(name, d, Ch(names[2]), Ch(names[1]), "separator 9 is a tab; "
           "target position is not the output; output stands before input",
           who, MANUAL)
    name = "pi_gcs_no_sample_time.txt"
    d = record(name, 0.0002).text("%.6f", "%.5f", "%.5f")
    names = ["Control Voltage of output chan 1", "Current Position of axis 1"]
    b.lines(name, gcs_head("E-753", len(d.t), None, names)
            + rows([d.u, d.y], " "))
    b.refuse(name, "names are there, the sample time is not",
             ["sampling period"], who, MANUAL, data=d, u=Ch(names[0]),
             y=Ch(names[1]), ts=None)


def pi_truncated(b):
    """NDATA promises more rows than the file holds (read-out stopped)."""
    name = "pi_gcs_cut.txt"
    d = record(name, 0.00005).text("%.6f", "%.5f", "%.5f")
    names = ["Control Voltage of Axis1", "Current Position of Axis1"]
    b.lines(name, gcs_head("E-709.CHG", 2 * len(d.t), d.ts, names)
            + rows([d.u, d.y], " "))
    b.refuse(name, "NDATA is twice the number of rows: the file is cut",
             ["whether the part that is there will do"],
             "after layout: PI GCS array (DRR?)", MANUAL, data=d,
             u=Ch(names[0]), y=Ch(names[1]),
             also_ok="read what is there and warn")


def jena(b):
    """piezosystem jena NV200/D: data recorder export. Recalled; the real
    export of the NV200 program may differ."""
    name = "jena_nv200_recorder.csv"
    d = record(name).text(kt=1e3, ft="%.3f")
    b.lines(name, ["Time [ms];Piezo voltage [V];Position [µm]"]
            + rows([d.t, d.u, d.y], ";"), "cp1252", "\r\n")
    b.read(name, d, Ch("Piezo voltage [V]", "Piezo voltage", "V"),
           Ch("Position [µm]", "Position", "µm"), "cp1252; time in ms",
           "after layout: piezosystem jena data recorder", RECALL)


def attocube(b):
    """attocube IDS3010 stream as text: positions in pm, no voltage.
    Recalled; the file has axes only."""
    name = "attocube_ids.csv"
    d = record(name, 0.001).text(ky=1e6, fy="%.0f")
    flat = ["%d" % (1000 + i % 7) for i in range(len(d.t))]
    b.lines(name, ["# IDS3010 position stream", "# sample rate 1000 Hz",
                   "Time [s];Axis 1 [pm];Axis 2 [pm];Axis 3 [pm]"]
            + rows([d.t, d.y, flat, flat], ";"))
    b.refuse(name, "three displacements and no voltage", ["the input "
             "voltage, from another file"], "after layout: attocube WAVE",
             RECALL, data=d, y=Ch("Axis 1 [pm]", "Axis 1", "pm"), only="y")


def npoint(b):
    """nPoint nPControl data set: command and sensor, both in um. Guess."""
    name = "npoint_recording.txt"
    d = record(name, 0.000024).text(kt=1e3, ft="%.3f")
    cmd = ["%.4f" % (0.11 * float(v)) for v in d.u]
    b.lines(name, ["Time(ms)\tCh1 Command(um)\tCh1 Sensor(um)"]
            + rows([d.t, cmd, d.y], "\t"))
    b.refuse(name, "closed loop: the only input is a position command in um",
             ["whether the command may stand for the input"],
             "after layout: nPoint nPControl", RECALL, data=None)


def mcl(b):
    """Mad City Labs Nano-Drive waveform read: positions only. Guess."""
    name = "mcl_nanodrive.txt"
    d = record(name)
    b.lines(name, ["%.6f" % v for v in d.y])
    b.refuse(name, "one column of numbers", ["what it is", "the input",
             "sampling period"], "after layout: Mad City Labs waveform read",
             RECALL)


def thorlabs(b):
    """Thorlabs Kinesis BPC303: no file export is documented; people log
    voltage and position by a script. Guess."""
    name = "thorlabs_bpc303.txt"
    d = record(name, 0.05).text("%.3f", "%.4f", "%.4f")
    b.lines(name, ["BPC303 S/N 71000000 Channel 1", "Closed loop: no",
                   "Time(s)\tOutput Voltage(V)\tPosition(um)"]
            + rows([d.t, d.u, d.y], "\t"), eol="\r\n")
    b.read(name, d, Ch("Output Voltage(V)", "Output Voltage", "V"),
           Ch("Position(um)", "Position", "um"),
           "free text lines first; Output Voltage is the input here",
           "after layout: a Kinesis user script", RECALL)


def capacitive(b):
    """Micro-Epsilon style log with a decimal comma and repeated head.
    Guess after the look of sensorTOOL exports."""
    name = "capacitive_sensor_log.csv"
    d = record(name).text()
    body = rows([d.t, d.u, d.y], ";", ",")
    head = "Zeit/s;Piezospannung/V;Abstand/µm"
    half = len(body) // 2
    b.lines(name, [head] + body[:half] + [head] + body[half:], "cp1252",
            "\r\n")
    b.read(name, d, Ch("Piezospannung/V", "Piezospannung", "V"),
           Ch("Abstand/µm", "Abstand", "µm"),
           "the header row comes again in the middle (log restarted)",
           "after layout: a sensor log", RECALL,
           also_ok="refuse and name the row")


def make(b):
    for f in (pi_gcs, pi_truncated, jena, attocube, npoint, mcl, thorlabs,
              capacitive):
        f(b)
