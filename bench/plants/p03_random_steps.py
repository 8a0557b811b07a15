#!/usr/bin/env python3
"""Loaded stack stage, 38 um at 0..100 V, interferometer; random steps are all there is.

Truth: Maxwell slip with Weibull thresholds and a cubic curve behind, width 11.7 % -> creep 1.6 % a decade (3 ms to 30
s) -> mode 240 Hz (0.05, share 0.96), residual 0.04 -> sensor lag 0.12 ms; y is read 0.4 sample after the DAC. Drift
1e-5..4e-5 of stroke a second.
Recorded: 2 kHz, one record of 20 s: levels uniform in 5..95 V, holds log-uniform in 12..250 ms, after earlier full
cycles. 14 bits over three strokes, noise 0.04 %.
Tests: holds of 6..30 ms; a rising sine 9 Hz; smooth random loops; random steps on another day.
A perfect Hammerstein model: reaches the noise, 0.13 to 0.15 %. Between two holds the path is a jump: only the sequence
of levels drives the hysteresis, and the overshoot reaches half a stroke.
Seed 1 is the nominal plant; other seeds move frequencies by up to 4 %, damping and creep by up to 25 % (see
truth.json).
"""

from common import *
from random_steps import record_all

B = Bench("p03_random_steps", fs=2000, over=10, analog=False, range=(0, 100))
stroke, T = 38.0, B.T
M = [(B.jit(240, 0.04), B.jit(0.05, 0.25), 0.96)]
tau_s, g, skew = B.jit(1.2e-4, 0.15), B.jit(0.016, 0.2), 4
r = 48 * np.linspace(0, 1, 70) ** 1.4
q = 1 - np.exp(-((r / 16.0) ** 1.6))
w = np.r_[0.60, 0.40 * np.diff(q) / q[-1]]
bend = lambda x: x + 9e-4 * x * x - 3e-6 * x**3
hyst = lambda u: bend(plays(u, r, lambda S: S @ w))
size, low, width = loop(hyst, 0, 100)


def plant(u, gain=1.0, creep=1.0):
    z = gain * stroke * (hyst(u) - low) / size
    return lag(modes(creep_log(z, g * creep, T, 3e-3, 3e1), M, T, residual=0.04), tau_s, T)


drift = lambda t, rng: rng.uniform(1, 4) * 1e-5 * rng.choice([-1, 1]) * t
meas = dict(stroke=stroke, drift=drift, noise=4e-4, bits=14, span=3.0, u_range=100, u_bits=14, skew=skew, offset=0.05)
record_all(B, plant, **meas)
B.finish(
    modes=M,
    residual=0.04,
    sensor_lag_s=[tau_s],
    delay_samples=-skew / B.over,
    creep=dict(kind="log", per_decade=g, from_s=3e-3, to_s=30),
    hysteresis=dict(kind="Maxwell slip, Weibull thresholds, cubic curve behind", loop_width_percent=width),
    stroke_um=stroke,
)
