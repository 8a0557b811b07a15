"""Certificates: numbers, page and XML."""

from __future__ import annotations

from pathlib import Path

import piezoid as pz
import pytest


def test_a_certificate_has_its_budget_its_page_and_its_xml(
    model: pz.Model, rich: pz.Record, unseen: pz.Record, tmp_path: Path
) -> None:
    found = model.certificate(unseen, sensor_calibration=0.5, sensor_linearity="50nm", date="2026-11-30", country="CZ")
    assert found.unit == "um" and found.k >= 1.99 and found.within_percent > 95
    assert abs((found.budget["contribution"] ** 2).sum() ** 0.5 * found.k / found.expanded - 1) < 0.1
    assert list(found.records["n"]) == [len(unseen)] and "temperature" in found.not_stated
    for name, start in (("a.html", "<!DOCTYPE html>"), ("a.xml", "<?xml")):
        found.save(tmp_path / name)
        assert (tmp_path / name).read_text().startswith(start)
    assert f"k = {found.k:.2f}" in str(found)
    both = model.certificate([unseen, rich], mean_error="corrected")
    assert both.correction is not None and found.correction is None
    assert any("in no file" in remark for remark in both.remarks)


def test_what_is_wrong_is_said_in_keywords(model: pz.Model, unseen: pz.Record) -> None:
    with pytest.raises(pz.PiezoidError, match="give date= country="):
        _ = model.certificate(unseen).dcc
    with pytest.raises(pz.PiezoidError, match="sensor_linearity.*must be a positive length"):
        model.certificate(unseen, sensor_linearity="5mV")
    with pytest.raises(pz.PiezoidError, match="coverage"):
        model.certificate(unseen, coverage=100)
