"""A stand-in for the actuator of a model."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import piezoid as pz

TS = 1e-3


@pytest.fixture(scope="module")
def rise() -> pz.Record:
    u = pz.excite.rising_sine(ts=TS, duration=2, amplitude=28, frequency=4)
    return pz.plants["pl140"].measure(u, ts=TS)


@pytest.fixture(scope="module")
def model(rise: pz.Record) -> pz.Model:
    return pz.identify(rise, operator="prandtl-ishlinskii", order=2)


@pytest.fixture(scope="module")
def actuator(model: pz.Model, rise: pz.Record) -> pz.Plant:
    return pz.stand_in(model, rise)


def test_it_has_the_units_and_the_period_of_the_records(actuator: pz.Plant, rise: pz.Record) -> None:
    record = actuator.measure(rise.u)
    assert (record.ts, record.units) == (TS, rise.units)
    assert np.std(record.y - rise.y) < 0.05 * np.ptp(rise.y)
    assert "from a model with" in str(actuator) and repr(actuator) == "<Plant stand-in>"
    with pytest.raises(pz.PiezoidError, match="the stand-in"):
        actuator.simulate(rise.u, ts=2 * TS)


def test_it_is_kept_and_drawn(actuator: pz.Plant, rise: pz.Record) -> None:
    assert pickle.loads(pickle.dumps(actuator)) == actuator == pz.Plant(actuator.to_dict())
    drawn = actuator.drawn(0.0, seed=1)
    assert not np.array_equal(drawn.simulate(rise.u), actuator.simulate(rise.u))


def test_it_takes_the_place_of_a_twin(actuator: pz.Plant, model: pz.Model) -> None:
    r = pz.reference("triangle", model, peak=600, frequency=5, duration=1)
    table = pz.control(actuator, model, r, controller=["gain", "feed-forward"]).table
    assert table["feed-forward"].iloc[0] < table["gain"].iloc[0]
    assert "stand-in, compensated" in pz.timing(model, r, plant=actuator).displacements


def test_a_campaign_is_rehearsed_on_it(actuator: pz.Plant, tmp_path: Path) -> None:
    found = pz.campaign(actuator, bandwidth=20, wait=2, operator="preisach", folder=tmp_path)
    assert found.better > 20 and found.results["identity"].startswith("stand-in, simulated. The stand-in is ")
    assert found.model.ts == TS and (tmp_path / "campaign.html").exists()
    with pytest.raises(pz.PiezoidError, match="range is missing: a function needs it"):
        pz.campaign(lambda u: 2 * u, ts=TS, bandwidth=20)
    with pytest.raises(pz.PiezoidError, match="ts is missing: the path needs it"):
        pz.campaign("pl140", bandwidth=20, reference=[0.0, 1.0])
    with pytest.raises(pz.PiezoidError, match="unit = nm: the displacement of pl140 is in um"):
        pz.campaign("pl140", bandwidth=20, unit="nm")


def test_a_plan_is_rehearsed_on_it(actuator: pz.Plant, rise: pz.Record) -> None:
    plan = pz.plan(plant=actuator, bandwidth=20)
    assert plan.rehearsal is not None and plan.rehearsal["plant"] == "stand-in"
    low, high = np.min(rise.u), np.max(rise.u)
    assert np.isclose(plan["rise1"].max(), 0.5 * (low + high) + 0.475 * (high - low), rtol=0.01)
    assert 0.8 < plan.rehearsal["stroke"] / np.ptp(rise.y) < 1.2
    assert "## Rehearsal" in plan.page and pz.plan(range=(-5, 5), bandwidth=20).rehearsal is None
    with pytest.raises(pz.PiezoidError, match="must be a multiple of 0.001 s, the sampling period of the stand-in"):
        pz.plan(plant=actuator, bandwidth=20, ts=1.5e-3)
