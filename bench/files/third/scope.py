"""Oscilloscope exports."""

from common import *


@case(
    "tek_mso_label.csv",
    "scope",
    "Tektronix MSO: units and labels stand in preamble lines, negative start time, trailing commas.",
    check=ck(0, 1, 2, skiprows=21),
)
def _(p):
    r = Rec("tek", 4e-5, 110, 15, t0=-2e-3)
    t, u, y = S(r.t, "%.8e"), S(r.u, "%.5f"), S(r.y, "%.6f")
    h = f"""Model,MSO58
Firmware Version,1.44.3.433

Waveform Type,ANALOG,,
Point Format,Y,,
Horizontal Units,s,,
Horizontal Scale,0.004,,
Horizontal Delay,0.0,,
Sample Interval,4e-05,,
Record Length,{r.n},,
Gating,0.0% to 100.0%,,
Probe Attenuation,1.0,1.0,
Vertical Units,V,um,
Vertical Offset,0.0,0.0,
Vertical Scale,20.0,2.0,
Vertical Position,-3.0,-3.2,
,,,
Time Zone,UTC+01:00,,
Label,Piezo voltage,Displacement,
,,,
TIME,CH1,CH2,""".split("\n")
    wr(p, h + [x + "," for x in rows(t, u, y)], nl="\r\n")
    return ok(4e-5, V(u), V(y))


@case(
    "tek_tds_side_by_side.csv",
    "scope",
    "Two Tektronix TDS channel files pasted side by side: the preamble occupies columns beside the first data rows.",
    also_ok="refuse: preamble and data share rows",
    check=ck(3, 4, 10),
)
def _(p):
    r = Rec("tds", 2e-4, 90, 9, t0=-0.01)
    t, u, y = S(r.t, "%.6f"), S(r.u, "%.5f"), S(r.y, "%.5f")

    def pre(src, unit, scale):
        return [
            ("Record Length", f"{r.n:.6e}"),
            ("Sample Interval", "2.000000e-04"),
            ("Trigger Point", "5.000000000000e+01"),
            ("", ""),
            ("", ""),
            ("", ""),
            ("Source", src),
            ("Vertical Units", unit),
            ("Vertical Scale", scale),
            ("Vertical Offset", "0.000000e+00"),
            ("Horizontal Units", "s"),
            ("Horizontal Scale", "5.000000e-03"),
            ("Pt Fmt", "Y"),
            ("Yzero", "0.000000e+00"),
            ("Probe Atten", "1.000000e+00"),
            ("Model Number", "TDS2014C"),
            ("Serial Number", "C012345"),
            ("Firmware Version", "FV:v24.26"),
        ]

    a, b = pre("CH1 piezo drive", "V", "2.000000e+01"), pre("CH2 displacement", "um", "2.000000e+00")
    L = []
    for k in range(r.n):
        f, g = (a[k] if k < len(a) else ("", "")), (b[k] if k < len(b) else ("", ""))
        L.append(f"{f[0]},{f[1]},,{t[k]},{u[k]},,{g[0]},{g[1]},,{t[k]},{y[k]},")
    wr(p, L, nl="\r\n")
    return ok(2e-4, V(u), V(y))


@case(
    "tek_time_rounded.csv",
    "scope",
    "Time text is rounded to 1 ms so that rows repeat; the period 0.4 ms stands only in Sample Interval.",
    also_ok="refuse: time column has repeated values",
    check=ck(None, 1, 2, skiprows=7),
    tsrx=(r"Sample Interval,(\S+)", float),
)
def _(p):
    r = Rec("tekround", 4e-4, 60, 7)
    t, u, y = S(r.t, "%.3f"), S(r.u, "%.5f"), S(r.y, "%.6f")
    wr(
        p,
        [
            "Model,DPO3014",
            "Horizontal Units,s",
            "Sample Interval,4.0e-04",
            f"Record Length,{r.n}",
            "Vertical Units,V,um",
            "Label,drive,displacement",
            "TIME,CH1,CH2",
        ]
        + rows(t, u, y),
    )
    return ok(4e-4, V(u), V(y))


@refuse(
    "keysight_two_volt.csv",
    "scope",
    "Keysight x-axis,1,2 / second,Volt,Volt: nothing says which channel is the drive and which the displacement.",
)
def _(p):
    r = Rec("keys", 1e-4, 8, 5)
    wr(p, ["x-axis,2,1", "second,Volt,Volt"] + rows(S(r.t, "%+.6E"), S(r.y, "%+.5E"), S(r.u, "%+.5E")), nl="\r\n")


