"""Text files of measuring programs: LabVIEW, dSPACE, DIAdem, catman and kin.

LVM: "Specification for the LabVIEW Measurement File (.lvm)", ni.com 4139,
and files quoted in public code. Others: see the functions.
"""
import numpy as np

from common import RECALL, SEEN, Ch, record, rows

END = "***End_of_Header***"
LVM = "after layout: LabVIEW Write To Measurement File, LVM 2.0"


def lvm_head(columns, dec=".", multi="No"):
    return ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2",
            "Separator\tTab", "Decimal_Separator\t" + dec,
            "Multi_Headings\t" + multi, "X_Columns\t" + columns,
            "Time_Pref\tRelative", "Operator\tlab", "Date\t2024/03/05",
            "Time\t14:07:09%s4949688911437988282" % dec, END + "\t", "\t"]


def lvm_segment(n, ts, names, units, gap="", dec="."):
    """Segment head. gap: an extra tab between channels when X is doubled."""
    def line(tag, values):
        return tag + "\t" + ("\t" + gap).join(values) + "\t"
    zero = "0%s0000000000000000E+0" % dec
    x = "X_Value\t"
    title = x + ("\t" + x if gap else "\t").join(names) + "\tComment"
    return ["Channels\t2" + "\t" * 3, line("Samples", [str(n)] * 2),
            line("Date", ["2024/03/05"] * 2),
            line("Time", ["14:07:09%s49" % dec] * 2),
            line("Y_Unit_Label", units), line("X_Dimension", ["Time"] * 2),
            line("X0", [zero] * 2),
            line("Delta_X", [("%.6f" % ts).replace(".", dec)] * 2),
            END + "\t\t\t", title]


def lvm(b):
    """The three forms of X_Columns, and the decimal comma."""
    names, units = ("Drive voltage", "Displacement"), ("Volts", "um")
    u, y = Ch(names[0], unit="Volts"), Ch(names[1], unit="um")
    cases = (("one", "One", "", ".", "time once, then the channels"),
             ("no", "No", "", ".", "no time values: first column is empty, "
              "Delta_X gives the time"),
             ("multi", "Multi", "\t", ".", "a time column before each "
              "channel"),
             ("comma", "One", "", ",", "decimal comma, told by the head"))
    for tag, xc, gap, dec, why in cases:
        name = "labview_%s.lvm" % tag
        d = record(name).text("%.6f", "%.6f", "%.6f")
        cols = {"One": [d.t, d.u, d.y], "Multi": [d.t, d.u, d.t, d.y],
                "No": [[""] * len(d.t), d.u, d.y]}[xc]
        b.lines(name, lvm_head(xc, dec)
                + lvm_segment(len(d.t), d.ts, names, units, gap, dec)
                + rows(cols, "\t", dec), eol="\r\n")
        b.read(name, d, u, y, why, LVM, SEEN)


def lvm_hard(b):
    """Several segments in one file, and the names DAQ Assistant gives."""
    name = "labview_two_segments.lvm"
    d = record(name).text("%.6f", "%.6f", "%.6f")
    half = len(d.t) // 2
    out = lvm_head("One", multi="Yes")
    for s in (slice(0, half), slice(half, 2 * half)):
        out += lvm_segment(half, d.ts, ("Drive voltage", "Displacement"),
                           ("Volts", "um"))
        out += rows([d.t[:half], d.u[s], d.y[s]], "\t") + [""]
    b.lines(name, out, eol="\r\n")
    b.refuse(name, "two segments, both start at time 0; the gap between "
             "them is unknown", ["which segment"], LVM, SEEN)
    name = "labview_untitled.lvm"
    d = record(name).text("%.6f", "%.6f", "%.6f", ku=0.1, ky=0.1)
    b.lines(name, lvm_head("One") + lvm_segment(len(d.t), d.ts, (
        "Voltage", "Voltage_0"), ("Volts", "Volts"))
        + rows([d.t, d.u, d.y], "\t"), eol="\r\n")
    b.refuse(name, "default names Voltage and Voltage_0, both in volts",
             ["which channel is the displacement sensor", "sensor scale"],
             LVM, SEEN, data=d, u=Ch("Voltage", unit="Volts"),
             y=Ch("Voltage_0", unit="Volts"))


