"""The comparison with other libraries runs, and its page has the expected content."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[3] / "bench"


def test_every_problem_of_the_comparison_is_solved_by_both_sides_to_the_error_they_should_have() -> None:
    missing = [name for name in ("scipy", "pyswarms", "sysidentpy") if find_spec(name) is None]
    if missing:
        why = f"the comparison with other libraries did not run: {', '.join(missing)} is not installed"
        warnings.warn(f"SKIPPED: {why}", stacklevel=1)
        pytest.skip(why)
    page = BENCH / "side_by_side.md"
    before = page.read_bytes() if page.exists() else None
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    environment.pop("PIEZOID_DATA", None)
    command = [sys.executable, str(BENCH / "side_by_side.py"), "--quick", "--here"]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert "SKIPPED: The measured stack" in run.stderr

    table = run.stdout.split("## Results")[1].split("##")[0]
    lines = [line for line in table.splitlines() if line.startswith("| ")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines][2:]
    assert all(len(row) == 10 for row in rows)
    # Both sides of these rows compute the same, except for rounding.
    exact = [row for row in rows if row[1] in ("`lfilter`", "numpy, plays at once", "Python, the exact exponentials")]
    assert len(exact) == 10 and all(row[5] == "same" for row in exact), exact
    squares = [row for row in rows if "least squares" in row[0]]
    assert len(squares) == 3 and all(row[5] == "same" for row in squares), squares
    # Models of both sides predict the twin.
    twin = [row for row in rows if row[0].startswith("twin") and row[2] == "worst nrmse [%]"]
    assert len(twin) == 5 and all(float(row[3]) < 6 and float(row[4]) < 20 for row in twin), twin
    # The section names exactly the rows that are behind in error or not ahead in time.
    behind = run.stdout.split("## Where piezoid is not ahead")[1].split("##")[0]
    assert behind.count("\n- ") == sum((row[5] == "behind") + (row[9] != "ahead") for row in rows)

    assert (page.read_bytes() if page.exists() else None) == before, "a quick look writes nothing"
