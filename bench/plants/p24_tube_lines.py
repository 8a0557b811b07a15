#!/usr/bin/env python3
"""Tube scanner +-125 V, 11 um, 16 kHz, optical sensor; scan lines (triangles) that walk slowly, three line rates.

Truth: homogenised energy (Smith): 2600 two-well domains, spread over coercive voltage (gamma) and inner bias (normal),
thermally activated: rates w0 exp((+-(u+bias)-Ec)/theta), so the loop widens with the logarithm of the rate, and creep
is the switching that goes on, logarithmic, dependent on where the state is: there is no linear creep block. Beside it
the slope of the wells, slightly bent. -> mode 770 Hz (0.018), second 1460 Hz (0.03, share 0.04) -> sensor lag 60 us.
DAC-held. Thermal drift of y. Records: 5 Hz +-110 V, 12 Hz +-70 V, 28 Hz +-105 V, each with a walk of up to +-15 V.
Tests: 19 Hz +-88 V; a zoom 8 Hz +-45 V about +30 V; a random path to 28 Hz.
"""
from rig import *

R = Rig("p24_tube_lines", fs=16000, over=4, held=True, range=(-125, 125))
T, Ts, stroke = R.T, R.Ts, 11.0
modes = [(R.jit(770, .04), R.jit(.018, .25), .95), (R.jit(1460, .03), .03, .04)]
theta, w0, N = R.jit(.9, .15), 2e4, 2600
q = np.random.default_rng(77).permuted(np.tile((np.arange(N) + .5) / N, (2, 1)), axis=1)
from scipy.stats import gamma as _g, norm as _n
Ec, Ei = _g.ppf(q[0], 1.7, scale=24) + 14, _n.ppf(q[1]) * 62 + 9
up0, dn0 = w0 * np.exp((Ei - Ec) / theta), w0 * np.exp((-Ei - Ec) / theta)

def wells(u, dt):
    """part of the domains that is up (0..1), one value a sample; starts after a long rest at u[0] from below"""
    x = ((Ei + u[0]) > Ec).astype(float)
    out, mean = np.empty(len(u)), 1.0 / N
    for j, v in enumerate(u.tolist()):
        e = np.exp(v / theta)
        p = np.minimum(up0 * e, w0); r = np.minimum(dn0 / e, w0)
        p *= dt; r *= dt; r += p; r += 1.0
        x += p; x /= r
        out[j] = x.sum() * mean
    return out

share = .24
rev = lambda u: (u + 2.2e-4 * u * u - 2.5e-6 * u ** 3) / 250
_z = lambda u: (1 - share) * rev(u) + share * wells(u, 1 / 4000)
size, low, width = loop(_z, -125, 125)

def plant(u):
    v = u[::R.over]
    z = np.repeat((1 - share) * rev(v) + share * wells(v, Ts), R.over)
    z = ((z - low) / size - .5) * stroke
    return lag(modal(z, modes, T), 6e-5, T)

m = dict(stroke=stroke, white=6e-4, pink=3e-4, lsb=.0004, u_lsb=300 / 65536, offset=.12, cyc_hz=8, wait=.3,
         drift=lambda t, r: r.uniform(-2e-3, 2e-3) * t + 4e-4 * np.sin(2 * np.pi * .17 * t + r.uniform(0, 6)))
def tri(hz, amp, a, b, sec):
    walk = lambda t: a + (b - a) * np.clip(t / sec, 0, 1)
    return lambda t: amp * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * hz * t)) + walk(t)

R.record("train_05Hz", tri(5, 110, -15, 15, 3.1), 3.1, plant, hist="after", level=-15, **m)
R.record("train_12Hz", tri(12, 70, 12, -14, 3.1), 3.1, plant, hist="after", level=12, **m)
R.record("train_28Hz", tri(28, 105, -10, 15, 3.0), 3.0, plant, hist="after", level=-10, **m)
R.record("test_19Hz", tri(19, 88, 14, -12, 2.0), 2.0, plant, hist="after", level=14, **m)
R.record("test_zoom", tri(8, 45, 24, 36, 2.0), 2.0, plant, hist="after", level=24, **m)
R.record("test_random", soft(path(R.rng, 1, 28, -110, 112, 2.5, 30), 0, .1), 2.5, plant, hist="after", level=0, **m)
R.finish(modes=modes, sensor=dict(kind="first order", lag_s=6e-5), delay_samples=0,
         creep=dict(kind="thermally activated switching, no linear block", theta_V=theta, attempt_rate_per_s=w0),
         hysteresis=dict(kind="homogenised energy, 2600 wells, thermal", loop_width_percent=width), stroke_um=stroke)
