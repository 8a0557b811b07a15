"""Simulated plants that share nothing with the library are predicted as bench/plants/README.md says."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BENCH = ROOT / "bench"
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug/piezoid"

# Those that are identified in seconds.
FAST = ["p05a", "p12", "p21"]


def printed(plant: str) -> tuple[str, float]:
    """The operator of a plant, and its error over the floor."""
    lines = (BENCH / "plants/README.md").read_text(encoding="utf-8").splitlines()
    [row] = [line for line in lines if line.startswith(f"| {plant} |")]
    _, _, operator, ratio, *_ = (cell.strip() for cell in row.split("|"))
    return operator, float(ratio)


@pytest.mark.skipif(not BINARY.exists(), reason="SKIPPED: there is no command line to measure with: cargo build makes it")
@pytest.mark.parametrize("plant", FAST)
def test_a_plant_is_predicted_as_the_table_says(plant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))
    monkeypatch.delitem(sys.modules, "plants", raising=False)
    import plants  # noqa: PLC0415

    operator, expected = printed(plant)
    [name] = [path.stem for path in (BENCH / "plants").glob(f"{plant}_*.py")]
    row = plants.measured(str(BINARY), plants.recorded(name, 1, tmp_path), ["--operator", operator])
    assert plants.ratio(row) <= 1.3 * expected, row
