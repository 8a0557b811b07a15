#!/usr/bin/env python3
"""Preloaded stack 0..150 V that carries 5.5 kg, 30 um, capacitive sensor; triangles with inner loops, nothing else.

Truth: amplifier lag 0.08 ms -> Preisach operator (300x300 cells: bell over coercive voltage, mean field shifted by the
preload, a narrow ridge at one switching-up voltage) 45 % of the stroke, beside a bent reversible part 55 % (the preload
stiffens) -> creep of the IRREVERSIBLE part alone, log-type -> mode 235 Hz (0.022), small residual -> capacitive sensor
first order 1.2 kHz. Analog generator, sharp corners between samples; voltage logged with 16 bits over -20..180 V.
Records: slopes 300, 1500, 6000 V/s. Tests: slope 3300 V/s through other vertices; sine 8 Hz 18..128 V; random path.
"""
from rig import *

R = Rig("p22_preload_stack", fs=5000, over=4, held=False, range=(0, 150))
T, stroke = R.T, 30.0
mode = (R.jit(235, .04), R.jit(.022, .25), 0.985)
g, ridge_at = R.jit(0.035, .2), R.jit(62.0, .1)
pre = Everett(-1, 151, lambda a, b: np.exp(-0.5 * (((a - b) / 2 - 9) / 17) ** 2 - 0.5 * (((a + b) / 2 - 88) / 52) ** 2)
              + 0.55 * np.exp(-0.5 * ((a - ridge_at) / 2.6) ** 2) * np.exp(-(a - b) / 30)
              + 0.05 * np.exp(-(a - b) / 60))
bent = lambda u: (u + 1.1e-3 * u ** 2 - 6.5e-6 * u ** 3) / (150 + 1.1e-3 * 150 ** 2 - 6.5e-6 * 150 ** 3)
size, low, width = loop(lambda u: 0.55 * bent(u) + 0.45 * pre(u), 0, 150)

def plant(u):
    v = lag(u, 8e-5, T)
    irr = 0.45 * pre(v)
    z = (0.55 * bent(v) + irr + log_creep(irr, g, T) - low) / size * stroke
    return lag(modal(z, [mode], T), 1 / (2 * np.pi * 1200), T)

m = dict(stroke=stroke, white=1.5e-4, pink=1.0e-4, lsb=stroke * 1.4 / 65536, u_lsb=200 / 65536, offset=-0.21)
hand = [0, 150, 60, 112, 38, 90, 0, 104, 30, 74, 10, 48, 0]
for s, sec in ((300, 9.0), (1500, 6.0), (6000, 4.0)):
    R.record(f"train_{s}Vps", poly(hand, s), sec, plant, hist="after", level=0, cyc_hz=2, **m)
R.record("test_slope", poly([0, 130, 80, 118, 22, 66, 44, 99, 5, 84, 0], 3300), 3.0, plant,
         hist="after", level=0, cyc_hz=2, **m)
R.record("test_sine8Hz", soft(lambda t: 73 - 55 * np.cos(2 * np.pi * 8 * t), 0, .2), 3.0, plant,
         hist="after", level=0, cyc_hz=2, **m)
v = [0.0]
while len(v) < 120: v.append(R.rng.uniform(3, 147))
v = np.array(v); s = np.exp(R.rng.uniform(np.log(400), np.log(5500), len(v) - 1))
R.record("test_random", poly(v, s, periodic=False), 5.0, plant, hist="after", level=0, cyc_hz=2, **m)
R.finish(modes=[mode], sensor=dict(kind="first order", Hz=1200), amplifier=dict(lag_s=8e-5), delay_samples=0,
         creep=dict(kind="log, of the irreversible part", per_decade=g, from_s=1e-3, to_s=200),
         hysteresis=dict(kind="Preisach 300x300, bell + ridge, bent reversible part", ridge_V=ridge_at,
                         loop_width_percent=width), stroke_um=stroke)
