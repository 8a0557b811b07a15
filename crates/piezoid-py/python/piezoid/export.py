"""Models for other machines: C, FMUs, Simulink, structured text, Rust, wave tables."""

from __future__ import annotations

import os
from typing import Any

from . import _piezoid
from ._types import Samples
from .lists import described
from .model import Model, as_model


class Exported(dict[str, bytes]):
    """The exported files by path, and `notes`, remarks on them."""

    def __init__(self, files: list[tuple[str, bytes]], notes: list[str]) -> None:
        super().__init__(files)
        self.notes = notes

    def __repr__(self) -> str:
        return "\n".join([*(f"{path}: {len(content)} bytes" for path, content in self.items()), *self.notes])


def export(
    model: Model | str | os.PathLike[str],
    target: str,
    folder: str | os.PathLike[str] | None = None,
    *,
    reference: Samples | None = None,
    **options: Any,
) -> Exported:
    """Exports a model to a target (`pz.targets`): returns the files by path, and writes them to `folder` if given.

    reference: for the target waveform, one period of the requested displacement [output unit], of shape (n,)

    Options; each is for the targets that take it:

    {options}

    >>> import piezoid as pz
    >>> model = pz.Model.from_dict({"piezoid": 1, "ts": 5e-4, "hysteresis": {"operator": "proportional", "gain": 1.0},
    ...                             "linear": {"a": [0.5], "b": [1.0]}, "identified": None})
    >>> sorted(pz.export(model, "c", name="bender", low=-30.0, high=30.0))
    ['bender.c', 'bender.h', 'bender.md', 'bender_test.c']
    """
    for name in options:
        if name not in _OPTIONS:
            raise TypeError(f"unexpected keyword {name!r}: options are {', '.join(_OPTIONS)}")
    files, notes = _piezoid.export(as_model(model)._core, target, options, reference, folder)
    return Exported(files, notes)


_ROWS = _piezoid.export_options()
_OPTIONS = [row["name"] for row in _ROWS]
export.__doc__ = (export.__doc__ or "").replace("{options}", "\n    ".join(described(_ROWS)))
