"""Models for other machines: C, FMUs, Simulink, structured text, Rust, wave tables."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._keywords import known, takes
from ._options import ExportOptions
from ._types import Samples
from .model import Model, as_model

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack


class Exported(dict[str, bytes]):
    """The exported files by path; `functions`, what to call, with its operations; `notes`, remarks."""

    def __init__(self, files: dict[str, bytes], functions: list[dict[str, Any]], notes: list[str]) -> None:
        super().__init__(files)
        self.functions = functions
        self.notes = notes

    @property
    def operations(self) -> pd.DataFrame:
        """Operations in one sample of each function: the mean by kind (`additions`, ...) and the `most_seen` in the
        self-test, and the `bound` for every input."""
        import pandas as pd

        rows = [f["operations"] for f in self.functions]
        names = pd.Index([f["function"] for f in self.functions], name="function")
        return pd.DataFrame([row["mean"] | {k: row[k] for k in ("most_seen", "bound")} for row in rows], index=names)

    def __repr__(self) -> str:
        message = [
            f"{f['function']}: at most {f['operations']['most_seen']} operations observed in one sample, bound "
            f"{f['operations']['bound']} for every input"
            for f in self.functions
        ]
        return "\n".join([*(f"{path}: {len(content)} bytes" for path, content in self.items()), *message, *self.notes])


@takes(ExportOptions)
def export(
    model: Model | str | os.PathLike[str],
    target: str,
    folder: str | os.PathLike[str] | None = None,
    *,
    reference: Samples | None = None,
    force: bool = False,
    **options: Unpack[ExportOptions],
) -> Exported:
    """Exports a model to a target (`pz.targets`): returns the files by path, and writes them to `folder` if given.

    force: write even if `folder` holds another export; files of the same names are replaced
    reference: for the target waveform, one period of the requested displacement [output unit], of shape (n,)

    Options; each is for the targets that take it:

    {options}

    >>> import piezoid as pz
    >>> model = pz.Model.from_dict({"piezoid": 1, "ts": 5e-4, "hysteresis": {"operator": "proportional", "gain": 1.0},
    ...                             "linear": {"a": [0.5], "b": [1.0]}, "identified": None})
    >>> sorted(pz.export(model, "c", name="bender", low=-30.0, high=30.0))
    ['bender.c', 'bender.h', 'bender.md', 'bender_test.c']
    """
    settings = known(export, options)
    return Exported(**_piezoid.export(as_model(model)._core, target, settings, reference, folder, bool(force)))
