"""Recorders and USB or network scopes which write text. See scopes.py."""
from common import MANUAL, RECALL, SEEN, Ch, record, rows
from scopes import ASK, two_channels, volts


def yokogawa(b):
    """DL9000, DLM3000: key,value head of N lines. The keys come from the
    manual IM DLM3054-01EN, appendix 3; the exact commas are recalled.
    With linear scaling the unit is free, here um."""
    name = "yokogawa_dlm.csv"
    d = record(name).text(fu="%.5E", fy="%.5E")
    n = len(d.t)
    head = ["Header Size,15", "Model Name,DLM3054", "Comment,",
            "BlockNumber,1,1", "TraceName,CH1,CH2", "BlockSize,%d,%d" % (n, n),
            "VUnit,V,um", "SampleRate,2.0E+03,2.0E+03",
            "HResolution,5.0000000E-04,5.0000000E-04",
            "HOffset,-1.0000000E-02,-1.0000000E-02", "HUnit,s,s",
            "DisplayBlockSize,%d,%d" % (n, n), "DisplayPointNo.,1,1",
            "Date,2024/03/05,2024/03/05", "Time,14:07:09.00,14:07:09.00"]
    b.lines(name, head + rows([[""] * n, d.u, d.y], end=","), eol="\r\n")
    b.read(name, d, Ch("CH1", unit="V"), Ch("CH2", unit="um"),
           "no time column: HResolution gives it; the units V and um tell "
           "input and output", "after layout: Yokogawa DLM ASCII", MANUAL,
           also_ok="refuse and ask for the roles of CH1 and CH2")
    name = "yokogawa_dl1540.csv"
    d = volts(name, fu="%.3e", fy="%.3e")
    n = len(d.t)
    head = ['"Model", "DL1540L"', '"BlockSize", %d' % n, '"BlockNumber", 1',
            '"DisplayPointNo.", 1', '"DisplayBlockSize", %d' % n,
            '"TriggerPointNo.", 0', '"Date", "24/03/05"',
            '"Time", "14:07:09"', '"SampleRate", 2,"kHz"',
            '"TraceName", "Ch1","Ch2"', '"Unit", "V","V"', '"MediaNo.", 1',
            '"StartBlockNo.", 1', '"StartPointNo.", 1', '"EndBlockNo.", 1',
            '"EndPointNo.", %d' % n]
    b.lines(name, head + rows([d.u, d.y], ", "), eol="\r\n")
    two_channels(b, name, d, "after layout: Yokogawa DL1540 P-P data, "
                 "manual IM 701510-01E", MANUAL, "Ch1", "Ch2", "V",
                 "no time column; rate is 2 kHz in two cells")


def hioki(b):
    """HIOKI 8807/8808 text file. Layout and example: its manual, section
    12.5. Scaling gives free units."""
    name = "hioki_8807.txt"
    d = record(name).text(ft="%+.4E", fu="%+.4E", fy="%+.4E")
    head = ['"COMMENT", "8807 MEM DATA"', '"DATE", "03-05-2024"',
            '"TIME", "14:07:09"', '"NUM_SIGS", 3', '"INTERVAL", 5.000E-04',
            '"HORZ_UNITS", "S"', '"VERT_UNITS", "S", "V", "um"',
            '"SIGNAL", "TIME", "ACH1", "ACH2"', '"DATA"']
    b.lines(name, head + rows([d.t, d.u, d.y], ", "), eol="\r\n")
    b.read(name, d, Ch("ACH1", unit="V"), Ch("ACH2", unit="um"),
           "quoted key,value head; names and units in two lines",
           "after layout: HIOKI 8807 text", MANUAL,
           also_ok="refuse and ask for the roles of ACH1 and ACH2")


def digilent(b):
    """Digilent WaveForms (Analog Discovery): # lines, blank line, names.
    Seen: several public files. Channels can be renamed and have units."""
    for tag, names in (("channels", ("Channel 1 (V)", "Channel 2 (V)")),
                       ("named", ("Drive (V)", "Displacement (um)"))):
        name = "digilent_waveforms_%s.csv" % tag
        r = record(name) if tag == "named" else None
        fmt = dict(ft="%.9g", fu="%.9g", fy="%.9g", t0=-0.05)
        d = r.text(**fmt) if r else volts(name, **fmt)
        head = ["#Digilent WaveForms Oscilloscope Acquisition",
                "#Device Name: Discovery2", "#Serial Number: SN:210321A00000",
                "#Date Time: 2024-03-05 14:07:09.000", "#Sample rate: 2000Hz",
                "#Samples: %d" % len(d.t), "#Trigger: Source: Channel 1 "
                "Type: Edge Condition: Rise Level: 1 V",
                "#Channel 1: Range: 5 V/div Offset: 0 V", "",
                "Time (s),%s,%s" % names]
        b.lines(name, head + rows([d.t, d.u, d.y]), eol="\r\n")
        who = "after layout: Digilent WaveForms CSV"
        u, y = (Ch(n, n.split(" (")[0], n.split("(")[1][:-1]) for n in names)
        if r:
            b.read(name, d, u, y, "comment lines hold numbers and commas",
                   who, SEEN)
        else:
            b.refuse(name, "nothing says which channel is the displacement",
                     ASK, who, SEEN, data=d, u=u, y=y)


