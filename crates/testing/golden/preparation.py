"""Writes preparation.json: filters, trends and resampled signals by scipy, for src/preparation/tests.rs.

The filters are those of `firwin` with the Kaiser window of `kaiser_beta(90)`: the anti-alias filter for factors of 2, 5
and 10 with its cut-off at 0.9 of the new Nyquist frequency, and the one between samples, at quarters of a sample, with
its cut-off at the Nyquist frequency. u and y are three periods of multisines; `decimated` is `upfirdn` with the filter for a factor of 4 on y,
continued at its ends by turning it about them; `resampled` is the mean period through `scipy.signal.resample`, which is
exact for one period.
"""

import json
from math import ceil, pi
from pathlib import Path

import numpy as np
from scipy.signal import detrend, firwin, kaiser_beta, resample, upfirdn

random = np.random.default_rng(20261123)


def reach(width):
    return ceil((90 - 7.95) / (2 * 2.285 * pi * width))


def anti_alias(factor):
    return firwin(2 * reach(0.2) * factor + 1, 0.9 / factor, window=("kaiser", kaiser_beta(90)))


# At quarters of a sample: firwin takes no cut-off at the Nyquist frequency itself.
between = firwin(2 * reach(0.4) * 4 + 1, 1 / 4, window=("kaiser", kaiser_beta(90)))

p, count = 240, 3
t = np.arange(p * count)
lines = range(1, 60)
wave = lambda phases: sum(np.cos(2 * pi * k * t / p + phase) / k for k, phase in zip(lines, phases))
u, y = (wave(2 * pi * random.random(len(lines))) for _ in range(2))

taps = anti_alias(4)
end = len(taps) // 2
turned = np.pad(y, end, mode="reflect", reflect_type="odd")
decimated = upfirdn(taps, turned, 1, 4)[(2 * end) // 4 :][: p * count // 4]

document = {
    "taps": [{"factor": factor, "taps": anti_alias(factor).tolist()} for factor in (2, 5, 10)],
    "between": between.tolist(),
    "u": u.tolist(),
    "y": y.tolist(),
    "line": detrend(y, type="linear").tolist(),
    "mean": detrend(y, type="constant").tolist(),
    "decimated": decimated.tolist(),
    "resampled": resample(y[:p], p * 10 // 16).tolist(),
}
Path(__file__).with_suffix(".json").write_text(json.dumps(document) + "\n")
