"""Files as other programs write them are read, and refused, as bench/files/README.md says."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[3] / "bench"


def printed(name: str) -> list[str]:
    """The counts of a set today, as the table has them."""
    lines = (BENCH / "files/README.md").read_text(encoding="utf-8").splitlines()
    [row] = [line for line in lines if line.startswith(f"| {name} | today |")]
    return [cell.strip() for cell in row.strip("|").split("|")][2:]


@pytest.mark.parametrize("name", ["first", "second", "third"])
def test_files_of_other_programs_are_read_as_the_table_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))
    monkeypatch.delitem(sys.modules, "files", raising=False)
    import files  # noqa: PLC0415

    outcomes = files.outcomes(name)
    count = Counter(result for _, result, _ in outcomes)
    clear = [count[result] for result in files.OUTCOMES[:4]]
    refused, read = (count[result] for result in files.OUTCOMES[4:])
    counts = [*map(str, [*clear, sum(clear)]), f"{refused} of {refused + read}"]
    failed = {truth["file"]: result for truth, result, _ in outcomes if result not in files.EXPECTED}
    assert counts == printed(name), failed
