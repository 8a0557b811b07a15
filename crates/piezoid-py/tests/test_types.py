"""The types that the package declares, and the examples in its docstrings."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import piezoid as pz

HERE = Path(__file__).parent.parent


def test_types_are_strict_and_those_of_the_compiled_part_are_true() -> None:
    for check in [["mypy", "--config-file", str(HERE / "pyproject.toml")],
                  ["mypy.stubtest", "piezoid._piezoid", "--ignore-missing-stub"]]:  # fmt: skip
        run = subprocess.run([sys.executable, "-m", *check], cwd=HERE, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stdout + run.stderr


def test_examples_run() -> None:
    for module in [pz.__name__, *(f"piezoid.{m.name}" for m in pkgutil.iter_modules(pz.__path__))]:
        result = doctest.testmod(importlib.import_module(module), optionflags=doctest.NORMALIZE_WHITESPACE)
        assert result.failed == 0, module
