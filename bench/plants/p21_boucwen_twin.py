#!/usr/bin/env python3
"""Outside operators that wipe out: a simulated bender in the manner of the literature (Low and Guo), +-30 V, 2 mm, 2
kHz.

Truth: Bouc-Wen (Low and Guo: alpha 0.32, beta 0.020, gamma 0.005 1/V), width 11.5 % -> creep 1.2 % a decade (10 ms to
10 s) -> modes 151 Hz (0.025, 0.891), 946 Hz (0.020, 0.079), residual 0.03 -> lag 0.2 ms. DAC held.
Recorded: 2 kHz; small_prbs (+-1 V, clock 1); rising sines at 5, 20, 80 Hz from the virgin state. 16 bits, noise 0.01 %.
Tests: 40 Hz; a stepped sine 20 Hz of 20 steps a period; random minor loops; 20 Hz on another day.
A perfect Hammerstein model: the form is Hammerstein and reaches the noise with a Bouc-Wen operator. Its minor loops do
not close: a generalised play model fitted to the static loops of rising sines leaves 1.1 % there, 8 % on random minor
loops, 1.7 % on the stepped sine. Measured ceramics do wipe out: weigh this plant as a twin, not as a measurement.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p21_boucwen_twin", fs=2000, over=10, analog=False, range=(-30, 30))
stroke, T = 2000.0, B.T
M = [(B.jit(151, 0.04), B.jit(0.025, 0.25), 0.891), (B.jit(946, 0.04), B.jit(0.020, 0.25), 0.079)]
g, tau_d = B.jit(0.012, 0.2), B.jit(2e-4, 0.1)


def boucwen(u, alpha=0.32, beta=0.020, gamma=0.005):
    """h' = alpha u' - beta |u'| h - gamma u' |h|, exact between samples but for the sign of h"""
    h = 0.0
    out = np.empty(len(u))
    out[0] = 0.0
    d = np.diff(u)
    for k in np.flatnonzero(d):
        x = d[k]
        s = beta + gamma * (1 if h * x > 0 else -1)
        e = alpha / s * (1 if x > 0 else -1)
        h = e + (h - e) * np.exp(-s * abs(x))
        out[k + 1] = h
    i = np.maximum.accumulate(np.where(np.r_[True, d != 0], np.arange(len(u)), 0))
    return out[i]


hyst = lambda u: u - boucwen(np.r_[0.0, u])[1:]
size, low, width = loop(hyst, -30, 30)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * hyst(u) / size
    return lag(modes(creep_log(z, g * creep, T, 1e-2, 1e1), M, T, residual=0.03), tau_d, T)


rising = lambda hz, s, amp=30: lambda t: amp * ramp01(t, 0, 0.85 * s) * np.sin(2 * np.pi * hz * t)
meas = dict(stroke=stroke, noise=1e-4, bits=16, span=2.0, u_range=60, u_bits=16)
rest = dict(kind="rest", sec=0.6)
day1, day2 = {}, B.day2()
B.record("small_prbs", 1.0 * prbs(4094, 11, 1), 2.047, plant, day1, hist=rest, **dict(meas, span=0.4))
for f, s in ((5, 3.0), (20, 1.5), (80, 0.6)):
    B.record(f"train_{f:02d}Hz", rising(f, s), s, plant, day1, hist=rest, **meas)
B.record("test_rate", rising(40, 1.0), 1.0, plant, day1, hist=rest, **meas)
B.record(
    "test_stepwise",
    lambda t: 30 * np.round(7 * np.sin(2 * np.pi * 20 * np.floor(t * 400) / 400)) / 7,
    1.0,
    plant,
    day1,
    hist=rest,
    note="20 Hz sine of 20 steps a period",
    **meas,
)
B.record("test_random", zigzag(B.rng, 3, B.fs, -28, 28, leg=(0.015, 0.2), hold=0.08), 3, plant, day1, hist=rest, **meas)
B.record("test_day", rising(20, 1.5), 1.5, plant, day1, day=day2, hist=rest, **meas)
B.finish(
    modes=M,
    residual=0.03,
    lag_s=[tau_d],
    delay_samples=0,
    creep=dict(kind="log", per_decade=g, from_s=1e-2, to_s=10),
    hysteresis=dict(
        kind="Bouc-Wen of Low and Guo, alpha .32 beta .020 gamma .005: minor loops do not close",
        loop_width_percent=width,
    ),
    stroke_um=stroke,
)
