#!/usr/bin/env python3
"""Bimorph cantilever +-30 V, 800 um, laser triangulation near the drive: antiresonance between the modes.

Truth: plays with gamma-like thresholds and a quadratic envelope, width 14.4 % -> creep 1.4 % a decade -> modes 130 Hz
(0.012, 0.86), 815 Hz (0.008, 0.14), residues of one sign: antiresonance at 323 Hz. y is read 1/3 sample after the DAC.
Recorded: 5 kHz; small_prbs (+-1.5 V, clock 2 samples, 2 periods); rising sines +-30 V at 3, 15, 50 Hz after
depolarising. 16 bits, noise 0.04 %.
Tests: 31 Hz; random minor loops; chirp 20..600 Hz with 3 V through mode and antiresonance; 15 Hz on another day.
A perfect Hammerstein model: reaches the noise: 0.12 to 0.2 %, the chirp 0.4 %.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p05a_beam_colloc", fs=5000, over=6, analog=False, range=(-30, 30))
stroke, T = 800.0, B.T
M = [(B.jit(130, 0.04), B.jit(0.012, 0.25), 0.86), (B.jit(815, 0.04), B.jit(0.008, 0.25), 0.14)]
g, skew = B.jit(0.014, 0.2), 2
r = np.linspace(0, 33, 80)
w = (r / 7) ** 0.6 * np.exp(-((r / 9.0) ** 1.1))
w *= 0.46 / w.sum()
w[0] = 0.54
hyst = lambda u: plays(u, r, lambda S: S @ w + 1.5e-3 * (S * S) @ w)
size, low, width = loop(hyst, -30, 30)
a, b = M[0][0] ** 2, M[1][0] ** 2
anti = np.sqrt(a * b / (M[0][2] * a + M[1][2] * b))


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - hyst(np.zeros(1))[0]) / size
    return modes(creep_log(z, g * creep, T), M, T)


rising = lambda hz, s, amp=30: lambda t: amp * ramp01(t, 0, 0.85 * s) * np.sin(2 * np.pi * hz * t)
meas = dict(stroke=stroke, noise=4e-4, bits=16, span=2.0, u_range=60, u_bits=16, skew=skew, offset=0.12)
rest, calm = dict(kind="rest", sec=0.6), dict(kind="decay", level=0, amp=30, hz=10, sec=1.5, wait=0.8)
day1, day2 = {}, B.day2()
B.record("small_prbs", 1.5 * prbs(8188, 11, 2), 8188 / B.fs, plant, day1, hist=rest, **dict(meas, span=0.5))
for f, s in ((3, 2.4), (15, 1.4), (50, 0.7)):
    B.record(f"train_{f:02d}Hz", rising(f, s), s, plant, day1, hist=calm, **meas)
B.record("test_rate", rising(31, 1.0), 1.0, plant, day1, hist=calm, **meas)
B.record("test_random", zigzag(B.rng, 3, B.fs, -28, 28, leg=(0.02, 0.25), hold=0.08), 3, plant, day1, hist=calm, **meas)
B.record(
    "test_chirp",
    lambda t: 3 * ramp01(t, 0, 0.1) * np.sin(2 * np.pi * 20 * 2 / np.log(30) * (30 ** (t / 2) - 1)),
    2,
    plant,
    day1,
    hist=calm,
    note="3 V, 20 to 600 Hz",
    **meas,
)
B.record("test_day", rising(15, 1.4), 1.4, plant, day1, day=day2, hist=calm, **meas)
B.finish(
    modes=M,
    antiresonance_Hz=anti,
    delay_samples=-skew / B.over,
    creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=100),
    hysteresis=dict(kind="plays, gamma-like thresholds, quadratic envelope", loop_width_percent=width),
    stroke_um=stroke,
)