@case(
    "rigol_sequence.csv",
    "scope",
    "Rigol: X is a sequence number; start and increment stand in two extra columns of the first two rows only.",
    check=ck(0, 1, 2, 5e-5, skiprows=2, index_col=False, usecols=[0, 1, 2]),
    tsrx=(r"Sequence,V,um,[^,]+,(\S+)", float),
)
def _(p):
    r = Rec("rigol", 5e-5, 120, 14)
    u, y = S(r.u, "%.6e"), S(r.y, "%.6e")
    wr(
        p,
        ["X,Drive voltage,Displacement,Start,Increment,", "Sequence,V,um,-7.500000e-03,5.000000e-05"]
        + [f"{k},{a},{b}," for k, (a, b) in enumerate(zip(u, y))],
        nl="\r\n",
    )
    return ok(5e-5, V(u), V(y))


@case(
    "siglent_sds.csv",
    "scope",
    "Siglent: preamble with CHn:value cells, units per channel there, data header 'Second,Volt,Micrometer'.",
    check=ck(0, 1, 2, skiprows=12),
)
def _(p):
    r = Rec("sig", 1e-5, 30, 3.3, t0=-1.4e-3)
    t, u, y = S(r.t, "%.11f"), S(r.u, "%.5f"), S(r.y, "%.5f")
    wr(
        p,
        [
            f"Record Length,Analog:{r.n}",
            "Sample Interval,0.00001",
            "Vertical Units,CH1:V,CH2:um",
            "Vertical Scale,CH1:5.00,CH2:0.50",
            "Vertical Offset,CH1:-15.00000,CH2:-1.50000",
            "Horizontal Units,s",
            "Horizontal Scale,0.000500",
            "Model Number,SDS2104X Plus",
            "Serial Number,SDS2PEEX6R0000",
            "Software Version,1.5.2R3",
            "Source,CH1,CH2",
            "Second,Volt,Micrometer",
        ]
        + rows(t, u, y),
    )
    return ok(1e-5, V(u), V(y))


@case(
    "rs_rtb_in_s.csv",
    "scope",
    "R&S RTB header 'in s,PIEZO_U in V,POS in um': the time column has a unit but no name.",
    check=ck(0, 1, 2, skiprows=1),
)
def _(p):
    r = Rec("rtb", 8e-6, 75, 8, t0=-6e-4)
    t, u, y = S(r.t, "%.6E"), S(r.u, "%.5E"), S(r.y, "%.5E")
    wr(p, ["in s,PIEZO_U in V,POS in um"] + rows(t, u, y), nl="\r\n")
    return ok(8e-6, V(u), V(y))


@case(
    "lecroy_wr.csv",
    "scope",
    "LeCroy ASCII: 'Segments', 'Segment,TrigTime' and '#1' lines with numbers before the column names.",
    check=ck(0, 1, 2, skiprows=5),
)
def _(p):
    r = Rec("lecroy", 2e-5, 140, 21, t0=1.5e-3)
    t, u, y = S(r.t, "%.9g"), S(r.u, "%.7g"), S(r.y, "%.7g")
    wr(
        p,
        [
            "LECROYHDO4024,56123,Waveform",
            f"Segments,1,SegmentSize,{r.n}",
            "Segment,TrigTime,TimeSinceSegment1",
            "#1,23-Mar-2023 10:11:12,0",
            "Time,C1 Drive (V),F1 Displacement (um)",
        ]
        + rows(t, u, y),
        nl="\r\n",
    )
    return ok(2e-5, V(u), V(y))


@case(
    "pico_units_row.csv",
    "scope",
    "PicoScope with renamed channels: units row in brackets with a time in ms, then an empty line.",
    check=ck(0, 1, 2, 1e-3, skiprows=3),
)
def _(p):
    r = Rec("pico", 5e-5, 10, 4, t0=-4e-3)
    t, u, y = S(r.t * 1e3, "%.6f"), S(r.u, "%.7f"), S(r.y, "%.7f")
    wr(p, "\ufeffTime,Piezo drive,Cap sensor\r\n(ms),(V),(µm)\r\n\r\n" + "\r\n".join(rows(t, u, y)) + "\r\n")
    return ok(5e-5, V(u), V(y))


@case(
    "pico_de_mV.csv",
    "scope",
    "German PicoScope: decimal comma, channels named A and B but units mV and nm, time in µs.",
    check=ck(0, 1, 2, 1e-6, skiprows=3, sep=";", decimal=",", encoding="utf-8"),
)
def _(p):
    r = Rec("picode", 2e-5, 950, 640, t0=-1e-3)
    t, u, y = S(r.t * 1e6, "%.3f"), S(r.u, "%.4f"), S(r.y, "%.4f")
    wr(p, ["Zeit;Kanal A;Kanal B", "(µs);(mV);(nm)", ""] + rows(comma(t), comma(u), comma(y), sep=";"), nl="\r\n")
    return ok(2e-5, V(u), V(y))


