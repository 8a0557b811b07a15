#!/usr/bin/env python3
"""Flexure stage 0..100 V, 90 um, strain gauge; two random staircases and one small chirp.

Truth: amplifier lag 0.12 ms -> Maxwell slip in the CHARGE (Goldfarb and Celanovic): v = c(q) + sum of 56 elastic-slip
elements, each with another break voltage up and down, solved for q at each voltage; c bent (saturating) -> creep,
log-type -> modes 312 Hz (0.014), 1180 Hz (0.03, share -0.03) -> strain-gauge amplifier, second-order 1.1 kHz (0.75),
read 0.6 samples after the DAC word. DAC-held u, 10 kHz.
Tests: staircase of other step sizes and shorter holds; sine 20 Hz 8..83 V; random path to 60 Hz.
"""
from rig import *

R = Rig("p23_flexure_stairs", fs=10000, over=5, held=True, range=(0, 100))
T, stroke = R.T, 90.0
modes = [(R.jit(312, .04), R.jit(.014, .25), 1.02), (R.jit(1180, .03), .03, -0.03)]
g = R.jit(.011, .2)
N = 56
i = (np.arange(N) + .5) / N
reach = 60 * i ** 1.7 + .15                                  # travel of q [V-equivalent] at which the element slips
k = np.exp(-reach / 22) ; k *= 0.62 / k.sum()
wob = np.sin(7.3 * np.arange(N) + .4)
cap_u, cap_d = k * reach * (1 + .16 * wob), k * reach * (1 - .16 * wob) * .86

def slip(v):
    """charge q of the voltages v; starts relaxed at v[0] after a rise from 0"""
    F, q, c = np.zeros(N), 0.0, lambda q: .62 * q + 1.5e-3 * q * q - 4.5e-6 * q ** 3
    out, val = np.empty(len(v)), 0.0
    last = 0.0
    for j, x in enumerate(v.tolist()):
        d = x - last
        if abs(d) > 1e-6:
            if d > 0: room = cap_u - F
            else: room = cap_d + F
            s = 1.0 if d > 0 else -1.0
            need, dq, cq = abs(x - val), 0.0, c(q)
            if (x - val) * s > 0:
                for _ in range(40):
                    m = np.minimum(k * dq, room)
                    free = k @ (k * dq < room)
                    qq = q + s * dq
                    r = need - m.sum() - s * (c(qq) - cq)
                    if r < 1e-7: break
                    dq += r / (free + .62 + 3e-3 * qq - 13.5e-6 * qq * qq)
                F = F + s * m; q = q + s * dq
                val = c(q) + F.sum()
            last = x
        out[j] = q
    return out
size, low, width = loop(slip, 0, 100)

def plant(u):
    z = (slip(lag(u, 1.2e-4, T)) - low) / size * stroke
    z = z + log_creep(z, g, T)
    return second(modal(z, modes, T), 1100, .75, T)

m = dict(stroke=stroke, white=4e-4, pink=2e-4, lsb=stroke * 1.5 / 65536, u_lsb=120 / 65536, offset=.33, read=3)
st = lambda sec, **k: stairs(R.rng, sec, R.fs, **k)
R.record("train_stairs_a", st(5.5, lo=0, hi=100, hold=(.008, .08), big=22, start=0), 5.5, plant, level=0, **m)
R.record("train_stairs_b", st(5.5, lo=2, hi=98, hold=(.03, .25), big=35, start=0), 5.5, plant, level=0, **m)
def chirp(t):
    a, b, s = 5.0, 600.0, 3.0
    ph = 2 * np.pi * a * s / np.log(b / a) * (np.exp(np.clip(t, 0, s) / s * np.log(b / a)) - 1)
    return 50 + .8 * np.sin(ph)
R.record("small_chirp", chirp, 3.0, plant, level=50, wait=2.0, **m)
R.record("test_stairs", st(3.0, lo=4, hi=93, hold=(.004, .05), big=12, start=4), 3.0, plant, level=4, **m)
R.record("test_sine20Hz", soft(lambda t: 45.5 - 37.5 * np.cos(2 * np.pi * 20 * t), 8, .1), 2.0, plant, level=8, **m)
R.record("test_random", soft(path(R.rng, .5, 60, 3, 97, 3.0), 0, .2), 3.0, plant, level=0, **m)
R.finish(modes=modes, sensor=dict(kind="second order", Hz=1100, damping=.75), amplifier=dict(lag_s=1.2e-4),
         delay_samples=.6, creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=200),
         hysteresis=dict(kind="Maxwell slip in the charge, 56 elements, uneven up and down", loop_width_percent=width),
         stroke_um=stroke)
