"""Controllers of piezo actuators."""

from common import *


def gcs(sep, names, nd, st, units=()):
    return (
        [
            "# REM E-712.3CDA, 0116012345, 01.100",
            "#",
            "# VERSION = 1",
            "# TYPE = 1",
            f"# SEPARATOR = {sep}",
            f"# DIM = {len(names)}",
            f"# SAMPLE_TIME = {st}",
            f"# NDATA = {nd}",
            "#",
        ]
        + [f"# NAME{i} = {n}" for i, n in enumerate(names)]
        + [f"# DISP_UNIT{i} = {x}" for i, x in enumerate(units)]
        + ["#", "# END_HEADER"]
    )


@case(
    "pi_gcs_target_current.dat",
    "PI GCS",
    "GCS record with target beside current position and the output voltage last; separator code 9.",
    check=ck(None, 2, 1, sep="\t", comment="#"),
    tsrx=(r"SAMPLE_TIME = (\S+)", DEC),
)
def _(p):
    r = Rec("gcs1", 5e-5, 100, 100)
    ref = S(np.maximum(r.u, 0), "%.5f")
    u, y = S(r.u, "%.5f"), S(r.y, "%.5f")
    wr(
        p,
        gcs(9, ["Target Position of Axis1", "Current Position of Axis1", "Voltage of OutputChan1"], r.n, "0.000050")
        + rows(ref, y, u, sep="\t"),
    )
    return ok(5e-5, V(u), V(y))


@case(
    "pi_gcs_comma.dat",
    "PI GCS",
    "GCS record of a PC with decimal comma: separator 59 and SAMPLE_TIME = 0,000100.",
    check=ck(None, 0, 1, sep=";", comment="#", decimal=","),
    tsrx=(r"SAMPLE_TIME = (\S+)", DEC),
)
def _(p):
    r = Rec("gcs2", 1e-4, 95, 18)
    u, y = S(r.u, "%.5f"), S(r.y, "%.5f")
    wr(
        p,
        gcs(59, ["Voltage of OutputChan1", "Current Position of Axis1"], r.n, "0,000100", ("V", "um"))
        + rows(comma(u), comma(y), sep=";"),
        nl="\r\n",
    )
    return ok(1e-4, V(u), V(y))


@refuse("pi_gcs_two_axes.dat", "PI GCS", "Two axes with two voltages: which pair is meant is not known.")
def _(p):
    r, q = Rec("gcs3", 1e-4), Rec("gcs3b", 1e-4, n=Rec("gcs3").n, amp=80)
    wr(
        p,
        gcs(
            32,
            [
                "Current Position of Axis1",
                "Voltage of OutputChan1",
                "Current Position of Axis2",
                "Voltage of OutputChan2",
            ],
            r.n,
            "0.0001",
        )
        + rows(S(r.y), S(r.u), S(q.y), S(q.u), sep=" "),
    )


@refuse("pi_gcs_no_voltage.dat", "PI GCS", "Only target and current position: the target position is not a voltage.")
def _(p):
    r = Rec("gcs4", 1e-4)
    wr(
        p,
        gcs(32, ["Target Position of Axis1", "Current Position of Axis1"], r.n, "0.0001")
        + rows(S(r.u), S(r.y), sep=" "),
    )


@refuse(
    "pi_gcs_short.dat",
    "PI GCS",
    "NDATA promises 400 rows, 263 are there and the last one is cut: the transfer broke off.",
)
def _(p):
    r = Rec("gcs5", 1e-4, n=263)
    t = "\n".join(
        gcs(32, ["Voltage of OutputChan1", "Current Position of Axis1"], 400, "0.0001") + rows(S(r.u), S(r.y), sep=" ")
    )
    wr(p, t[:-4])
