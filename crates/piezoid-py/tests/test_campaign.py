"""A campaign on functions that play voltages."""

import numpy as np
import piezoid as pz
import pytest

TWIN = {
    "piezoid": 1, "ts": 0.01, "units": {"u": "V", "y": "um"},
    "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [2.0]},
}


def rig(unit=1.0):
    twin, noise = pz.Model.from_dict(TWIN), np.random.default_rng(0)
    return lambda u: unit * (twin.simulate(u) + noise.normal(0, 1e-3, u.size))


def run(measure, **more):
    return pz.campaign(measure, ts=0.01, range=(-10, 10), bandwidth=2, wait=0, operator="proportional", **more)


def test_a_campaign_follows_the_path_that_is_given_and_measures_nothing_twice(tmp_path):
    # In nm, from rest and back.
    path = 5e3 * np.sin(np.linspace(0, 4 * np.pi, 401)) ** 3
    found = run(rig(1e3), unit="nm", reference=path, folder=tmp_path)
    assert abs(found.model.dc_gain - 2e3) < 2 and found.results["compensated"]["unit"] == "nm"
    middle = slice((len(found.compensated["r"]) - 401) // 2, (len(found.compensated["r"]) + 401) // 2)
    assert np.allclose(found.compensated["r"][middle], path)
    assert np.abs(found.compensated["y"] - found.compensated["r"]).max() < 10
    assert (tmp_path / "campaign.html").read_text() == found.page
    lengths = []

    def counted(u):
        lengths.append(len(u))
        return rig(1e3)(u)

    again = run(counted, unit="nm", reference=path, folder=tmp_path)
    assert again.results["resumed"] == ["small", "rise1", "rise2", "rise3", "creep", "path"]
    assert len(lengths) < 9, "two paths, each after a demagnetisation and a rest, and the end"


def test_what_the_function_raises_is_raised_and_nonsense_is_refused():
    class Broken(Exception):
        pass

    def broken(u):
        raise Broken("no card")

    with pytest.raises(Broken, match="no card"):
        run(broken)
    with pytest.raises(pz.PiezoidError, match="returns 3731 displacements for 3732 voltages: return one for each"):
        run(lambda u: u[:-1])


def test_a_path_is_timed_on_a_function_whose_offset_does_not_count():
    model = pz.Model.from_dict(TWIN | {"identified": {"u": [-10, 10], "hz": [0, 50], "slew": 1e6, "mean": [0, 0]}})
    measure = rig()
    path = np.repeat([0.0, 5.0, -5.0], 60)
    found = pz.timing(model, path, on=lambda u: 300.0 + measure(u), wait=0, tolerance=0.05, slew=1e4)
    names = ["model, compensated", "model, straight line", "controller, compensated", "controller, straight line"]
    assert list(found.displacements) == names and found.figures["controller"]["unfinished"] is None
    assert np.allclose(found.displacements[names[2]], path, atol=0.02)
    with pytest.raises(ZeroDivisionError):
        pz.timing(model, path, on=lambda u: 1 / 0, wait=0, slew=1e4)
