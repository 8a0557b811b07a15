#!/usr/bin/env python3
"""Small +-75 V actuator, 12 um, with a sharp ridge in the Preisach density.

Truth: Preisach (66 %): ridge at coercive 7 V (sd 0.7 V) over an exponential ground; reversible part cubic; width 11.3
%. Only the switching part creeps, 3 % a decade. Modes 690 Hz (0.015, 0.9), 1720 Hz (0.03, 0.1). Analog generator.
Recorded: 5 kHz; rising sines to +-73 V at 4, 25, 80 Hz after depolarising. 16 bits, noise 0.03 %.
Tests: 50 Hz; random loops; two sines whose minor loops are as wide as the ridge; 25 Hz on another day.
A perfect Hammerstein model: the noise is 0.1 to 0.2 %. Creep of one part alone is not quite the form (operator, then
creep of all of it): the truth with its creep on both parts leaves 0.2 to 0.4 %; a better compromise exists, so that is
an upper bound.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p10_preisach_ridge", fs=5000, over=6, analog=True, range=(-75, 75))
stroke, T = 12.0, B.T
M = [(B.jit(690, 0.04), B.jit(0.015, 0.25), 0.9), (B.jit(1720, 0.04), B.jit(0.03, 0.25), 0.1)]
g = B.jit(0.030, 0.2)
ridge = lambda h, i: np.exp(-0.5 * ((h - 7.0) / 0.7) ** 2) * np.exp(-0.5 * ((i + 8) / 38) ** 2)
dens = lambda a, b: ridge((a - b) / 2, (a + b) / 2) + 0.05 * np.exp(-(a - b) / 2 / 13)
E = everett_table(dens, -80, 80, 800)
top = E(75, -75)
share = 0.66
demag = [x for k in range(80) for x in (78 * 0.94**k, -78 * 0.94 ** (k + 0.5))]
rev = lambda v: v / 150 * (1 - 1.6e-5 * v * v + 8e-4 * v)
irr = lambda v: preisach(v, E, -80, demag) / top
hyst = lambda v: (1 - share) * rev(np.asarray(v, float)) + share * irr(v)
size, low, width = loop(hyst, -75, 75)
zero = irr([0.0])[0]


def plant(u, gain=1.0, creep=1.0, whole=False):
    k = gain * stroke / size  # only the switching part creeps
    if whole:
        return modes(k * creep_log((1 - share) * rev(u) + share * (irr(u) - zero), g * share, T, 1e-3, 1e2), M, T)
    return modes(k * (1 - share) * rev(u) + k * share * creep_log(irr(u) - zero, g * creep, T, 1e-3, 1e2), M, T)


whole = lambda u, **p: plant(u, whole=True, **p)

rising = lambda hz, s, amp=73: lambda t: amp * ramp01(t, 0, 0.85 * s) * np.sin(2 * np.pi * hz * t)
meas = dict(stroke=stroke, ref=whole, noise=3e-4, bits=16, span=2.0, u_range=200, u_bits=16, offset=0.1)
calm = dict(kind="decay", level=0, amp=75, hz=10, sec=1.5, wait=0.8)
day1, day2 = {}, B.day2()
for f, s in ((4, 3.0), (25, 1.2), (80, 0.5)):
    B.record(f"train_{f:02d}Hz", rising(f, s), s, plant, day1, hist=calm, **meas)
B.record("test_rate", rising(50, 0.8), 0.8, plant, day1, hist=calm, **meas)
B.record("test_random", zigzag(B.rng, 3, B.fs, -70, 70, leg=(0.01, 0.2), hold=0.08), 3, plant, day1, hist=calm, **meas)
B.record(
    "test_small",
    lambda t: 25 * ramp01(t, 0, 0.2) * np.sin(2 * np.pi * 11 * t) + 9 * np.sin(2 * np.pi * 67 * t) * ramp01(t, 0, 0.2),
    2,
    plant,
    day1,
    hist=calm,
    note="minor loops as wide as the ridge",
    **meas,
)
B.record("test_day", rising(25, 1.2), 1.2, plant, day1, day=day2, hist=calm, **meas)
B.finish(
    modes=M,
    delay_samples=0,
    creep=dict(kind="log, switching part alone", per_decade_of_that_part=g, from_s=1e-3, to_s=100),
    hysteresis=dict(
        kind="Preisach, ridge at coercive 7 V (sd 0.7 V) over an exponential ground, and cubic reversible part",
        share_irreversible=share,
        loop_width_percent=width,
    ),
    stroke_um=stroke,
)