@refuse(
    "pico_overrange.csv",
    "scope",
    "PicoScope wrote the infinity sign for overrange samples of the displacement: those values are unknown.",
)
def _(p):
    r = Rec("picoinf", 1e-4, 10, 4)
    y = S(r.y, "%.6f")
    m = int(np.argmax(r.y))
    for i in range(m - 3, m + 3):
        y[min(i, r.n - 1)] = "∞"
    wr(p, ["Time,Drive,Displacement", "(ms),(V),(µm)", ""] + rows(S(r.t * 1e3, "%.5f"), S(r.u), y))


@case(
    "owon_interval.csv",
    "scope",
    "Owon: no time column, 'Time interval : ,200.00000us' in the preamble, an index column, one line of statistics per channel above.",
    check=ck(0, 1, 2, 2e-4, skiprows=10),
    tsrx=(r"Time interval : ,([\d.]+)us", lambda x: float(x) * 1e-6),
)
def _(p):
    r = Rec("owon", 2e-4, 98, 11)
    u, y = S(r.u, "%.2f"), S(r.y, "%.4f")
    wr(
        p,
        [
            "Channel :,CH1,CH2",
            "Frequency : ,F=14.29Hz,F=14.29Hz",
            "Period : ,T=70.00ms,T=70.00ms",
            "PK-PK : ,Vpp=97.6V,Vpp=11.1um",
            "Average : ,V=31.2V,V=3.90um",
            "Vertical pos : ,-2.00div,-2.00div",
            "Probe attenuation : ,X1,X1",
            "Time interval : ,200.00000us,200.00000us",
            "",
            "index,CH1_Drive_Voltage(V),CH2_Displacement(um)",
        ]
        + [f"{k},{a},{b}" for k, (a, b) in enumerate(zip(u, y))],
        nl="\r\n",
    )
    return ok(2e-4, V(u), V(y))


@case(
    "hantek_clock.csv",
    "scope",
    "Hantek: names, units and clock '#CLOCK=0.200mS' (milliseconds) stand in comment lines only.",
    also_ok="refuse: header only in comments, mS is not the symbol of the millisecond",
    check=ck(None, 0, 1, comment="#"),
    tsrx=(r"CLOCK=([\d.]+)mS", lambda x: float(x) * 1e-3),
)
def _(p):
    r = Rec("hantek", 2e-4, 45, 5)
    u, y = S(r.u, "%.4f"), S(r.y, "%.5f")
    wr(
        p,
        ["#CHANNEL:CH1,CH2", "#LABEL:Piezo voltage,Displacement", "#CLOCK=0.200mS", f"#SIZE={r.n}", "#UNITS:V,um"]
        + rows(u, y),
    )
    return ok(2e-4, V(u), V(y))


@case(
    "moku_percent_header.csv",
    "scope",
    "Moku: every header line incl. the column names starts with %, spaces after commas.",
    check=ck(0, 1, 2, comment="%", skipinitialspace=True),
)
def _(p):
    r = Rec("moku", 1e-3, 5, 2)
    t, u, y = S(r.t, "%.10e"), S(r.u, "%.10e"), S(r.y, "%.10e")
    wr(
        p,
        [
            "% Moku:Pro Data Logger",
            "% Input 1, DC coupling, 1 MOhm, 40 Vpp",
            "% Input 2, DC coupling, 1 MOhm, 4 Vpp",
            "% Acquisition rate: 1.0000000000e+03 Hz, Precision mode",
            "% Acquired 2024-05-02 T 10:11:12 +0200",
            "% Time (s), Piezo voltage (V), Displacement (um)",
        ]
        + rows(t, u, y, sep=", "),
    )
    return ok(1e-3, V(u), V(y))


@refuse(
    "scope_dual_timebase.csv",
    "scope",
    "Two channels with their own time columns shifted by half a period: u and y were not taken at the same instants.",
)
def _(p):
    r = Rec("dual", 1e-3, 50, 6)
    wr(p, ["Time (s),Voltage (V),Time (s),Displacement (um)"] + rows(S(r.t), S(r.u), S(r.t + 5e-4), S(r.y)))


@case(
    "scope_dup_time_same.csv",
    "scope",
    "Two channels with their own time columns of one name, which agree in every row.",
    check=ck(0, 1, 3, skiprows=1),
)
def _(p):
    r = Rec("dups", 1e-3, 50, 6)
    u, y = S(r.u), S(r.y)
    wr(p, ["Time (s),Voltage (V),Time (s),Displacement (um)"] + rows(S(r.t), u, S(r.t), y))
    return ok(1e-3, V(u), V(y))