def discovery_logger(b):
    """Analog Discovery, WaveForms Logger, Excel with German region.
    Seen: the #Digilent WaveForms Logger head; tabs are an export option."""
    name = "analog_discovery_logger.txt"
    d = volts(name, ts=0.01, ft="%.9g", fu="%.6g", fy="%.6g")
    head = ["#Digilent WaveForms Logger",
            "#Device Name: Analog Discovery Studio",
            "#Serial Number: SN:210415B00000",
            "#Date Time: 2024-03-05 14:07:09", "#Sample rate: 100Hz",
            "#Samples: %d" % len(d.t), "Time (s)\tDrive\tPosition sensor"]
    b.lines(name, head + rows([d.t, d.u, d.y], "\t"))
    b.read(name, d, Ch("Drive"), Ch("Position sensor"),
           "tabs, no blank line before the names; no units of the channels",
           "after layout: Digilent WaveForms Logger", SEEN)


def red_pitaya(b):
    """Red Pitaya web scope and streaming app. Recalled: CSV with a column
    per input and no time; the decimation gives the rate."""
    name = "red_pitaya_stream.csv"
    d = volts(name, fu="%.6f", fy="%.6f")
    b.lines(name, ["CH1, CH2"] + rows([d.u, d.y], ", "))
    two_channels(b, name, d, "after layout: Red Pitaya streaming CSV",
                 RECALL, unit="", why="no time, no rate, no units")
    b.truth[-1].update(ts=None, needs=["sampling period"] + ASK)


def moku(b):
    """Moku data logger converted by mokucli. Layout and example: Liquid
    Instruments, mokucli documentation, "mokucli stream"."""
    name = "moku_data_logger.csv"
    d = volts(name, ft="%.10e", fu="%.10e", fy="%.10e")
    head = ["% Moku:Go Data Logger", "% Input 1 (on), DC , 1 MOhm , 10 Vpp",
            "% Input 2 (on), DC , 1 MOhm , 10 Vpp",
            "% Acquisition rate: 2.0000000000e+03 Hz, Precision mode",
            "% Output 1 (off) - Sine, 10.000 000 000 000 MHz, 1.000 0 Vpp, "
            "offset 0.000 0 V, phase 0.000 000 deg", "%",
            "% Acquired 2024-03-05 T 14:07:09 +0100",
            "% Time (s), Input 1 (V), Input 2 (V)"]
    b.lines(name, head + rows([d.t, d.u, d.y], ", "), eol="\r\n")
    b.refuse(name, "names in the last % line; Input 1 and Input 2 are the "
             "inputs of the device, not of the actuator", ASK,
             "after layout: Moku Data Logger CSV", MANUAL, data=d,
             u=Ch("Input 1 (V)", "Input 1", "V"),
             y=Ch("Input 2 (V)", "Input 2", "V"))


def zurich(b):
    """Zurich Instruments LabOne. Seen in public readers: the plotter head
    chunk;timestamp;... and the row form chunk;timestamp;size;fieldname.
    Time stamps are ticks of the device clock (60 MHz on the MFLI)."""
    name = "labone_demod.csv"
    d = volts(name, fu="%.8f", fy="%.8f")
    n = len(d.t)
    tick = ["%d" % (7000000000 + 30000 * i) for i in range(n)]
    zero = ["0"] * n
    b.lines(name, ["chunk;timestamp;auxin0;auxin1"]
            + rows([zero, tick, d.u, d.y], ";"))
    b.refuse(name, "time in ticks of a clock which the file does not name",
             ["clock rate or sampling period"] + ASK,
             "after layout: Zurich Instruments LabOne CSV", RECALL, data=d,
             u=Ch("auxin0"), y=Ch("auxin1"), ts=None)
    name = "labone_rows.csv"
    d = volts(name, fu="%.8f", fy="%.8f")
    lines = ["chunk;timestamp;size;fieldname"]
    for field, cells in (("grid", d.t), ("auxin0", d.u), ("auxin1", d.y)):
        lines.append(";".join(["0", "7000000000", str(len(cells)), field]
                              + cells))
    b.lines(name, lines)
    b.refuse(name, "one row a field: the table lies on its side", ASK
             + ["export with one column a channel"],
             "after layout: LabOne rows", SEEN, data=d, u=Ch("auxin0"),
             y=Ch("auxin1"))


def make(b):
    for f in (yokogawa, hioki, digilent, discovery_logger, red_pitaya, moku,
              zurich):
        f(b)
