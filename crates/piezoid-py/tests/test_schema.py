"""The JSON Schema of model files says what the loader reads."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import piezoid as pz
import pytest

ROOT = Path(__file__).parents[3]
VERSIONS = ROOT / "crates/piezoid/tests/compatibility"
SCHEMA = jsonschema.Draft202012Validator(json.loads((ROOT / "docs/schema/model-1.json").read_text()))

MODELS = {f"{path.parts[-3]} {path.stem}": json.loads(path.read_text())["model"] for path in VERSIONS.glob("*/operators/*.json")}
MODELS |= {f"{path.parts[-3]} {path.stem}": json.loads(path.read_text()) for path in VERSIONS.glob("*/given/*.json")}


def objects(value: Any) -> Iterator[dict[str, Any]]:
    """All objects whose fields the loader knows: not those of the provenance."""
    if isinstance(value, dict):
        yield value
        for key, inner in value.items():
            if key != "fit":
                yield from objects(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from objects(inner)


def changes(model: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The model without a field, with a field that nobody knows, and with fields of other types."""
    for k, fields in enumerate(objects(model)):
        for key in fields:
            for how in ["removed", "text", [["text"]], True]:
                changed = copy.deepcopy(model)
                of = list(objects(changed))[k]
                if how == "removed":
                    del of[key]
                elif key == "fit":
                    continue
                elif of[key] is not None:
                    of[key] = how
                yield f"{key} {how}", changed
        changed = copy.deepcopy(model)
        list(objects(changed))[k]["unknown"] = 1.0
        yield f"unknown field in {list(fields)}", changed


def is_read(model: dict[str, Any]) -> bool:
    try:
        pz.Model.from_dict(model)
    except pz.PiezoidError:
        return False
    return True


def test_the_schema_is_a_schema() -> None:
    SCHEMA.check_schema(SCHEMA.schema)


@pytest.mark.parametrize("name", MODELS)
def test_loader_and_schema_read_the_same_models(name: str) -> None:
    model = MODELS[name]
    SCHEMA.validate(model)
    assert is_read(model)
    for how, changed in changes(model):
        assert SCHEMA.is_valid(changed) == is_read(changed), how


def test_what_is_identified_now_keeps_the_schema(model: pz.Model) -> None:
    SCHEMA.validate(model.to_dict())
