"""Oscilloscope text files, after layouts seen in public or in manuals.

A scope knows volts only. Where a file says CH1 and CH2 and nothing more, the
reader must ask which one is the displacement and what its scale is. Sources
stand at each function. Where the source is RECALL no example was at hand.
"""
from common import RECALL, SEEN, Ch, record, rows

ASK = ["which channel is the input and which the displacement sensor",
       "amplifier gain", "sensor scale (um per V)"]


def volts(name, **kw):
    """Record with a 1:10 HV monitor and a 10 um/V sensor, both in V."""
    ts = kw.pop("ts", 0.0005)
    args = dict(ft="%.6e", fu="%.5f", fy="%.5f", ku=0.1, ky=0.1)
    args.update(kw)
    return record(name, ts).text(**args)


def two_channels(b, name, d, writer, source, u="CH1", y="CH2", unit="V",
                 why="nothing says which channel is the displacement"):
    b.refuse(name, why, ASK, writer, source, data=d, u=Ch(u, unit=unit),
             y=Ch(y, unit=unit))


def tek_tds(b):
    """TDS1000/2000, TPS2000: one file a channel, preamble at the left.
    Seen: mamclain.com, "Matlab Tektronix Oscilloscope CSV File Loader"."""
    for k, what in ((1, "u"), (2, "y")):
        name = "tek_tds/F0003CH%d.CSV" % k
        d = volts("tek_tds", ft="%.12f", t0=-0.06)
        n = len(d.t)
        pre = ["Record Length,%.6e" % n, "Sample Interval,%.6e" % d.ts,
               "Trigger Point,1.200000000000e+02", ",", ",", ",",
               "Source,CH%d" % k, "Vertical Units,V",
               "Vertical Scale,2.000000e+00", "Vertical Offset,0.000000e+00",
               "Horizontal Units,s", "Horizontal Scale,2.500000e-02",
               "Pt Fmt,Y", "Yzero,0.000000e+00", "Probe Atten,1.000000e+00",
               "Firmware Version,FV:v10.21"]
        pre += [","] * (n - len(pre))
        t = [c.rjust(18) for c in d.t]
        v = [c.rjust(10) for c in getattr(d, what)]
        b.lines(name, rows([pre, [""] * n, t, v], end=","), eol="\r\n")
        b.refuse(name, "one channel a file; the first rows carry the "
                 "preamble in columns A and B", ["the file of the other "
                 "channel"] + ASK, "after layout: Tektronix TDS2000/TPS2000",
                 SEEN, data=d, **{what: Ch("CH%d" % k, unit="V")},
                 only=what)


def tek_mso(b):
    """MSO/MDO/DPO 3000 and 4000: preamble above, labels, TIME,CH1,CH2.
    Seen: a file of an MDO3014 quoted in a public write-up (first 30 lines).
    The sections of a channel list one column each."""
    for tag, labels in (("labels", ("HV monitor", "Position sensor")),
                        ("plain", ("", ""))):
        name = "tek_mso_%s.csv" % tag
        d = volts(name, t0=-0.08)
        head = ["Model,MSO4034B", "Firmware Version,2.90", "",
                "Waveform Type,ANALOG,", "Point Format,Y,",
                "Horizontal Units,s,", "Horizontal Scale,0.02,",
                "Horizontal Delay,0.08,", "Sample Interval,%g," % d.ts,
                "Record Length,%d," % len(d.t), "Gating,0.0% to 100.0%,",
                "Probe Attenuation,1,1", "Vertical Units,V,V",
                "Vertical Offset,0,0", "Vertical Scale,2,0.5",
                "Vertical Position,-1.98,0", ",,", ",,", ",,",
                "Label,%s,%s" % labels, "TIME,CH1,CH2"]
        b.lines(name, head + rows([d.t, d.u, d.y]), eol="\r\n")
        who = "after layout: Tektronix MSO/DPO4000 CSV"
        if labels[0]:
            b.read(name, d, Ch("CH1", "HV monitor", "V"),
                   Ch("CH2", "Position sensor", "V"),
                   "labels and units stand above the columns", who, SEEN)
        else:
            two_channels(b, name, d, who, SEEN)


