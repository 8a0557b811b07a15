#!/usr/bin/env python3
"""Outside the form, 1: sensor curve behind the dynamics. Stack stage 0..100 V, 60 um.

Truth: Preisach (50 %) and reversible part, width 11.8 % -> creep 1.4 % a decade -> modes 400 Hz (0.020, 0.95), 1500 Hz
(0.02, 0.05) -> y + 4 * 0.01 * y (1 - y/60 um): 1 % of stroke at mid stroke. Analog generator.
Recorded: 5 kHz; rising sines 0..98 V at 5, 40, 150 Hz; a square 25/75 V whose edges take 0.2 ms (ring-downs). 16 bits,
noise 0.02 %. Tests: 85 Hz; random loops; 40 Hz on another day.
A perfect Hammerstein model: the curve moved in front of the dynamics leaves 0.08 % at 5 and 40 Hz (noise 0.065 %), 0.22
% at 85 Hz, 0.47 % at 150 Hz, 0.7 % on the ring: upper bounds. The damage is where the mode swings.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p15_sensor_curve", fs=5000, over=6, analog=True, range=(0, 100))
stroke, T = 60.0, B.T
M = [(B.jit(400, 0.04), B.jit(0.020, 0.25), 0.95), (B.jit(1500, 0.04), B.jit(0.02, 0.25), 0.05)]
g, bow = B.jit(0.014, 0.2), 0.01
dens = lambda a, b: np.exp(-((a - b) / 2 / 10.0)) * np.exp(-0.5 * (((a + b) / 2 - 30) / 40) ** 2)
E = everett_table(dens, 0, 100)
top = E(100, 0)
share = 0.50
hyst = lambda u: (1 - share) * np.asarray(u) / 100 + share * preisach(np.clip(u, 0, 100), E, 0) / top
size, low, width = loop(hyst, 0, 100)
curve = lambda x: x + 4 * bow * x * (1 - x / stroke)  # largest deviation from the chord: 1 % of stroke, at mid stroke


def plant(u, gain=1.0, creep=1.0, before=False):
    z = gain * stroke * (hyst(u) - low) / size
    return modes(creep_log(curve(z), g * creep, T), M, T) if before else curve(modes(creep_log(z, g * creep, T), M, T))


hammer = lambda u, **p: plant(u, before=True, **p)

rising = lambda hz, s: lambda t: 49 * ramp01(t, 0, 0.85 * s) * (1 - np.cos(2 * np.pi * hz * t))
meas = dict(stroke=stroke, noise=2e-4, bits=16, span=1.4, u_range=120, u_bits=16, offset=0.05)
after = dict(kind="after", lo=0, hi=100, hz=5, cycles=2, level=0, wait=1.0)
day1, day2 = {}, B.day2()
for f, s in ((5, 2.4), (40, 1.0), (150, 0.5)):
    B.record(f"train_{f:03d}Hz", rising(f, s), s, plant, day1, hist=after, ref=hammer, **meas)
sq = lambda t: np.where(t < 0.05, 0, 25 + 50 * (np.mod(t / 0.11, 2) >= 1.0)) * 1.0
B.record("train_square", lambda t: lag(sq(t), 2e-4, T), 1.0, plant, day1, hist=after, ref=hammer, **meas)
B.record("test_rate", rising(85, 0.7), 0.7, plant, day1, hist=after, ref=hammer, **meas)
B.record(
    "test_random",
    zigzag(B.rng, 3, B.fs, 2, 98, leg=(0.005, 0.12), hold=0.08),
    3,
    plant,
    day1,
    hist=after,
    ref=hammer,
    **meas,
)
B.record("test_day", rising(40, 1.0), 1.0, plant, day1, day=day2, hist=after, ref=hammer, **meas)
B.finish(
    modes=M,
    delay_samples=0,
    sensor_curve_behind=dict(kind="quadratic", deviation_of_stroke=bow),
    creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=100),
    hysteresis=dict(kind="Preisach and reversible part", loop_width_percent=width),
    stroke_um=stroke,
)
