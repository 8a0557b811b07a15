"""LabVIEW: .lvm."""

from common import *

LVM = lambda dec, xc: [
    "LabVIEW Measurement\t",
    "Writer_Version\t2",
    "Reader_Version\t2",
    "Separator\tTab",
    f"Decimal_Separator\t{dec}",
    "Multi_Headings\tYes",
    f"X_Columns\t{xc}",
    "Time_Pref\tRelative",
    "Operator\tlabuser",
    "Description\tpiezo stack, 3 cycles",
    "Date\t2024/03/05",
    "Time\t10:11:12.1234567",
    "***End_of_Header***\t",
]


def seg(n, x0, dx, time="10:11:12.1234567", c=2, units="Volts\tum", multi=False):
    w = lambda v: ("\t\t" if multi else "\t").join([v] * c)
    return [
        "\t" * c,
        f"Channels\t{c}" + "\t" * c,
        f"Samples\t{w(str(n))}\t",
        "Date\t" + w("2024/03/05") + "\t",
        "Time\t" + w(time) + "\t",
        f"Y_Unit_Label\t{units}\t",
        "X_Dimension\t" + w("Time") + "\t",
        "X0\t" + w(x0) + "\t",
        "Delta_X\t" + w(dx) + "\t",
        "***End_of_Header***" + "\t" * (c + 1),
    ]


@case(
    "lvm_no_x_comma.lvm",
    "LabVIEW",
    "LVM without X column (first cells empty), decimal comma, Delta_X 2,000000E-4, text in the Comment column of the first row.",
    check=ck(None, 1, 2, sep="\t", decimal=",", skiprows=24),
    tsrx=(r"Delta_X\t(\S+)", DEC),
)
def _(p):
    r = Rec("lvm1", 2e-4, 100, 13)
    u, y = S(r.u), S(r.y)
    d = [f"\t{a}\t{b}" for a, b in zip(comma(u), comma(y))]
    d[0] += "\tsample A7, 2 preload turns"
    wr(
        p,
        LVM(",", "No")
        + seg(r.n, "0,0000000000000000E+0", "2,000000E-4")
        + ["X_Value\tVoltage\tDisplacement\tComment"]
        + d,
        nl="\r\n",
    )
    return ok(2e-4, V(u), V(y))


@case(
    "lvm_multi_x.lvm",
    "LabVIEW",
    "LVM with X_Columns Multi: an X_Value column before each channel, displacement first.",
    check=ck(0, 3, 1, sep="\t", skiprows=24),
)
def _(p):
    r = Rec("lvm2", 1e-3, 70, 9)
    t, u, y = S(r.t), S(r.u), S(r.y)
    wr(
        p,
        LVM(".", "Multi")
        + seg(r.n, "0.0E+0", "1.000000E-3", units="um\t\tVolts", multi=True)
        + ["X_Value\tDisplacement\tX_Value\tVoltage\tComment"]
        + rows(t, y, t, u, sep="\t"),
        nl="\r\n",
    )
    return ok(1e-3, V(u), V(y))


@refuse(
    "lvm_two_runs.lvm",
    "LabVIEW",
    "Two LVM segments, taken 7 minutes apart, both starting at X0 = 0: joined they are a false record.",
)
def _(p):
    a, b = Rec("lvm3", 1e-3, n=170), Rec("lvm3b", 1e-3, amp=60, n=170)
    o = LVM(".", "One")
    for r, tm in ((a, "10:11:12.1"), (b, "10:18:40.7")):
        o += (
            seg(r.n, "0.0E+0", "1.000000E-3", tm)
            + ["X_Value\tVoltage\tDisplacement\tComment"]
            + rows(S(r.t), S(r.u), S(r.y), sep="\t")
        )
    wr(p, o, nl="\r\n")


@case(
    "lvm_segments_contiguous.lvm",
    "LabVIEW",
    "Three LVM segments of one run: X0 of each follows on the last sample of the one before.",
    also_ok="refuse: several segments",
    check=lambda p: _seg3(p),
)
def _(p):
    r = Rec("lvm4", 1e-3, 80, 8, n=240)
    t, u, y = S(r.t), S(r.u), S(r.y)
    o = LVM(".", "One")
    for k in (0, 80, 160):
        s = slice(k, k + 80)
        o += (
            seg(80, "%.6E" % (k * 1e-3), "1.000000E-3", "10:11:12.%03d" % (100 + k))
            + ["X_Value\tVoltage\tDisplacement\tComment"]
            + rows(t[s], u[s], y[s], sep="\t")
        )
    wr(p, o, nl="\r\n")
    return ok(1e-3, V(u), V(y))


def _seg3(p):
    import io

    o = pd.concat(
        [
            pd.read_csv(io.StringIO(b), sep="\t", header=None, nrows=80)
            for b in open(p, newline="").read().split("Comment\r\n")[1:]
        ]
    )
    return tuple(o.iloc[:, c].astype(float).to_numpy() for c in range(3))
