"""Records, models and validations in a notebook."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import piezoid as pz


def parts(thing: pz.Record | pz.Model | pz.Validation) -> tuple[dict[str, str], dict[str, np.ndarray], list[str]]:
    """The rows, their drawings as points [pixels], and the notes; the HTML must be well-formed."""
    root = ElementTree.fromstring(f"<div>{thing._repr_html_()}</div>")
    rows, drawn = {}, {}
    for row in root.iter("tr"):
        name, text, drawing = row
        rows[name.text or ""] = text.text or ""
        for line in drawing.iter("polyline"):
            drawn[name.text or ""] = np.array([point.split(",") for point in line.attrib["points"].split()], dtype=float)
    return rows, drawn, [note.text or "" for note in root.iter("li")]


def test_a_record_shows_its_course_and_loses_no_peak() -> None:
    y = np.zeros(100_000)
    y[61_234], y[12_345] = 5.0, -2.0
    record = pz.Record(np.sin(np.arange(len(y))), y, ts=1e-4, units=("V", "<nm>"))
    rows, drawn, _ = parts(record)
    assert rows["output"] == "-2 to 5 <nm>" and rows["samples"].startswith("100000, 10 s")
    x, down = drawn["output"].T
    assert x[down.argmin()] / x.max() == np.clip(x[down.argmin()] / x.max(), 0.6, 0.63)
    assert x[down.argmax()] / x.max() == np.clip(x[down.argmax()] / x.max(), 0.11, 0.14)
    assert len(record._repr_html_()) < 10_000


def test_a_record_that_stands_still_is_drawn_too() -> None:
    for n in (1, 3):
        _, drawn, _ = parts(pz.Record([1.0] * n, [2.0] * n, ts=1e-3))
        assert all(np.isfinite(points).all() for points in drawn.values()) and len(drawn) == 2


def test_a_model_shows_its_loop_and_its_resonance(model: pz.Model) -> None:
    rows, drawn, notes = parts(model)
    assert rows["hysteresis"] == model.operator and notes == model.notes
    # The descending branch lies above the ascending one.
    x, down = drawn["hysteresis"].T
    turn = len(x) // 2
    falling, rising = (sorted(zip(x[way], down[way])) for way in (slice(turn), slice(turn, None)))
    middle = [np.interp(x.mean(), *zip(*way)) for way in (falling, rising)]
    assert middle[0] < middle[1] - 1 and np.allclose([x[0], down[0]], [x[-1], down[-1]], atol=1)
    x, down = drawn["linear block"].T
    hz = 1e-3 * 500 ** ((x - x[0]) / np.ptp(x)) / model.ts
    assert model.resonance is not None and abs(hz[down.argmin()] / model.resonance[0] - 1) < 0.05


def test_a_validation_shows_what_is_left_and_what_is_not_proven(model: pz.Model, unseen: pz.Record) -> None:
    found = model.validate(unseen, skip=0.1)
    rows, drawn, notes = parts(found)
    assert rows["largest"] == f"{found.max_abs:.4g} um" and len(drawn["largest"]) > 100
    assert found.floor is not None and rows["noise floor"] == f"{found.floor['nrmse_percent']:.2g} %"
    assert found.advice and found.unproven
    assert notes == [*found.remarks, found.advice, *(f"unproven: {part}" for part in found.unproven)]


def test_drawings_have_the_colour_of_the_text(model: pz.Model, unseen: pz.Record) -> None:
    for thing in (model, unseen, model.validate(unseen)):
        colours = set(re.findall(r"(?:fill|stroke|color|background)=?:?'?([^'; ]+)", thing._repr_html_()))
        assert {c for c in colours if not re.fullmatch(r"-.*|none|currentColor", c)} == set()
