"""Oscilloscopes."""

from common import *


def scopes():
    r = rec(4e-5, 5, 0, 4.2)
    t, u, y = S("%.8e", r.t - 0.002), S("%.5f", r.u), S("%.5f", r.y)
    mh = lambda lab: [
        "Model,MSO56",
        "Label,%s" % lab,
        "Waveform Type,ANALOG,ANALOG",
        "Horizontal Units,s,s",
        "Sample Interval,4.00000000e-05,4.00000000e-05",
        "Record Length,%d,%d" % (r.n, r.n),
        "Zero Index,50.00000000,50.00000000",
        "Vertical Units,V,V",
        "FastFrame Count,0,0",
        ",",
        ",",
        "Labels,%s" % lab,
        "TIME,CH1,CH2",
    ]
    add(
        "38_tek_mso_labels.csv",
        "scope-tek",
        text(mh("Piezo drive,Displacement sensor") + rows(",", t, u, y), eol="\r\n"),
        E,
        4e-5,
        V(u),
        V(y),
        "Tek MSO5: CH1/CH2 both in V, the labels tell which is what; time starts negative",
        chk=lambda p: pdcsv(1, 2, 0, skiprows=12)(p),
    )
    r = rec(4e-5, 5, 0, 4.2)
    add(
        "39_tek_mso_nolabels.csv",
        "scope-tek",
        text(mh(",") + rows(",", S("%.8e", r.t - 0.002), S("%.5f", r.u), S("%.5f", r.y)), eol="\r\n"),
        X,
        4e-5,
        [],
        [],
        "Tek MSO5 without labels: CH1 and CH2 both in V",
    )
    r = rec(4e-4, 5, 0, 4.2)
    side = [
        "Record Length,%d" % r.n,
        "Sample Interval,4.000000e-04",
        "Trigger Point,0.0",
        ",",
        ",",
        ",",
        "Source,CH1",
        "Vertical Units,V",
        "Vertical Scale,2.000000e+00",
        "Vertical Offset,0.0",
        "Horizontal Units,s",
        "Horizontal Scale,1.0e-02",
        "Pt Fmt,Y",
        "Yzero,0.0",
        "Probe Atten,1.0",
        "Model Number,TDS1012B",
        "Serial Number,C051234",
        "Firmware Version,FV:v22.11",
    ]
    side += [","] * (r.n - len(side))
    add(
        "40_F0000CH1.CSV",
        "scope-tek",
        text(["%s,,%s,%s," % (a, b, c) for a, b, c in zip(side, S("%.6f", r.t), S("%.5f", r.u))], eol="\r\n"),
        X,
        4e-4,
        [],
        [],
        "Tek TDS1000 F0000CH1.CSV: one channel only",
    )
    r = rec(1e-4, 5, 0, 4.2)
    add(
        "41_scope_1.csv",
        "scope-keysight",
        text(
            ["x-axis,1,2", "second,Volt,Volt"] + rows(",", S("%+.6E", r.t), S("%+.5E", r.u), S("%+.5E", r.y)),
            eol="\r\n",
        ),
        X,
        1e-4,
        [],
        [],
        "Keysight InfiniiVision: channels 1 and 2, both Volt",
    )
    # Keysight with probe units set to metre? no: readable Rigol
    r = rec(2e-4, 5, 0, 4.2)
    add(
        "42_RigolDS0.csv",
        "scope-rigol",
        text(
            ["X,CH1,CH2,Start,Increment,", "Sequence,Volt,Volt,0.000000e+00,2.000000e-04"]
            + ["%d,%s,%s," % z for z in zip(range(r.n), S("%.2e", r.u), S("%.2e", r.y))],
            eol="\r\n",
        ),
        X,
        2e-4,
        [],
        [],
        "Rigol: CH1 and CH2 both Volt",
    )
    # Siglent with source names
    r = rec(5e-4, 10, 0, 8.0)
    t, u, y = S("%.9f", r.t - 0.05), S("%.5f", r.u), S("%.5f", r.y)
    add(
        "43_SDS00012.csv",
        "scope-siglent",
        text(
            [
                "Record Length,Analog:%d,Analog:%d" % (r.n, r.n),
                "Sample Interval,C1:5.000000E-04,C2:5.000000E-04",
                "Vertical Units,C1:V,C2:V",
                "Vertical Scale,C1:2.00,C2:2.00",
                "Vertical Offset,C1:-4.0,C2:-4.0",
                "Horizontal Units,s",
                "Horizontal Scale,0.02",
                "Model Number,SDS2104X Plus",
                "Serial Number,SDS2PDDQ4R0001",
                "Software Version,1.3.9R6",
                "Source,C1,C2",
                "Second,Volt,Volt",
            ]
            + rows(",", t, u, y),
            eol="\r\n",
        ),
        X,
        5e-4,
        [],
        [],
        "Siglent: C1 and C2 both in V, no labels",
    )
    # R&S with labels
    r = rec(1e-4, 6, 0, 5)
    t, u, y = S("%.7E", r.t), S("%.5E", r.u), S("%.5E", r.y)
    add(
        "44_RTB_01.CSV",
        "scope-rs",
        text(["in s,PIEZO_DRIVE in V,DISPL_SENSOR in V"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        'R&S RTB: unit as "in V", sensor in volts with a clear label',
        chk=pdcsv(1, 2, 0),
    )
    # Yokogawa
    r = rec(0.0005, 100, 0, 7.7)
    u, y = S("%.5E", r.u), S("%.5E", r.y)
    add(
        "45_DL850_0003.csv",
        "scope-yokogawa",
        text(
            [
                '"Header Size",16',
                '"Model Name","DL850E"',
                '"Comment",""',
                '"BlockNumber",1',
                '"TraceName","PZT_OUT   ","GAP_SENS  "',
                '"BlockSize",%d,%d' % (r.n, r.n),
                '"VUnit","V","um"',
                '"SampleRate",2.0000000E+03,2.0000000E+03',
                '"HResolution",5.0000000E-04,5.0000000E-04',
                '"HOffset",0.0000000E+00,0.0000000E+00',
                '"HUnit","s","s"',
                '"DisplayBlockSize",%d,%d' % (r.n, r.n),
                '"DisplayPointNo.",1,1',
                '"PhaseShift",0.0,0.0',
                '"Date","2023/11/08","2023/11/08"',
                '"Time","10:21:33.123456","10:21:33.123456"',
                "",
            ]
            + [",%s,%s" % z for z in zip(u, y)],
            eol="\r\n",
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "Yokogawa DL850: row labels in the first column, data rows with an empty first field, no time column",
        chk=pdcsv(1, 2, skiprows=17, header=None),
    )
    # PicoScope
    r = rec(0.0001, 10, 0, 8.4)
    add(
        "46_20230112-0001_1.csv",
        "picoscope",
        text(
            ["Time,Channel A,Channel B", "(ms),(V),(V)", ""]
            + rows(",", S("%.8f", r.t * 1e3 - 5), S("%.8f", r.u), S("%.8f", r.y)),
            eol="\r\n",
        ),
        X,
        1e-4,
        [],
        [],
        "PicoScope Channel A and B both in V",
    )
    r = rec(2e-5, 10, 0, 8.4)
    t, u, y = S("%.8f", r.t * 1e3 - 1), S("%.8f", r.u), S("%.8f", r.y)
    add(
        "47_20230112-0002_1.csv",
        "picoscope",
        text(
            ["Time,Piezo drive,Capacitive probe,Trigger", "(ms),(V),(µm),(mV)", ""]
            + rows(",", t, u, y, ["∞" if i % 40 < 20 else "-12.54321300" for i in range(r.n)]),
            eol="\r\n",
            bom=BOM,
        ),
        E,
        r.ts,
        V(u),
        V(y),
        "PicoScope with named channels, units row in parentheses, blank line, over-range sign ∞ in an unneeded channel",
        chk=pdcsv(1, 2, 0, 1e-3, skiprows=3, header=None, encoding="utf-8-sig"),
    )
    r = rec(2e-6, 10000, 0, 900)
    t, u, y = C(S("%.6f", r.t * 1e6)), C(S("%.5f", r.u)), C(S("%.5f", r.y))
    add(
        "48_pico_de.txt",
        "picoscope",
        text(["Zeit\tAktorspannung\tWeg", "(us)\t(mV)\t(nm)", ""] + rows("\t", t, u, y), "cp1252", eol="\r\n"),
        E,
        r.ts,
        V(u, ","),
        V(y, ","),
        "PicoScope txt in German: decimal comma, units us, mV, nm",
        chk=pdcsv(1, 2, 0, 1e-6, sep="\t", skiprows=3, header=None, decimal=",", encoding="cp1252"),
    )
    # Digilent
    r = rec(0.0005, 5, 0, 3.9)
    t, u, y = ["%.10g" % (v - 0.05) for v in r.t], ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y]
    dh = [
        "#Digilent WaveForms Oscilloscope Acquisition",
        "#Device Name: Discovery2",
        "#Serial Number: SN:210321A12345",
        "#Date Time: 2023-04-05 10:11:12.123.456",
        "#Sample rate: 2000Hz",
        "#Samples: %d" % r.n,
        "#Trigger: Source: None Type: Edge Condition: Rising Level: 0 V Hyst.: Auto HoldOff: 0 s",
    ]
    add(
        "49_acq0001.csv",
        "digilent",
        text(
            dh
            + [
                "#Channel 1: Range: 1 V/div Offset: 0 V Attenuation: 1 X",
                "#Channel 2: Range: 1 um/div Offset: 0 um Attenuation: 1 X",
                "",
                "Time (s),Piezo amp (V),Displacement (um)",
            ]
            + rows(",", t, u, y)
        ),
        E,
        0.0005,
        V(u),
        V(y),
        "WaveForms with renamed channels and a custom unit",
        chk=pdcsv(1, 2, 0, comment="#"),
    )
    r = rec(0.0005, 5, 0, 3.9)
    add(
        "50_acq0002.csv",
        "digilent",
        text(
            dh
            + ["", "Time (s),Channel 1 (V),Channel 2 (V)"]
            + rows(",", S("%.6f", r.t), ["%.15g" % v for v in r.u], ["%.15g" % v for v in r.y])
        ),
        X,
        0.0005,
        [],
        [],
        "WaveForms default names, both V",
    )
    # Moku
    r = rec(0.001, 5, 0, 8.2)
    t, u, y = S("%.10e", r.t), S("%.10e", r.u), S("%.10e", r.y)
    add(
        "51_MokuDataLog_20230601.csv",
        "moku",
        text(
            [
                "% Moku:Go Data Logger",
                "% Input 1 - DC coupled, 10 Vpp - piezo amplifier drive signal",
                "% Input 2 - DC coupled, 10 Vpp - displacement sensor (capacitive), 2 um/V",
                "% Acquisition rate: 1.0000000000e+03 Hz, Precision mode",
                "% Acquired 2023-06-01 T 11:45:30 +0200",
                "% Time (s), Input 1 (V), Input 2 (V)",
            ]
            + rows(", ", t, u, y)
        ),
        E,
        0.001,
        V(u),
        V(y),
        "Moku: names in % lines; what the inputs are stands only in comments",
        "refuse: meaning only in free comments",
        chk=pdcsv(1, 2, 0, comment="%", header=None),
    )
    # Red Pitaya
    r = rec(0.001, 1, 0, 0.8)
    add(
        "52_rp_stream.csv",
        "redpitaya",
        text(["CH1,CH2"] + rows(",", S("%.6f", r.u), S("%.6f", r.y))),
        X,
        None,
        [],
        [],
        "Red Pitaya: CH1, CH2, no time and no rate",
    )
    # LabOne
    r = rec(0.001, 1, 0, 0.8)
    add(
        "53_dev3456_demods_0_sample_r_avg_00000.csv",
        "labone",
        text(
            ["chunk;timestamp;value"]
            + rows(";", ["0"] * r.n, ["%d" % (81234567890 + i * 60000) for i in range(r.n)], ["%.15g" % v for v in r.y])
        ),
        X,
        None,
        [],
        [],
        "LabOne: a single demodulator signal, ticks of unknown clock, no input",
    )
    # Saleae
    r = rec(0.0008, 5, 0, 4.4)
    t, u, y = S("%.9f", r.t), S("%.15f", r.u), S("%.15f", r.y)
    add(
        "54_analog.csv",
        "saleae",
        text(["Time [s],Piezo command,Displacement"] + rows(",", t, u, y)),
        E,
        r.ts,
        V(u),
        V(y),
        "Saleae analog.csv with renamed channels, no units except time",
        chk=pdcsv(1, 2, 0, float_precision="round_trip"),
    )
