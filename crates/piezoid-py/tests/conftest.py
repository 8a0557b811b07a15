"""A twin, records of it, and a model, created once."""

from __future__ import annotations

import piezoid as pz
import pytest

TS = 5e-4


@pytest.fixture(scope="session")
def small() -> pz.Record:
    return pz.plants["pl140"].measure(pz.excite.prbs(ts=TS, duration=2, amplitude=1), TS)


@pytest.fixture(scope="session")
def rich() -> pz.Record:
    return pz.plants["pl140"].measure(pz.excite.rising_sine(ts=TS, duration=2, amplitude=28, frequency=5), TS)


@pytest.fixture(scope="session")
def unseen() -> pz.Record:
    return pz.plants["pl140"].measure(pz.excite.triangle(ts=TS, duration=1, amplitude=20, frequency=8), TS, seed=5)


@pytest.fixture(scope="session")
def model(small: pz.Record, rich: pz.Record) -> pz.Model:
    return pz.identify(small_signal=small, large_signal=rich, operator="prandtl-ishlinskii")