def keysight(b):
    """InfiniiVision 2000/3000 X: names 1 and 2, exponents E-06 and the like.
    Seen: files of MSO-X scopes quoted in public code (84.48E-06 style)."""
    name = "keysight_infiniivision.csv"
    d = volts(name, ft="%+.6E", t0=-0.05)
    b.lines(name, ["x-axis,1,2", "second,Volt,Volt"]
            + rows([d.t, d.u, d.y]), eol="\r\n")
    two_channels(b, name, d, "after layout: Keysight InfiniiVision CSV",
                 SEEN, "1", "2", "Volt", "channel names are plain numbers")
    name = "keysight_benchvue.csv"
    d = volts(name, ft="%.6f")
    head = ["BenchVue Oscilloscope Trace Export", "Instrument,MSO-X 3034T",
            "Date,3/5/2024 2:07:09 PM", "Points,%d" % len(d.t), "",
            "Time (s),HV monitor (V),Position sensor (V)"]
    b.lines(name, head + rows([d.t, d.u, d.y]), eol="\r\n",
            bom=b"\xef\xbb\xbf")
    b.read(name, d, Ch("HV monitor (V)", "HV monitor", "V"),
           Ch("Position sensor (V)", "Position sensor", "V"),
           "title block with key,value lines; output is a sensor voltage",
           "after layout: Keysight BenchVue", RECALL)


def rigol(b):
    """DS1000Z: start and step in the second row, no time column.
    DHO800, MSO5000: time column, or none and step in the first row.
    Seen for DS1000Z and Time(s),CH1(V); recalled for the tInc form."""
    name = "rigol_ds1000z.csv"
    d = volts(name, fu="%.2e", fy="%.2e")
    num = ["%d" % i for i in range(len(d.t))]
    b.lines(name, ["X,CH1,CH2,Start,Increment,",
                   "Sequence,Volt,Volt,-3.000000e-03,%.6e" % d.ts]
            + rows([num, d.u, d.y], end=","))
    two_channels(b, name, d, "after layout: Rigol DS1000Z CSV", SEEN,
                 unit="Volt", why="time only as start and step; CH1, CH2")
    name = "rigol_dho800.csv"
    d = volts(name, ft="%.8f", fu="%.4f", fy="%.4f")
    b.lines(name, ["Time(s),CH1(V),CH2(V)"] + rows([d.t, d.u, d.y]))
    b.refuse(name, "nothing says which channel is the displacement", ASK,
             "after layout: Rigol DHO800 CSV", SEEN, data=d,
             u=Ch("CH1(V)", "CH1", "V"), y=Ch("CH2(V)", "CH2", "V"))
    name = "rigol_mso5000.csv"
    d = volts(name, fu="%.6E", fy="%.6E")
    b.lines(name, ["CH1V,CH2V,t0 =-5.000000e-02, tInc = %.6e," % d.ts]
            + rows([d.u, d.y], end=",,"))
    b.refuse(name, "start and step stand in the header row", ASK,
             "after layout: Rigol MSO5000 CSV", RECALL, data=d,
             u=Ch("CH1V", "CH1", "V"), y=Ch("CH2V", "CH2", "V"))


def siglent(b):
    """SDS1000X-E and X-U, SDS2000X. Seen: README of SigFyCSV (one channel)
    and a capture tool which mimics the file of an SDS1104X-U."""
    name = "siglent_x_u.csv"
    d = volts(name, fu="%.6E", fy="%.6E")
    head = ["Record Length,Analog:%d," % len(d.t),
            "Sample Interval,Analog:%.6E," % d.ts,
            "Vertical Units,CH1:V, CH2:V,,", "Vertical Scale,CH1:2, CH2:0.5,,",
            "Vertical Offset,CH1:0, CH2:0,,", "Horizontal Units,s,",
            "Horizontal Scale,0.02,", "Model Number,SDS1104X-U,",
            "Serial Number,SDS00000000000,", "Software Version,2.1.1.1.5R5,",
            "Source,CH1,CH2", "Second,Value,Value"]
    b.lines(name, head + rows([d.t, d.u, d.y]))
    two_channels(b, name, d, "after layout: Siglent SDS1104X-U CSV", SEEN)
    name = "siglent_bin2csv.csv"
    d = volts(name, ft="%.11f")
    head = ["Record Length,Analog:%d" % len(d.t),
            "Sample Rate,%.1f" % (1 / d.ts), "Vertical Scale,CH1: 2.00",
            "Vertical Offset,CH1:0.00000", "Horizontal Scale, 0.020000000",
            "Second,Volt"]
    b.lines(name, head + rows([d.t, d.u]))
    b.refuse(name, "one channel only", ["the other channel"] + ASK,
             "after layout: Siglent SDS1104X-E bin to CSV", SEEN, data=d,
             u=Ch("CH1", unit="Volt"), only="u")
    name = "siglent_screen.csv"
    d = volts(name, ft="%.9f", t0=-0.07)
    b.lines(name, ["Source,CH1,CH2", "Second,Volt,Volt"]
            + rows([d.t, d.u, d.y]))
    two_channels(b, name, d, "after layout: Siglent SDS save as CSV", SEEN,
                 unit="Volt")


