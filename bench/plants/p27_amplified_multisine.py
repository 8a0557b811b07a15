#!/usr/bin/env python3
"""Amplified (lever) piezo actuator -20..120 V, 220 um, current-limited amplifier; multisines at two levels.

Truth: amplifier lag 0.1 ms with a slew limit (1 or 2 % of the loud records is off by more than 0.1 V through it) ->
Preisach with mean field: the field w on the domains is u - a P, and reaches them with a lag of 0.35 ms (w inside the
loop: minor loops are not congruent, the loop widens at speed); two populations of domains (300x300 cells) -> bent
reversible part beside -> creep, three lags 0.02, 0.4, 6 s -> modes 238 Hz (0.02), 655 Hz (0.015, share 0.04) -> sensor
one sample late. Hum. DAC-held, 6 kHz. Records: loud multisine 0.5..120 Hz (fills the range), a second realisation, soft
one (30 % of it); the generator was turned up from 0 V two seconds before. Tests: another multisine at 65 %; sine 25 Hz
10..85 V; triangles 7 Hz 0..100 V; random path to 50 Hz.
"""
from rig import *

R = Rig("p27_amplified_multisine", fs=6000, over=4, held=True, range=(-20, 120))
T, stroke = R.T, 220.0
modes = [(R.jit(238, .04), R.jit(.02, .25), .95), (R.jit(655, .03), .015, .04)]
lags = [(.02, .012), (.4, R.jit(.014, .2)), (6.0, .017)]
mean, tau, amp = R.jit(22.0, .2), 3.5e-4, 1e-4
slew = R.jit(6200.0, .04)
pre = Everett(-60, 125, lambda a, b: np.exp(-(a - b) / 19) * np.exp(-0.5 * (((a + b) / 2 - 40) / 60) ** 2)
              + .35 * np.exp(-0.5 * (((a - b) - 42) / 13) ** 2 - 0.5 * (((a + b) / 2 - 22) / 34) ** 2))

def domains(u, dt, limit):
    pre.reset()
    st, out = pre.step, np.empty(len(u))
    ka, kw, top = 1 - np.exp(-dt / amp), 1 - np.exp(-dt / tau), limit * dt
    v = float(u[0]); w = v - mean * .5; p = st(w)
    for _ in range(200):
        w += .1 * (v - mean * p - w); p = st(w)
    e = np.empty(len(u))
    for j, x in enumerate(u.tolist()):
        d = ka * (x - v)
        v += top if d > top else -top if d < -top else d
        w += kw * (v - mean * p - w)
        p = st(w)
        out[j] = p; e[j] = v
    return e, out

rev = lambda v: (v + 7e-4 * v * v - 7e-6 * v ** 3) / 140
def _z(u, dt, limit=slew):
    v, p = domains(u, dt, limit)
    return .48 * rev(v) + .52 * p
size, low, width = loop(lambda u: _z(u, 1e-3, 1e9), -20, 120, n=6000)

def plant(u):
    z = (_z(u, T) - low) / size * stroke
    y = modal(z + sum(k * lag(z, s, T) for s, k in lags), modes, T)
    return np.r_[np.full(4, y[0]), y[:-4]]

def multisine(rng, lo, hi, period=4.0, f0=.5, f1=120.0):
    k = np.arange(int(f0 * period), int(f1 * period) + 1); f = k / period
    a = 1 / np.sqrt(f) / np.sqrt(1 + (f / 18) ** 2)
    best = None
    for _ in range(12):                                        # the user keeps the best of twelve crest factors
        p = rng.uniform(0, 2 * np.pi, len(k)); n = int(period * 6000)
        X = np.zeros(n // 2 + 1, complex); X[k] = a * np.exp(1j * p); y = np.fft.irfft(X, n)
        c = np.abs(y).max() / y.std()
        if best is None or c < best[0]: best = (c, y)
    y = best[1]; y = (y - y.min()) / np.ptp(y)
    y = lo + (hi - lo) * y
    return lambda t: y[np.mod(np.round(t * 6000).astype(int), len(y))]

m = dict(stroke=stroke, white=2.5e-4, pink=1e-4, hum=2e-4, lsb=stroke * 1.3 / 65536, u_lsb=160 / 65536, offset=-.3)
from_rest = lambda u: lambda t: u(t) * np.clip((t + 2) / .1, 0, 1)            # generator turned up 2 s before
loud, loud2, quiet = multisine(R.rng, -20, 120), multisine(R.rng, -20, 120), multisine(R.rng, 29, 71)
for n, u, s in (("train_loud", loud, 9.0), ("train_loud_b", loud2, 8.0), ("train_soft", quiet, 7.5)):
    R.record(n, from_rest(u), s, plant, hist="run", sec=2.2, **m)
mid = multisine(R.rng, 4, 95)
R.record("test_multisine", from_rest(mid), 4.0, plant, hist="run", sec=2.2, **m)
R.record("test_sine25Hz", soft(lambda t: 47.5 - 37.5 * np.cos(2 * np.pi * 25 * t), 10, .1), 2.0, plant,
         hist="after", level=10, **m)
tri = lambda t: 50 + 50 * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * 7 * t - np.pi / 2))
R.record("test_triangle7Hz", tri, 2.5, plant, hist="after", level=0, **m)
R.record("test_random", soft(path(R.rng, .5, 50, -15, 115, 3.0, 40), 0, .2), 3.0, plant, hist="after", level=0, **m)
fr = {}
for n, u, s in (("train_loud", loud, 4.0), ("train_loud_b", loud2, 4.0), ("train_soft", quiet, 4.0),
                ("test_multisine", mid, 4.0)):
    x = np.repeat(u(np.arange(24000) / 6000), 4)
    a, b = domains(x, T, slew)[0], domains(x, T, 1e9)[0]
    fr[n] = dict(percent_of_time_off_by_0p1_V=100 * np.mean(np.abs(a - b) > .1), most_V=np.abs(a - b).max())
R.finish(modes=modes, amplifier=dict(lag_s=amp, slew_V_per_s=slew, reached=fr), delay_samples=1,
         creep=dict(kind="three lags", s_and_gain=lags),
         hysteresis=dict(kind="Preisach with mean field and lag inside, two populations", mean_field_V=mean, lag_s=tau,
                         loop_width_percent=width), stroke_um=stroke)
