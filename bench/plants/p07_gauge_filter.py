#!/usr/bin/env python3
"""Amplified stage 0..150 V, 105 um; strain-gauge electronics with a second-order low pass behind the sensor.

Truth: generalised plays with different cubic edges for rise and fall, width 9.9 % -> creep 1.3 % a decade (2 ms to 50
s) -> modes 1150 Hz (0.025, 0.93), 2900 Hz (0.020, 0.05), residual 0.02 -> low pass 300 Hz, damping 0.72. DAC held.
Recorded: 10 kHz; rising sines 0..148 V at 10 and 100 Hz, a staircase of eight levels. 16 bits, white noise 0.01 % and
1/f noise 0.03 %.
Tests: 45 Hz; random loops; 100 Hz on another day.
A perfect Hammerstein model: reaches the noise, 0.11 to 0.16 %. The modes are hidden behind the filter (1150 Hz is
damped 15 times), the filter's pair is what the records show. Other day 0.3 to 0.65 %.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p07_gauge_filter", fs=10000, over=5, analog=False, range=(0, 150))
stroke, T = 105.0, B.T
M = [(B.jit(1150, 0.04), B.jit(0.025, 0.25), 0.93), (B.jit(2900, 0.04), B.jit(0.020, 0.25), 0.05)]
fil = (B.jit(300, 0.05), B.jit(0.72, 0.08))
g = B.jit(0.013, 0.2)
r = np.linspace(0, 75, 100)
w = np.exp(-0.5 * ((r - 14) / 9.0) ** 2) + 0.6 * np.exp(-r / 25)
w *= 0.42 / w.sum()
w[0] = 0.58
up = lambda v: v + 5e-4 * v * v - 2.2e-6 * v**3
down = lambda v: v + 7e-4 * v * v - 3.2e-6 * v**3
hyst = lambda u: plays(u, r, lambda S: S @ w, up=up, down=down)
size, low, width = loop(hyst, 0, 150)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return lag2(modes(creep_log(z, g * creep, T, 2e-3, 5e1), M, T, residual=0.02), *fil, T)


rising = lambda hz, s, rest=0.1: (
    lambda t: 74 * ramp01(t, rest, rest + 0.85 * s) * (1 - np.cos(2 * np.pi * hz * np.maximum(t - rest, 0)))
)
meas = dict(stroke=stroke, noise=1e-4, pink=3e-4, bits=16, span=1.5, u_range=160, u_bits=16, offset=-0.03)
after = dict(kind="after", lo=0, hi=150, hz=6, cycles=2, level=0, wait=0.7)
day1, day2 = {}, B.day2()
for f, s in ((10, 1.6), (100, 0.4)):
    B.record(f"train_{f:03d}Hz", rising(f, s), s + 0.1, plant, day1, hist=after, **meas)
stair = lambda t: np.array([0, 30, 90, 140, 75, 110, 20, 60])[np.minimum((t / 0.18).astype(int), 7)].astype(float)
B.record("train_stair", stair, 1.44, plant, day1, hist=after, **meas)
B.record("test_rate", rising(45, 0.8), 0.9, plant, day1, hist=after, **meas)
B.record("test_random", zigzag(B.rng, 2, B.fs, 3, 147, leg=(0.004, 0.1), hold=0.1), 2, plant, day1, hist=after, **meas)
B.record("test_day", rising(100, 0.4), 0.5, plant, day1, day=day2, hist=after, **meas)
B.finish(
    modes=M,
    residual=0.02,
    sensor_filter=dict(f_Hz=fil[0], zeta=fil[1]),
    delay_samples=0,
    creep=dict(kind="log", per_decade=g, from_s=2e-3, to_s=50),
    hysteresis=dict(kind="generalised plays, different cubic edges up and down", loop_width_percent=width),
    stroke_um=stroke,
)
