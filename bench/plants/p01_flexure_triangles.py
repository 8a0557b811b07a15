#!/usr/bin/env python3
"""Flexure stage, 100 um at 0..100 V, strain gauge; triangles at three rates, nothing else.

Truth: generalised plays with a quadratic envelope, loop width 13.6 % -> creep 1.2 % a decade (1 ms to 100 s) -> modes
460 Hz (damping 0.020, share 0.92), 1350 Hz (0.015, 0.06), residual 0.02 -> strain-gauge amplifier, first order 0.106
ms. The function generator is analog: corners fall between samples.
Recorded: 5 kHz; full-stroke triangles at 2, 10, 40 Hz (3, 2, 1 s), the first one from the virgin state at 0 V, the
others after earlier cycles. 16 bits, white noise 0.04 % and 1/f noise 0.025 % of stroke. Tests: triangle 22 Hz; random
minor loops with pauses; 10 Hz on another day, from the virgin state.
A perfect Hammerstein model: reaches the noise, 0.15 to 0.18 % NRMSE; the plant has that form. Minor loops and turning
points inside the range are in no training record: the share of the single plays is known from the first rise and the
full loop only, so test_random tells regularisation from luck. Other day: 0.3 % (gain, creep).
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p01_flexure_triangles", fs=5000, over=8, analog=True, range=(0, 100))
stroke, T = 100.0, B.T
M = [(B.jit(460, 0.04), B.jit(0.020, 0.25), 0.92), (B.jit(1350, 0.04), B.jit(0.015, 0.25), 0.06)]
g, tau_s = B.jit(0.012, 0.2), B.jit(1.06e-4, 0.1)
r = np.linspace(0, 56, 90)
w = np.exp(-((r / 15.0) ** 1.25)) * (r[1] - r[0]) / 15
w[0] = 0.62
curve = lambda s: s + 1.1e-3 * s * s
value = lambda S: curve(S) @ w
hyst = lambda u: plays(u, r, value)
size, low, width = loop(hyst, 0, 100)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return lag(modes(creep_log(z, g * creep, T, 1e-3, 1e2), M, T, residual=0.02), tau_s, T)


u = lambda f: lambda t: 50 * (1 + tri(t, f))
meas = dict(stroke=stroke, noise=4e-4, pink=2.5e-4, bits=16, span=1.6, offset=0.07, u_range=120, u_bits=16)
after = dict(kind="after", lo=0, hi=100, hz=5, cycles=2, level=0, wait=0.8)
day1, day2 = {}, B.day2()
for f, s, h in ((2, 3.0, dict(kind="rest", sec=0.5)), (10, 2.0, after), (40, 1.0, after)):
    B.record(f"train_tri{f:02d}", u(f), s, plant, day1, hist=h, **meas)
B.record("test_rate", u(22), 1.2, plant, day1, hist=after, **meas)
x = zigzag(B.rng, 3, B.fs, 2, 98, leg=(0.008, 0.12), start=0, hold=0.1)
B.record("test_random", x, 3, plant, day1, hist=after, **meas)
B.record("test_day", u(10), 2, plant, day1, day=day2, hist=dict(kind="rest", sec=0.5), **meas)
B.finish(
    modes=M,
    residual=0.02,
    sensor_lag_s=[tau_s],
    delay_samples=0,
    creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=100),
    hysteresis=dict(kind="generalised plays, quadratic envelope", loop_width_percent=width),
    stroke_um=stroke,
)
