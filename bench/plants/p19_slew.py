#!/usr/bin/env python3
"""Outside the form, 4: amplifier with a current limit. Stage 0..100 V, 90 um.

Truth: amplifier lag 0.15 ms whose rate cannot exceed 10.5 V/ms -> plays, cubic envelope, width 9.5 % -> creep 1.3 % a
decade -> mode 270 Hz (0.02, 0.97), residual 0.03. The logged u is the command.
Recorded: 10 kHz, analog generator; rising sines 0..99 V at 4, 16, 36 Hz (the last touches the limit: 11.2 V/ms), a
square of +-0.5 V. 16 bits, noise 0.02 %.
Tests: 25 Hz; 45 Hz (the limit bites); random loops; 16 Hz on another day.
A perfect Hammerstein model: without the limit: the noise (0.07 %) up to 25 Hz, 1.6 to 2.2 % at 36 Hz, 12 % at 45 Hz,
0.6 to 4 % on the random loops with fast legs.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p19_slew", fs=10000, over=4, analog=True, range=(0, 100))
stroke, T = 90.0, B.T
M = [(B.jit(270, 0.04), B.jit(0.02, 0.25), 0.97)]
g, slew, tau_a = B.jit(0.013, 0.2), B.jit(10500.0, 0.1), 1.5e-4
r = np.linspace(0, 55, 72)
w = np.exp(-(r / 17.0))
w *= 0.40 / w.sum()
w[0] = 0.60
hyst = lambda u: plays(u, r, lambda S: (S + 1.2e-3 * S * S - 5e-6 * S**3) @ w)
size, low, width = loop(hyst, 0, 100)


def amplifier(u, limit):
    """first-order lag whose rate cannot exceed I/C"""
    v = u[0]
    y = np.empty(len(u))
    k = T / tau_a
    top = limit * T
    for i, x in enumerate(u.tolist()):
        d = k * (x - v)
        v += top if d > top else -top if d < -top else d
        y[i] = v
    return y


def plant(u, gain=1.0, creep=1.0, limit=None):
    z = gain * stroke * (hyst(amplifier(u, limit or slew)) - low) / size
    return modes(creep_log(z, g * creep, T), M, T, residual=0.03)


free = lambda u, **p: plant(u, limit=1e9, **p)

rising = lambda hz, s: lambda t: 49.5 * ramp01(t, 0, 0.85 * s) * (1 - np.cos(2 * np.pi * hz * t))
meas = dict(stroke=stroke, noise=2e-4, bits=16, span=1.5, u_range=120, u_bits=16, offset=0.06)
after = dict(kind="after", lo=0, hi=100, hz=6, cycles=2, level=0, wait=0.8)
day1, day2 = {}, B.day2()
for f, s in ((4, 2.2), (16, 1.2), (36, 0.8)):
    B.record(f"train_{f:02d}Hz", rising(f, s), s, plant, day1, hist=after, ref=free, **meas)
B.record(
    "small_square",
    lambda t: 50 + 0.5 * np.sign(np.sin(2 * np.pi * 12 * t + 1e-9)),
    1.0,
    plant,
    day1,
    hist=dict(kind="rest", level=50, sec=0.5),
    ref=free,
    **dict(meas, span=1.0),
)
B.record("test_rate", rising(25, 0.9), 0.9, plant, day1, hist=after, ref=free, **meas)
B.record(
    "test_fast",
    rising(45, 0.7),
    0.7,
    plant,
    day1,
    hist=after,
    ref=free,
    note="faster than any training record: the limit bites",
    **meas,
)
B.record(
    "test_random",
    zigzag(B.rng, 2.5, B.fs, 3, 97, leg=(0.006, 0.15), hold=0.08),
    2.5,
    plant,
    day1,
    hist=after,
    ref=free,
    **meas,
)
B.record("test_day", rising(16, 1.2), 1.2, plant, day1, day=day2, hist=after, ref=free, **meas)
B.finish(
    modes=M,
    residual=0.03,
    amplifier=dict(lag_s=tau_a, slew_V_per_s=slew),
    delay_samples=0,
    creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=100),
    hysteresis=dict(kind="plays, exponential, cubic envelope", loop_width_percent=width),
    stroke_um=stroke,
)