def ni_spreadsheets(b):
    """SignalExpress ASCII log, and LabVIEW "Export Waveforms To Spreadsheet
    File". Both recalled; no example was at hand."""
    name = "ni_signalexpress.txt"
    d = record(name).text("%.6f", "%.6f", "%.6f")
    b.lines(name, ["channel names:", "Drive voltage (V)\tDisplacement (um)",
                   "start times:", "3/5/2024 14:07:09.494\t"
                   "3/5/2024 14:07:09.494", "dt:", "0.000500\t0.000500",
                   "data:"] + rows([d.u, d.y], "\t"), eol="\r\n")
    b.read(name, d, Ch("Drive voltage (V)", "Drive voltage", "V"),
           Ch("Displacement (um)", "Displacement", "um"),
           "no time column: dt stands in the head",
           "after layout: NI SignalExpress text log", RECALL)
    name = "labview_export_waveforms.txt"
    d = record(name).text("%.6f", "%.6f", "%.6f", ku=0.1, ky=0.1)
    stamp = ["05.03.2024 14:07:%07.4f" % (9 + float(t)) for t in d.t]
    b.lines(name, ["waveform\t[0]\t\t[1]", "t0\t05.03.2024 14:07:09\t\t"
                   "05.03.2024 14:07:09", "delta t\t0.000500\t\t0.000500",
                   "", "time[0]\tY[0]\ttime[1]\tY[1]"]
            + rows([stamp, d.u, stamp, d.y], "\t"), eol="\r\n")
    b.refuse(name, "channels are called [0] and [1]",
             ["which channel is the displacement", "units", "scales"],
             "after layout: LabVIEW Export Waveforms To Spreadsheet", RECALL,
             data=d, u=Ch("Y[0]"), y=Ch("Y[1]"))


def controldesk(b):
    """dSPACE ControlDesk CSV export. Recalled and doubtful: real exports
    carry more head rows. The names are model paths."""
    name = "dspace_controldesk.csv"
    d = record(name, 0.001).text("%.6f", "%.9g", "%.9g")
    path = "Model Root/Piezo/"
    b.lines(name, ["descr;ControlDesk measurement export",
                   "date;2024-03-05 14:07:09",
                   "name;%su_piezo[V];%sx_meas[um]" % (path, path),
                   "unit;V;um", "trace_values"]
            + rows([d.t, d.u, d.y], ";"), eol="\r\n")
    b.read(name, d, Ch(path + "u_piezo[V]", "u_piezo", "V"),
           Ch(path + "x_meas[um]", "x_meas", "um"),
           "rows descr, name, unit; data after trace_values; time unnamed",
           "after layout: dSPACE ControlDesk CSV", RECALL)


def diadem(b):
    """DIAdem .dat head with .r64 values. Keys 200 (name), 202 (unit), 210,
    211, 213, 214, 220, 221, 240, 241 as in dmheader.pdf of NI and in public
    readers; Kvaser's writer shows the implicit time channel."""
    r = record("diadem")
    n = r.n
    head = ["DIAEXTENDED {@:ENGLISH", "#BEGINGLOBALHEADER", "1,WINDOWS32",
            "101,Piezo run 7", "104,05.03.2024", "105,14:07:09",
            "110,DD.MM.YYYY hh:nn:ss", "111,9.9E+34", "112,Low -> High",
            "#ENDGLOBALHEADER", "#BEGINCHANNELHEADER", "200,Time", "201,",
            "202,s", "210,IMPLICIT", "220,%d" % n, "240,0", "241,0.0005",
            "260,Numeric", "#ENDCHANNELHEADER"]
    for k, (ch, unit) in enumerate((("Voltage", "V"), ("Travel", "µm"))):
        head += ["#BEGINCHANNELHEADER", "200," + ch, "201,", "202," + unit,
                 "210,EXPLICIT", "211,diadem.r64", "213,CHANNEL",
                 "214,REAL64", "220,%d" % n, "221,%d" % (1 + k * n), "240,0",
                 "241,1", "260,Numeric", "#ENDCHANNELHEADER"]
    b.lines("diadem/diadem.dat", head, "cp1252", "\r\n")
    b.raw("diadem/diadem.r64", np.concatenate([r.u, r.y]).astype("<f8")
          .tobytes())
    who = "after layout: NI DIAdem DAT"
    b.refuse("diadem/diadem.dat", "a text head only; the values are in "
             "diadem.r64", ["an export from DIAdem as CSV or TDMS"], who,
             SEEN, data=r, u=Ch("Voltage", unit="V"),
             y=Ch("Travel", unit="µm"), also_ok="read with diadem.r64")
    b.refuse("diadem/diadem.r64", "bare doubles; the head is in diadem.dat",
             ["an export from DIAdem as CSV or TDMS"], who, SEEN)


