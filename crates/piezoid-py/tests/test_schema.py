"""The JSON Schemas of model files and profiles say what their loaders read."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import piezoid as pz
import pytest

ROOT = Path(__file__).parents[3]
VERSIONS = ROOT / "crates/piezoid/tests/compatibility"


def schema(name: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(json.loads((ROOT / "docs/schema" / f"{name}.json").read_text()))


SCHEMA, PROFILE = schema("model-1"), schema("profile-1")

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


def test_the_schemas_are_schemas() -> None:
    for each in (SCHEMA, PROFILE):
        each.check_schema(each.schema)


@pytest.mark.parametrize("name", MODELS)
def test_loader_and_schema_read_the_same_models(name: str) -> None:
    model = MODELS[name]
    SCHEMA.validate(model)
    assert is_read(model)
    for how, changed in changes(model):
        assert SCHEMA.is_valid(changed) == is_read(changed), how


def test_what_is_identified_now_keeps_the_schema(model: pz.Model) -> None:
    SCHEMA.validate(model.to_dict())


@pytest.mark.parametrize("path", list(VERSIONS.glob("*/given/rig.toml")), ids=lambda path: path.parts[-3])
def test_loader_and_schema_read_the_same_profiles(path: Path, tmp_path: Path) -> None:
    profile = tomllib.loads(path.read_text())
    assert pz.read(path.with_suffix(".csv"), profile=path).ts > 0
    PROFILE.validate(profile)
    assert profile.keys() <= PROFILE.schema["properties"].keys()
    changed = tmp_path / "rig.toml"
    values: list[tuple[str, Any]] = [("fs", 0.0), ("from", -1.0), ("unknown", 1.0)]
    values += [(name, value) for name in PROFILE.schema["properties"] for value in (True, [1], "text", 1.0)]
    for name, value in values:
        one = profile | {name: value}
        changed.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in one.items()))
        # What is of the right kind may be wrong for this file, such as the name of a column.
        refused = ""
        try:
            pz.read(path.with_suffix(".csv"), profile=changed)
        except pz.PiezoidError as error:
            refused = str(error)
        assert PROFILE.is_valid(one) == ("rig.toml" not in refused), (name, value, refused)
