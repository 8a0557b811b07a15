"""The Python of the book: the blocks of each chapter, one after the other, with the files of the first hour."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import piezoid as pz
import pytest

DOCS = Path(__file__).parents[3] / "docs"
# A block that is not run says why, and `cargo xtask book` knows the reasons.
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
CHAPTERS = {page.stem: found for page in sorted(DOCS.glob("*.md")) if (found := BLOCK.findall(page.read_text()))}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The records and the path of the first hour, and a model of them."""
    folder = tmp_path_factory.mktemp("book")
    plant, ts = pz.plants["pl140"], 5e-4
    drives = {f"rise{hz}": pz.excite.rising_sine(ts=ts, duration=2, amplitude=28, frequency=hz) for hz in (5, 20, 80)}
    drives["prbs"] = pz.excite.prbs(ts=ts, duration=2, amplitude=1)
    drives["stairs"] = pz.excite.staircase(ts=ts, duration=2, amplitude=25, frequency=10)
    for name, u in drives.items():
        plant.measure(u, ts).save(folder / f"{name}.csv")
    r = pz.excite.triangle(ts=ts, duration=1, amplitude=400, frequency=10)
    rows = [f"{k * ts},{v}" for k, v in enumerate(r)]
    (folder / "path.csv").write_text("\n".join(["t_s,r_um", *rows]) + "\n")
    small, *large = (pz.read(folder / f"{name}.csv") for name in ("prbs", "rise5", "rise20", "rise80"))
    model = pz.identify(small_signal=small, large_signal=large, operator="prandtl-ishlinskii")
    model.save(folder / "model.json")
    return folder


def test_the_chapters_with_python_are_known() -> None:
    assert set(CHAPTERS) == {"first-hour", "online", "python", "stand-in"}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_python_of_a_chapter_runs(
    chapter: str, files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = shutil.copytree(files, tmp_path / chapter)
    monkeypatch.chdir(folder)
    run: dict[str, object] = {}
    for block in CHAPTERS[chapter]:
        exec(block, run)
    if chapter == "first-hour":
        unseen, tracked = (float(line) for line in capsys.readouterr().out.split())
        r = pz.excite.triangle(ts=5e-4, duration=1, amplitude=400, frequency=10)
        y = pz.plants["pl140"].simulate(r / 22.4, 5e-4)
        line = np.polynomial.Polynomial.fit(y, r, 1)
        assert unseen < 0.03 and 100 * np.std(line(y) - r) / np.ptp(r) > 15 * tracked
