#!/usr/bin/env python3
"""Records taken in closed loop: the user logs what the servo sends to the amplifier. Stage 0..100 V, 100 um.

Truth: plays, stretched exponential, quadratic envelope, width 10.4 % -> creep 1.4 % a decade -> mode 300 Hz (0.025).
DAC held. Servo: integral action 30 rad/s at 5 kHz, so u contains the noise of y and the creep; the ceramic itself is of
Hammerstein form.
Recorded: 5 kHz; closed loop: triangle reference 2.5 Hz (4 s), twenty reference steps (4 s), from the virgin state at 0
V. 16 bits, noise 0.03 %.
Tests: 5 Hz triangle and random reference in closed loop; a rising sine 14 Hz in open loop; 2.5 Hz on another day.
A perfect Hammerstein model: reaches the noise, 0.1 to 0.22 %. The mode is hardly excited, least squares on y and u is
biased by the feedback, u is never fast. Other day 0.3 to 1.2 % (the servo hides the change of gain in u).
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *

B = Bench("p18_servo", fs=5000, over=1, analog=False, range=(0, 100))
stroke, T = 100.0, B.T
f1, zeta = B.jit(300, 0.04), B.jit(0.025, 0.25)
M = [(f1, zeta, 1.0)]
g, Ki = B.jit(0.014, 0.2), 30.0
r = np.linspace(0, 50, 60)
w = np.exp(-((r / 12.0) ** 1.1))
w *= 0.52 / w.sum()
w[0] = 0.48
c2 = 9e-4
value = lambda S: (S + c2 * S * S) @ w
hyst = lambda u: plays(u, r, value)
size, low, width = loop(hyst, 0, 100)
taus = np.logspace(-3, 2, 24)
gap = np.log10(taus[1] / taus[0])


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return modes(creep_lags(z, taus, np.full(24, g * creep * gap), T), M, T)


meas = dict(stroke=stroke, bits=16, span=1.4, u_range=120, u_bits=16)
lsb, dac = 1.4 * stroke / 2**16, 120 / 2**16


def servo(ref, e, gain=1.0, creep=1.0, offset=0.0):
    """integral control at 5 kHz; the same ceramic, sample by sample; returns the DAC words, y is what plant() makes
    of them"""
    w0 = 2 * np.pi * f1
    (b,), a, _ = cont2discrete(([w0 * w0], [1, 2 * zeta * w0, w0 * w0]), T)
    s = np.zeros(len(r))
    z0 = gain * stroke * (value(s[None])[0] - low) / size
    k = -np.expm1(-T / taus)
    m = np.zeros(24)
    gg = g * creep * gap
    y1 = y2 = x1 = x2 = 0.0
    ui = 0.0
    u = np.empty(len(ref))
    for i in range(len(ref)):  # m, x, y: deviations from the rest before the record
        y = b[1] * x1 + b[2] * x2 - a[1] * y1 - a[2] * y2
        ym = np.round((y + z0 * (1 + 24 * gg) + offset * stroke + e[i]) / lsb) * lsb
        ui = min(max(ui + Ki * T * (ref[i] - ym) * 100 / stroke, 0.0), 100.0)
        u[i] = np.round(ui / dac) * dac
        s = np.minimum(np.maximum(s, u[i] - r), u[i] + r)
        d = gain * stroke * (value(s[None])[0] - low) / size - z0
        m += k * (d - m)
        y2, y1, x2, x1 = y1, y, x1, d + gg * m.sum()
    return u


def closed(name, ref, day=None):
    e = 3e-4 * stroke * B.rng.standard_normal(len(ref))
    u = servo(ref, e, **(day or {}))
    B.record(
        name,
        u,
        len(ref) / B.fs,
        plant,
        {},
        day=day,
        noise_given=e,
        hist=dict(kind="rest", level=0.0, sec=0.2),
        note="closed loop",
        **meas,
    )


t = np.arange(4 * B.fs) / B.fs
day2 = B.day2(offset=0.02)
closed("train_servo_tri", 45 + 36 * tri(t + 0.5 / 2.5, 2.5) * ramp01(t, 0.3, 0.6))
closed("train_servo_steps", np.repeat(B.rng.uniform(10, 85, 20), B.fs // 5))
closed("test_rate", (45 + 36 * tri(t + 0.2, 5.0) * ramp01(t, 0.3, 0.6))[: 2 * B.fs])
closed("test_random", zigzag(B.rng, 4, B.fs, 8, 88, leg=(0.04, 0.4), start=20, hold=0.06))
B.record(
    "test_open_loop",
    lambda t: 48 * ramp01(t, 0, 1.2) * (1 - np.cos(2 * np.pi * 14 * t)),
    1.6,
    plant,
    {},
    noise=3e-4,
    hist=dict(kind="rest", sec=0.5),
    note="open loop",
    **meas,
)
closed("test_day", 45 + 36 * tri(t + 0.5 / 2.5, 2.5) * ramp01(t, 0.3, 0.6), day=day2)
B.finish(
    modes=M,
    delay_samples=0,
    servo=dict(kind="integral", rad_per_s=Ki),
    creep=dict(kind="log", per_decade=g, from_s=1e-3, to_s=100),
    hysteresis=dict(kind="plays, stretched exponential, quadratic envelope", loop_width_percent=width),
    stroke_um=stroke,
)
