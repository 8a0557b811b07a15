#!/usr/bin/env python3
"""Bimorph bender +-30 V, 1.1 mm, resonance 82 Hz, laser triangulation; dying sines and steps.

Truth: Bouc-Wen driven by the voltage, with six shape factors (Song and Der Kiureghian), so up and down, plus and minus
differ, exponent 1.25; does not wipe out -> creep, three lags 0.06, 0.9, 11 s -> modes 82 Hz (0.013), 514 Hz (0.01,
share 0.07: far beyond where 2.5 kHz is 20 times as fast) -> laser: 0.5 um steps, mean over one sample, 1.4 samples
late, hum. DAC-held, 2.5 kHz. Tests: sine 5 Hz 22 V; random stairs; random path to 9 Hz.
"""
from rig import *

R = Rig("p25_bender_ringdown", fs=2500, over=10, held=True, range=(-30, 30))
T, stroke = R.T, 1100.0
modes = [(R.jit(82, .04), R.jit(.013, .25), .93), (R.jit(514, .03), .010, .07)]
lags = [(.06, .014), (.9, R.jit(.013, .2)), (11.0, .016)]
A, n = .27, 1.25
B = np.array([.062, .014, .004, .070, .008, -.003]) * .55

def boucwen(u):
    """h of the voltages u in substeps of at most 0.1 V"""
    h, last, out = 0.0, float(u[0]), np.empty(len(u))
    b1, b2, b3, b4, b5, b6 = B
    for j, x in enumerate(u.tolist()):
        d = x - last
        if d:
            m = int(abs(d) / .1) + 1; e = d / m; s = 1.0 if d > 0 else -1.0
            for _ in range(m):
                sh = 1.0 if h >= 0 else -1.0; su = 1.0 if last >= 0 else -1.0
                psi = b1 * s * sh + b2 * s * su + b3 * su * sh + b4 * .25 + b5 * sh * .5 + b6 * su
                h += e * (A - abs(h) ** n * psi); last += e
            last = x
        out[j] = h
    return out

rev = lambda u: u + 9e-4 * u * u - 6e-5 * u ** 3
_z = lambda u: rev(u) - boucwen(u)
size, low, width = loop(_z, -30, 30)

def plant(u):
    z = _z(u[::R.over]) / size * stroke
    z = np.repeat(z + sum(k * lag(z, tau, R.Ts) for tau, k in lags), R.over)
    y = modal(z, modes, T)
    y = lfilter(np.ones(10) / 10, 1, y - y[0]) + y[0]
    return np.r_[np.full(9, y[0]), y[:-9]]                     # 9 + 4.5 fine steps: 1.4 samples

m = dict(stroke=stroke, white=6e-4, pink=2e-4, hum=3e-4, lsb=.5, u_lsb=80 / 65536, offset=.4,
         hist="rest", level=0, sec=.5)
die = lambda hz, amp, tau: lambda t: amp * np.exp(-t / tau) * np.sin(2 * np.pi * hz * t)
R.record("train_dying_2Hz", die(2, 30, 5.5), 16.0, plant, **m)
R.record("train_dying_9Hz", die(9, 28, 2.2), 7.0, plant, **m)
lv = [0, 10, 20, 30, 15, 0, -15, -30, -20, -10, 0, 25, -5, 12, -25, 5, -12, 20, -2, 8, 0, 30, 0, -30, 0]
R.record("train_steps", np.repeat(np.array(lv, float), int(.8 * 2500)), len(lv) * .8, plant, **m)
R.record("test_sine5Hz", soft(lambda t: 22 * np.sin(2 * np.pi * 5 * t), 0, .3), 5.0, plant, **m)
R.record("test_stairs", stairs(R.rng, 8.0, R.fs, -28, 28, (.05, .6), 18, 0), 8.0, plant, **m)
R.record("test_random", soft(path(R.rng, .3, 9, -28, 28, 8.0, 40), 0, .3), 8.0, plant, **m)
R.finish(modes=modes, sensor=dict(kind="mean over one sample", lsb_um=.5), delay_samples=1.4,
         creep=dict(kind="three lags", s_and_gain=lags),
         hysteresis=dict(kind="Bouc-Wen, six factors, exponent 1.25", A=A, factors=B, loop_width_percent=width),
         stroke_um=stroke)