def catman(b):
    """HBM catman ASCII, German region. Seen: column title "Zeit  1 -
    Standardmessrate [s]" (two blanks) in public code that reads exports."""
    name = "hbm_catman.asc"
    d = record(name).text("%.4f", "%.6E", "%.6E")
    b.lines(name, ["Zeit  1 - Standardmessrate [s]\tU_Aktor [V]\tWeg [µm]"]
            + rows([d.t, d.u, d.y], "\t", ",", end="\t"), "cp1252", "\r\n")
    b.read(name, d, Ch("U_Aktor [V]", "U_Aktor", "V"),
           Ch("Weg [µm]", "Weg", "µm"), "cp1252, decimal comma with "
           "exponent, a tab at the end of each row, long time name",
           "after layout: HBM catman ASCII", SEEN)


def dewesoft(b):
    """Dewesoft X export "Text/CSV". Recalled, no example at hand."""
    name = "dewesoft_export.txt"
    d = record(name).text("%.6f", "%.6f", "%.6f")
    b.lines(name, ["Data info\t", "File name:\tPiezo_0007.dxd",
                   "Start time:\t3/5/2024 2:07:09 PM",
                   "Number of channels:\t2", "Sample rate:\t2000",
                   "Store type:\talways fast", "", "Data1",
                   "Time (s)\tPiezo voltage (V)\tDisplacement (µm)"]
            + rows([d.t, d.u, d.y], "\t"), eol="\r\n")
    b.read(name, d, Ch("Piezo voltage (V)", "Piezo voltage", "V"),
           Ch("Displacement (µm)", "Displacement", "µm"),
           "key and value lines, then a title line of one word",
           "after layout: Dewesoft X text export", RECALL)


def polytec(b):
    """Polytec PSV and VibSoft ASCII. Seen: the five head lines for one
    signal. A second signal column is put in here after the 3D form."""
    name = "polytec_vibsoft.txt"
    d = record(name).text("%.7g", "%.6g", "%.6g", ky=1e-6)
    b.lines(name, ["Source File Name:\tpiezo_run7.pvd", "Signal:\tTime - "
                   "Vib & Ref1 - Samples", "",
                   "Time\tVib Displacement\tRef1 Voltage",
                   "[ s ]\t[ m ]\t[ V ]"] + rows([d.t, d.y, d.u], "\t"),
            eol="\r\n")
    b.read(name, d, Ch("Ref1 Voltage", unit="V"),
           Ch("Vib Displacement", unit="m"),
           "output in metres stands first; units in spaced brackets",
           "after layout: Polytec VibSoft ASCII", SEEN)
    name = "polytec_velocity.txt"
    d = record(name).text("%.7g", "%.6g", "%.6g", ky=1e-6)
    b.lines(name, ["Source File Name:\tScan", "Signal:\tTime - Vib Velocity"
                   " - Samples", "", "Time\tTime Signal", "[ s ]\t[ m/s ]"]
            + rows([d.t, d.y], "\t"), eol="\r\n")
    b.refuse(name, "a velocity, and no voltage", ["the input voltage",
             "the displacement"], "after layout: Polytec PSV ASCII", SEEN)


def make(b):
    for f in (lvm, lvm_hard, ni_spreadsheets, controldesk, diadem, catman,
              dewesoft, polytec):
        f(b)
