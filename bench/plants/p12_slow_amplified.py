#!/usr/bin/env python3
"""Slow long-stroke lever actuator, 500 um at 0..150 V, 200 Hz sampling, temperature drift.

Truth: plays, stretched exponential, cubic envelope, width 10.9 % -> creep 1.8 % a decade (5 ms to 300 s) -> modes 35 Hz
(0.015, 0.97), 141 Hz (0.02, 0.03: above Nyquist, aliased). y read 0.35 sample after the DAC (12 bits). Drift: 0.45..0.9
% of stroke * (1 - exp(-t/40 s)), either sign, and a random walk of 0.04 % a root second.
Recorded: 200 Hz; rising sines 0..148 V at 0.2, 1, 5 Hz (25, 17, 11 s). Triangulation sensor, 14 bits, noise 0.1 %.
Tests: 2.3 Hz; random loops 25 s with pauses; 1 Hz on another day.
A perfect Hammerstein model: noise 0.32 to 0.38 %, with the drift, which nobody can predict, 0.4 to 0.6 %; other day 0.6
to 1 %.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p12_slow_amplified", fs=200, over=20, analog=False, range=(0, 150))
stroke, T = 500.0, B.T
M = [(B.jit(35, 0.04), B.jit(0.015, 0.25), 0.97), (B.jit(141, 0.04), B.jit(0.02, 0.25), 0.03)]
g, skew = B.jit(0.018, 0.2), 7
r = np.linspace(0, 80, 70)
w = np.exp(-((r / 24.0) ** 1.5))
w *= 0.50 / w.sum()
w[0] = 0.50
hyst = lambda u: plays(u, r, lambda S: (S + 1.4e-3 * S * S - 5.5e-6 * S**3) @ w)
size, low, width = loop(hyst, 0, 150)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return modes(creep_log(z, g * creep, T, 5e-3, 3e2), M, T)


def drift(t, rng):
    """warming up of the lever frame (time constant 40 s) and the room: of stroke"""
    walk = np.cumsum(rng.standard_normal(len(t))) * np.sqrt(B.Ts)
    return 0.009 * rng.uniform(0.5, 1) * rng.choice([-1, 1]) * (1 - np.exp(-t / 40)) + 4e-4 * walk


rising = lambda hz, s, rest=1.0: (
    lambda t: 74 * ramp01(t, rest, rest + 0.8 * s) * (1 - np.cos(2 * np.pi * hz * np.maximum(t - rest, 0)))
)
meas = dict(stroke=stroke, noise=1e-3, bits=14, span=1.4, u_range=150, u_bits=12, skew=skew, drift=drift, offset=0.2)
after = dict(kind="after", lo=0, hi=150, hz=0.5, cycles=2, level=0, wait=10.0)
day1, day2 = {}, B.day2()
for f, s in ((0.2, 24.0), (1, 16.0), (5, 10.0)):
    B.record(f"train_{f:03.1f}Hz", rising(f, s), s + 1, plant, day1, hist=after, **meas)
B.record("test_rate", rising(2.3, 12), 13, plant, day1, hist=after, **meas)
B.record("test_random", zigzag(B.rng, 25, B.fs, 3, 147, leg=(0.06, 1.5), hold=0.1), 25, plant, day1, hist=after, **meas)
B.record("test_day", rising(1, 16), 17, plant, day1, day=day2, hist=after, **meas)
B.finish(
    modes=M,
    note="the second mode lies above Nyquist (100 Hz)",
    delay_samples=-skew / B.over,
    creep=dict(kind="log", per_decade=g, from_s=5e-3, to_s=300),
    drift="0.45 to 0.9 % of stroke * (1 - exp(-t/40 s)) and a random walk of 0.04 % per sqrt(s)",
    hysteresis=dict(kind="plays, stretched exponential, cubic envelope", loop_width_percent=width),
    stroke_um=stroke,
)