def picoscope(b):
    """PicoScope 6 and 7: names, units in brackets, blank line.
    Seen: many public files. Channels can be renamed; custom probes give
    units of their own. A value over the range is written as an infinity
    sign (Pico support forum; recalled)."""
    name = "picoscope_channels.csv"
    d = volts(name, kt=1e3, ft="%.8f", fu="%.8f", fy="%.8f", t0=-0.02)
    b.lines(name, ["Time,Channel A,Channel B", "(ms),(V),(V)", ""]
            + rows([d.t, d.u, d.y]), eol="\r\n")
    two_channels(b, name, d, "after layout: PicoScope 6 CSV", SEEN,
                 "Channel A", "Channel B")
    name = "picoscope_named.csv"
    d = record(name).text(kt=1e3, ft="%.8f", fu="%.8f", fy="%.8f", t0=-0.02)
    b.lines(name, ["Time,Piezo voltage,Displacement", "(ms),(V),(µm)", ""]
            + rows([d.t, d.u, d.y]), eol="\r\n", bom=b"\xef\xbb\xbf")
    b.read(name, d, Ch("Piezo voltage", unit="V"),
           Ch("Displacement", unit="µm"), "time in ms, unit row, blank row",
           "after layout: PicoScope 7 CSV, renamed channels", SEEN)
    name = "picoscope_over_range.csv"
    d = record(name).text(kt=1e3, ft="%.8f", ku=1e3, fu="%.5f", fy="%.8f")
    for i in (70, 71, 72):
        d.y[i] = "∞"
    b.lines(name, ["Time,Piezo voltage,Displacement", "(ms),(mV),(µm)", ""]
            + rows([d.t, d.u, d.y]), eol="\r\n", bom=b"\xef\xbb\xbf")
    b.read(name, d, Ch("Piezo voltage", unit="mV"),
           Ch("Displacement", unit="µm"),
           "infinity signs mark over range; voltage in mV",
           "after layout: PicoScope 6 CSV", RECALL, gaps=[70, 71, 72],
           also_ok="refuse and name the rows")


def lecroy(b):
    """WaveSurfer, WaveRunner, DDA: five header lines, one channel a file.
    Seen: files of LECROYWP715Zi and LECROYDDA3000 quoted in public code.
    The two-channel form is seen once (Time, Ampl1, Ampl2)."""
    head = ["LECROYWS434,12345,Waveform", "Segments,1,SegmentSize,%d",
            "Segment,TrigTime,TimeSinceSegment1",
            "#1,05-Mar-2024 14:07:09,0                 "]
    name = "lecroy_C1Trace00000.txt"
    d = volts(name, ft="%.10f", fu="%.6g", t0=-0.01)
    b.lines(name, [h % len(d.t) if "%" in h else h for h in head]
            + ["Time,Ampl"] + rows([d.t, d.u]), eol="\r\n")
    b.refuse(name, "one channel a file, names Time and Ampl",
             ["the file of the other channel"] + ASK,
             "after layout: LeCroy WaveSurfer ASCII", SEEN, data=d,
             u=Ch("Ampl"), only="u")
    name = "lecroy_segments.csv"
    d = volts(name)
    half = len(d.t) // 2
    two = [h.replace("Segments,1", "Segments,2") % half
           if "%" in h else h for h in head]
    two.append("#2,05-Mar-2024 14:07:10,1.000000000")
    b.lines(name, two + ["Time, Ampl1, Ampl2"]
            + rows([d.t[:half], d.u[:half], d.y[:half]])
            + rows([d.t[:half], d.u[half:2 * half], d.y[half:2 * half]]),
            eol="\r\n")
    b.refuse(name, "two segments; time starts again in the middle",
             ["which segment"] + ASK, "after layout: LeCroy segments", SEEN)


def rohde(b):
    """R&S RTB2000: units and names in one line. Seen: "in s,C1 in V,C2 in
    V" in public code for RTB2000; RTM manual 1317.4726 describes it."""
    name = "rs_rtb2000.csv"
    d = volts(name, ft="%.7E", fu="%.7E", fy="%.7E")
    b.lines(name, ["in s,C1 in V,C2 in V"] + rows([d.t, d.u, d.y]),
            eol="\r\n")
    b.refuse(name, "the time column has a unit and no name; C1 and C2", ASK,
             "after layout: R&S RTB2000 CSV", SEEN, data=d,
             u=Ch("C1 in V", "C1", "V"), y=Ch("C2 in V", "C2", "V"))


def make(b):
    for f in (tek_tds, tek_mso, keysight, rigol, siglent, picoscope, lecroy,
              rohde):
        f(b)
