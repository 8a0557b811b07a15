#!/usr/bin/env python3
"""Outside the form, 3: hysteresis inside the loop through the charge. Stack stage 0..100 V, 45 um.

Truth: Goldfarb and Celanovic: R q' = u - rc(q) - v, q = a x + v, x'' + 2 zeta w x' + w^2 (x - v) = 0, rc = eight
Maxwell slip elements driven by the charge; a = 0.5 (coupling k^2 = 0.33), RC 0.15 ms, 380 Hz (0.018) at fixed voltage,
stiffer while the elements stick, damped by their slip. Width 15.8 %. Creep 1.2 % a decade behind. DAC held.
Recorded: 4 kHz; small_prbs (+-1 V about 20 V); a staircase of seven levels; rising sines 0..98 V at 6, 35, 110 Hz. 16
bits, noise 0.02 %. Tests: 65 Hz; random loops; 35 Hz on another day.
A perfect Hammerstein model: the static loop of the same elements followed by one mode of middling frequency and damping
leaves 0.1 / 0.5 / 0.9 / 1.3 % at 6 / 35 / 65 / 110 Hz, 0.15 to 0.25 % on random loops, about 10 % on the staircase:
crude upper bounds; noise 0.07 %.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p17_charge_inside", fs=4000, over=10, analog=False, range=(0, 100))
stroke, T = 45.0, B.T
f0, zeta = B.jit(380, 0.04), B.jit(0.018, 0.25)
a, tau, g = B.jit(0.5, 0.1), B.jit(1.5e-4, 0.15), B.jit(0.012, 0.2)
brk = np.array([1.5, 4, 8, 14, 22, 34, 50, 70])
top = np.array([0.25, 0.6, 1.1, 1.6, 1.9, 1.9, 1.6, 1.2]) * 1.0
k = top / brk


def stack(u, static=False):
    """R q' = u - rc(q) - v, q = a x + v, x'' + 2 zeta w x' + w^2 (x - v) = 0; rc: Maxwell slip elements driven by the
    charge"""
    w0 = 2 * np.pi * f0
    x = v = q = 0.0
    s = np.zeros(len(k))
    y = np.empty(len(u))
    kk, cc = w0 * w0 * T, 2 * zeta * w0 * T
    h = T / tau
    lo, hi = -top, top
    for i, ui in enumerate(u.tolist()):
        y[i] = x
        vt = q / (1 + a) if static else q - a * x
        dq = h * (ui - s.sum() - vt) / (1 + h * (k.sum() + 1))
        q += dq
        s = np.minimum(np.maximum(s + k * dq, lo), hi)
        if static:
            x = y[i] = q / (1 + a)
        else:
            vt = q - a * x
            v = (v - kk * (x - vt)) / (1 + cc)
            x += v * T
    return y


def slow(u):
    return stack(np.repeat(u, 12), True)[11::12]


size, low, width = loop(slow, 0, 100, 1500)


def plant(u, gain=1.0, creep=1.0, ref=None):
    if ref is None:
        x = stack(u)
    else:
        s = ref * k.sum()
        x = lag2(stack(u, True), f0 * np.sqrt(1 + s * a / (1 + s)), zeta * 1.5, T)
    return creep_log(gain * stroke * (x - low) / size, g * creep, T, 5e-3, 5e1)


hammer = lambda u, **p: plant(u, ref=0.55, **p)

rising = lambda hz, s, lo=0.0: lambda t: 49 * ramp01(t, 0, 0.85 * s) * (1 - np.cos(2 * np.pi * hz * t))
meas = dict(stroke=stroke, noise=2e-4, bits=16, span=2.0, u_range=100, u_bits=16, offset=0.1)
after = dict(kind="after", lo=0, hi=100, hz=10, cycles=1, level=0, wait=0.4)
day1, day2 = {}, B.day2()
stair = lambda lv, dt: lambda t: np.array(lv)[np.minimum((t / dt).astype(int), len(lv) - 1)].astype(float)
B.record(
    "small_prbs",
    20 + 1.0 * prbs(8188, 11, 2),
    8188 / B.fs,
    plant,
    day1,
    hist=dict(kind="rest", level=20, sec=0.4),
    **dict(meas, span=1.0),
)
B.record("train_stair", stair([0, 30, 80, 65, 20, 95, 45], 0.15), 1.05, plant, day1, hist=after, **meas)
for f, s in ((6, 1.6), (35, 0.8), (110, 0.4)):
    B.record(f"train_{f:03d}Hz", rising(f, s), s, plant, day1, hist=after, **meas)
B.record("test_rate", rising(65, 0.6), 0.6, plant, day1, hist=after, ref=hammer, **meas)
B.record(
    "test_random",
    zigzag(B.rng, 1.6, B.fs, 3, 97, leg=(0.006, 0.1), hold=0.08),
    1.6,
    plant,
    day1,
    hist=after,
    ref=hammer,
    **meas,
)
B.record("test_day", rising(35, 0.8), 0.8, plant, day1, day=day2, hist=after, ref=hammer, **meas)
B.finish(
    modes=[(f0, zeta, 1.0)],
    modes_note="at fixed voltage; with the slip elements sticking %.1f Hz"
    % (f0 * np.sqrt(1 + k.sum() * a / (1 + k.sum()))),
    coupling=a / (1 + a),
    amplifier_lag_s=[tau],
    delay_samples=0,
    creep=dict(kind="log", per_decade=g, from_s=5e-3, to_s=50),
    hysteresis=dict(
        kind="Maxwell slip of the charge, inside the electromechanical loop (Goldfarb and Celanovic)",
        loop_width_percent=width,
    ),
    stroke_um=stroke,
)
