"""The notebooks: they run, give the stated results, and are stored with their outputs."""

from __future__ import annotations

import base64
import json
import re
import sys
from pathlib import Path
from typing import Any

import nbformat
import pandas as pd
import piezoid as pz
import pytest

FOLDER = Path(__file__).parent.parent / "notebooks"
sys.path.insert(0, str(FOLDER))
import run  # noqa: E402


def outputs(notebook: Any) -> list[list[tuple[str, ...]]]:
    """The kinds of output of each cell. A stream may come in pieces, which count once."""
    cells = [
        [(o.output_type, o.get("name", ""), *sorted(o.get("data", {}))) for o in cell.outputs]
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]
    return [
        [kind for k, kind in enumerate(kinds) if kind[0] != "stream" or kinds[k - 1 : k] != [kind]] for kinds in cells
    ]


def kept(name: str) -> Any:
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def came_to(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, **requested: str) -> dict[str, Any]:
    """Values of expressions after a notebook has run. Its outputs must be those of the stored notebook."""
    monkeypatch.setenv("IPYTHONDIR", str(folder / ".ipython"))
    expected = ", ".join(f"{key!r}: {expression}" for key, expression in (requested | {"by": "sys.executable"}).items())
    done = run.executed(name, folder, after=f"import json, sys\nprint(json.dumps({{{expected}}}))")
    values: dict[str, Any] = json.loads(done.cells.pop().outputs[0].text)
    assert values.pop("by") == sys.executable
    assert outputs(done) == outputs(kept(name)), f"what {name} shows has changed: python notebooks/run.py {name}"
    return values


def test_the_paper_is_met_at_its_frequencies_and_repaired(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = came_to(
        "paper", tmp_path, monkeypatch,
        swarm="history[-1] / best - 1", a="list(fits['least-squares'].arx.a)", by_hand="proof[5].mse",
        printed="list(table1.loc[[5, 20, 40, 80], 'printed-rule'])", held="list(table1.loc[[5, 20, 40, 80], 'held-direction'])",
        table_1="list(table1.loc[[5, 20, 40, 80], 'paper'])", table_2="list(table1.loc[[5, 20, 40, 80], 'table2-arx'])",
        half="errors(two)['20 Hz, 15 V']", joint="errors(joint)",
        apart="[max(v.rms_pp_percent for v in runs['joint']), min(v.rms_pp_percent for v in runs['two branches of 20 Hz'])]",
    )  # fmt: skip
    assert 0 <= found["swarm"] < 1e-5 and found["a"] == pytest.approx([1.7424, -0.9453], abs=1e-4)
    # The steps by hand give the error of the study.
    assert found["by_hand"] == pytest.approx(found["printed"][0], rel=0.02)
    assert found["printed"] == pytest.approx(found["table_1"], rel=0.2) and max(found["held"]) < 5e-5
    assert all(by_block > 5 * paper for by_block, paper in zip(found["table_2"], found["table_1"]))
    assert found["half"] > 10 and max(found["joint"].values()) < 1e-3
    assert found["apart"][0] < 0.3 and found["apart"][1] > 10 * found["apart"][0]


def test_csv_files_become_a_waveform_that_straightens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = came_to(
        "compensate", tmp_path, monkeypatch,
        proof="proof.rms_pp_percent", operator="model.operator", line="found.table['gain'].iloc[0]",
        straight="found.table['feed-forward'].iloc[0]", rest="100 * rest.std() / np.ptp(scan)",
    )  # fmt: skip
    assert found["proof"] < 0.1 and found["line"] > 1 > 20 * found["straight"]
    assert found["rest"] == pytest.approx(found["straight"], rel=0.2)
    assert pz.load(tmp_path / "model.json").operator == found["operator"]
    assert len(pz.read(tmp_path / "scan.csv")) == 800
    assert len(pd.read_csv(tmp_path / "wave/scan.csv").u_V) == 100
    assert (tmp_path / "wave/scan_gcs.txt").read_text().startswith("SVO 1 0")
    assert "bender_ff_step" in (tmp_path / "bender/bender.h").read_text()


def test_a_fleet_is_identified_but_for_the_one_without_a_sensor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = came_to(
        "fleet", tmp_path, monkeypatch,
        models="int(table.model.notna().sum())", again="list(again)", hz="[table.resonance_hz.min(), table.resonance_hz.max()]",
        median="errors.median().to_dict()", largest="errors.max().to_dict()",
    )  # fmt: skip
    assert found["models"] == 24 and found["again"] == ["bender 07"]
    assert 130 < found["hz"][0] < 160 and 175 < found["hz"][1] < 210
    assert found["median"]["common model"] > 10 * found["median"]["own model"] and found["largest"]["own model"] < 0.5
    text = next(cell.outputs[0].text for cell in kept("fleet").cells if cell.id == "errors")
    assert text.startswith("bender 07:") and "is the sensor connected" in text


def test_notebooks_are_kept_with_what_they_show_and_nothing_of_the_machine() -> None:
    files = sorted(FOLDER.glob("*.ipynb"))
    assert [file.stem for file in files] == sorted(run.NAMES) and sum(file.stat().st_size for file in files) < 1_500_000
    for name in run.NAMES:
        notebook = kept(name)
        cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
        assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1)), name
        assert not any(cell.metadata for cell in notebook.cells) and set(notebook.metadata) == {"kernelspec", "language_info"}
        assert notebook.metadata.language_info == {"name": "python"}
        shown = [output for cell in cells for output in cell.outputs]
        assert not any(output.get("metadata") for output in shown)
        assert not any(output.output_type == "error" or output.get("name") == "stderr" for output in shown), name
        for output in shown:
            data = dict(output.get("data", {}))
            assert b"Software" not in base64.b64decode(data.pop("image/png", "")), name
            text = " ".join([output.get("text", ""), *data.values()])
            assert not re.search(r"(^|[\s'\"])/\w+/|\\Users\\|0x[0-9a-f]{6}|20\d\d-\d\d-\d\d", text), (name, text)
