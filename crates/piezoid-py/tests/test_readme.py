"""The Python lines of the README of the package, run unchanged."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import piezoid as pz
import pytest


def test_the_five_lines_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    readme = (Path(__file__).parent.parent / "README.md").read_text()
    found = re.search(r"```python\n(.*?)```", readme, re.DOTALL)
    assert found and found[1].count("\n") <= 5
    plant, ts = pz.plants["pl140"], 5e-4
    drives = {
        "small": pz.excite.prbs(ts=ts, duration=2, amplitude=1),
        "rise5": pz.excite.rising_sine(ts=ts, duration=2, amplitude=28, frequency=5),
        "rise20": pz.excite.rising_sine(ts=ts, duration=1, amplitude=28, frequency=20),
        "unseen": pz.excite.staircase(ts=ts, duration=1, amplitude=20, frequency=2, levels=8),
    }
    for name, u in drives.items():
        plant.measure(u, ts).save(tmp_path / f"{name}.csv")
    r = 500 * np.sin(2 * np.pi * 5 * ts * np.arange(2000))
    rows = [f"{k * ts},{v}" for k, v in enumerate(r)]
    (tmp_path / "path.csv").write_text("\n".join(["t_s,r_um", *rows]) + "\n")
    monkeypatch.chdir(tmp_path)
    run: dict[str, object] = {}
    exec(found[1], run)
    y = plant.simulate(np.asarray(run["u"]), ts)
    assert np.std((y - r)[400:]) < 0.01 * np.ptp(r)
