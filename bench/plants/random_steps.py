"""The records of the plants that are driven by random steps: training, faster steps, a sine, a path, another day."""

from common import *


def record_all(B, plant, **meas):
    after = dict(kind="after", lo=0, hi=100, hz=4, cycles=2, level=0, wait=1.5)
    day1, day2 = {}, B.day2()
    st = lambda s, hold: np.r_[np.zeros(100), steps(B.rng, s, B.fs, 5, 95, hold)]
    B.record("train_steps", st(20, (0.012, 0.25)), 20, plant, day1, hist=after, **meas)
    B.record(
        "test_rate",
        st(5, (0.006, 0.03)),
        5,
        plant,
        day1,
        hist=after,
        note="holds of 6 to 30 ms, training had 12 to 250 ms",
        **meas,
    )
    B.record(
        "test_sine",
        lambda t: 48 * (1 - np.cos(2 * np.pi * 9 * t)) * ramp01(t, -0.01, 1.2),
        2,
        plant,
        day1,
        hist=after,
        **meas,
    )
    B.record(
        "test_random", zigzag(B.rng, 4, B.fs, 4, 96, leg=(0.01, 0.3), hold=0.1), 4, plant, day1, hist=after, **meas
    )
    B.record("test_day", st(6, (0.012, 0.25)), 6, plant, day1, day=day2, hist=after, **meas)
