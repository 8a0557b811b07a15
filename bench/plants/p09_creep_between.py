#!/usr/bin/env python3
"""Heavy 200 um stage 0..100 V; creep lags between the decades, long records with pauses.

Truth: Preisach, gamma-like in coercive voltage (37 %), and bowed reversible part, width 14 % -> creep lags 0.03, 0.4, 7
s of 1.6, 2.0, 2.6 % -> mode 95 Hz (0.05). DAC held. Drift 1e-5..4e-5 of stroke a second.
Recorded: 1 kHz; two records of 28 s as by hand: ramps of 4 ms to 1 s, bursts of sines, pauses of 1.5..6 s. 16 bits,
noise 0.02 %.
Tests: rising sine 17 Hz; random loops 15 s; a programme with pauses of 3..9 s; another day.
A perfect Hammerstein model: reaches the noise, 0.06 to 0.1 %, plus the drift (0.02 to 0.04 %). The unknown past costs
up to 0.1 %. Other day up to 1.3 %: 20 % of 6 % creep.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p09_creep_between", fs=1000, over=4, analog=False, range=(0, 100))
stroke, T = 200.0, B.T
M = [(B.jit(95, 0.04), B.jit(0.05, 0.25), 1.0)]
taus, gains = (0.03, 0.4, 7.0), [B.jit(x, 0.2) for x in (0.016, 0.020, 0.026)]
dens = lambda a, b: (a - b + 3) * np.exp(-(a - b) / 2 / 8.5) * np.exp(-0.5 * (((a + b) / 2 - 35) / 45) ** 2)
E = everett_table(dens, 0, 100)
top = E(100, 0)
share = 0.37
hyst = lambda u: (1 - share) * np.asarray(u) / 100 * (1.08 - 8e-4 * np.asarray(u)) + share * preisach(u, E, 0) / top
size, low, width = loop(hyst, 0, 100)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return modes(creep_lags(z, taus, [creep * x for x in gains], T), M, T)


def program(rng, seconds, pause=(1.5, 6)):
    """what a user does by hand: ramps and bursts of sines to and at random levels, pauses between"""
    out, v, n = [np.zeros(int(0.5 * B.fs))], 0.0, int(0.5 * B.fs)
    while n < seconds * B.fs:
        w = rng.uniform(5, 95)
        k = int(np.exp(rng.uniform(np.log(0.004), np.log(1.0))) * B.fs)
        x = v + (w - v) * np.arange(1, k + 1) / k
        h = int(rng.uniform(*pause) * B.fs)
        if rng.random() < 0.4:
            hz = np.exp(rng.uniform(np.log(1), np.log(12)))
            c = int(np.ceil(rng.integers(2, 6) / hz * B.fs))
            a = rng.uniform(0.3, 0.95) * min(w, 100 - w)
            y = w + a * np.sin(2 * np.pi * hz * np.arange(c) / B.fs)
        else:
            y = np.zeros(0)
        out += [x, y, np.full(h, w)]
        n += len(x) + len(y) + h
        v = w
    return np.clip(np.concatenate(out), 0, 100)[: int(seconds * B.fs)]


drift = lambda t, rng: rng.uniform(1, 4) * 1e-5 * rng.choice([-1, 1]) * t
meas = dict(stroke=stroke, drift=drift, noise=2e-4, bits=16, span=1.3, u_range=100, u_bits=16, offset=0.04)
after = dict(kind="after", lo=0, hi=100, hz=2, cycles=2, level=0, wait=4.0)
day1, day2 = {}, B.day2()
for k in "ab":
    B.record(
        "train_" + k, program(B.rng, 28), 28, plant, day1, hist=dict(after, wait=15.0) if k == "a" else after, **meas
    )
B.record(
    "test_rate", lambda t: 48 * ramp01(t, 0, 3) * (1 - np.cos(2 * np.pi * 17 * t)), 4, plant, day1, hist=after, **meas
)
B.record("test_random", zigzag(B.rng, 15, B.fs, 3, 97, leg=(0.03, 1.2), hold=0.15), 15, plant, day1, hist=after, **meas)
B.record("test_pauses", program(B.rng, 25, (3, 9)), 25, plant, day1, hist=after, **meas)
B.record("test_day", program(B.rng, 20), 20, plant, day1, day=day2, hist=after, **meas)
B.finish(
    modes=M,
    delay_samples=0,
    creep=dict(kind="lags", taus_s=taus, gains=gains),
    hysteresis=dict(kind="Preisach, gamma-like coercive density, and reversible part", loop_width_percent=width),
    stroke_um=stroke,
)
