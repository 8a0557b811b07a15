#!/usr/bin/env python3
"""Shear stack +-250 V with a heavy carriage, 9 um, interferometer; sines at 4 amplitudes, 3 frequencies.

Truth: 360 domain walls, each in its own random pinning landscape (smooth, four waves), elastic return force, viscous
drag: drag*x' = u + bias - k x - pin_i(x). Rayleigh-like: gain and width grow with amplitude; drag widens the loop at
speed. Beside the walls a reversible slope (50 %, cubic) -> creep, log-type, of the whole -> mode 455 Hz (0.02), read at
once. Analog generator. Records: 60, 120, 180, 240 V at 2, 11, 60 Hz, the generator was turned up from 0 V some time
before (1, 0.6, 0.3 s), the record is cut out of the run. Tests: 25 Hz 150 V; 5 Hz 120 V + 37 Hz 55 V; random path to 40
Hz within +-230 V.
"""
from rig import *

R = Rig("p26_shear_sines", fs=10000, over=2, held=False, range=(-240, 240))
T, stroke = R.T, 9.0
modes = [(R.jit(455, .04), R.jit(.02, .25), .98)]
g, drag = R.jit(.014, .2), R.jit(1.6e-4, .2)
W = 360
r = np.random.default_rng(505)
depth = r.gamma(2.2, .09, W)
lam = r.uniform(.10, .30, W)
bias, stiff = r.normal(0, .12, W), r.uniform(.7, 1.4, W)
M = 1024                                                       # landscape table over one 8-wave period of each wall
ph = np.arange(M) * 2 * np.pi / M
tab = np.zeros((W, M + 1))
for h, a in ((5, .45), (8, .8), (11, .6), (13, .35)):
    tab[:, :M] += a * np.sin(h * ph[None, :] + r.uniform(0, 6.283, (W, 1)))
tab[:, M] = tab[:, 0]
tab *= depth[:, None]
flat, base = tab.ravel(), np.arange(W) * (M + 1)
per = M / (8 * lam)                                            # table steps per unit of x
steep = stiff + np.abs(np.diff(tab, axis=1)).max(1) * per
wt = r.uniform(.5, 1.5, W); wt /= wt.sum()

def walls(u, dt):
    e = u / 250.0
    x = (e[0] + bias) / stiff
    k = dt / (drag + dt * steep)
    out = np.empty(len(u))
    for _ in range(3000):
        y = x * per; y %= M; i = y.astype(np.int64); i += base
        x = x + k * (e[0] + bias - stiff * x - flat[i])
    for j, v in enumerate(e.tolist()):
        y = x * per; y %= M
        i = y.astype(np.int64); y -= i; i += base
        lo = flat[i]; i += 1
        f = flat[i]; f -= lo; f *= y; f += lo
        f += stiff * x; f -= bias
        x += k * (v - f)
        out[j] = wt @ x
    return out

rev = lambda u: u / 250 + .05 * (u / 250) ** 3 + .02 * (u / 250) ** 2
_z = lambda u, dt: .5 * rev(u) + .5 * walls(u, dt)
size, low, width = loop(lambda u: _z(u, 1e-4), -240, 240, n=5000)

def plant(u):
    z = _z(u, T) / size * stroke
    return modal(z + log_creep(z, g, T), modes, T)

m = dict(stroke=stroke, white=2.5e-4, pink=1.5e-4, lsb=.0003, u_lsb=600 / 65536, offset=.05)
sine = lambda hz, a, p=0.0: lambda t: a * np.sin(2 * np.pi * hz * t + p)
from_rest = lambda u, pre: lambda t: u(t) * np.clip((t + pre) / .1, 0, 1)   # generator turned up `pre` seconds before
for hz, sec, pre in ((2, 2.0, 1.0), (11, 1.0, .6), (60, .5, .3)):
    for a in (60, 120, 180, 240):
        R.record(f"train_{hz:02d}Hz_{a:03d}V", from_rest(sine(hz, a, R.rng.uniform(0, 6.28)), pre), sec, plant,
                 hist="run", sec=pre + .2, **m)
m.update(hist="rest", level=0, sec=.3)
R.record("test_25Hz_150V", soft(sine(25, 150), 0, .1), 1.2, plant, **m)
R.record("test_two_tone", soft(lambda t: sine(5, 120)(t) + sine(37, 55)(t), 0, .1), 1.6, plant, **m)
R.record("test_random", soft(path(R.rng, 1, 40, -230, 230, 2.0, 40), 0, .15), 2.0, plant, **m)
R.finish(modes=modes, delay_samples=0, creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=200),
         hysteresis=dict(kind="360 domain walls in random pinning landscapes with drag", drag_s=drag,
                         loop_width_percent=width),
         stroke_um=stroke)
