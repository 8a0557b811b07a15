"""What a source of records holds, how it is read, and what seems wrong with it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _files
from ._columns import columns_of, profile_of
from ._keywords import known, takes
from ._options import ColumnOptions
from .records import Record
from .results import frame

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack


@dataclass(frozen=True, eq=False)
class Inspection:
    """What a source holds, and how `read` reads it."""

    figures: dict[str, Any] = field(repr=False)
    """All that was found, as the command line writes it."""
    record: Record | None
    """The record; None if there is none."""
    error: str | None
    """Why there is no record, and which keywords help."""
    _profile: str | None = field(repr=False)

    @property
    def channels(self) -> pd.DataFrame:
        """One row per channel: `name`, `unit`, `samples`, `low`, `high`, and its `role` (time, input, output)."""
        return frame(self.figures["channels"])

    @property
    def history(self) -> list[str]:
        """How the record is made of the channels: what was guessed, scaled, cut."""
        return list(self.figures["history"])

    @property
    def problems(self) -> list[str]:
        """Suspected defects of the record."""
        return [] if self.record is None else list(self.figures["problems"])

    def save_profile(self, path: str | os.PathLike[str]) -> None:
        """Writes a profile: how this source is read. `read(..., profile=path)` and the command line take it."""
        from ._piezoid import PiezoidError

        if self._profile is None:
            raise PiezoidError(f"there is no profile, because there is no record: {self.error}")
        _files.write(path, "# How records of this rig are read: piezoid VERB ... --profile FILE\n" + self._profile)

    def __repr__(self) -> str:
        names = [f"{c['name']} ({c['role'] or 'unused'})" for c in self.figures["channels"]]
        lines = [f"{self.figures['file']}: {self.figures['format']}, channels {', '.join(names)}"]
        lines.append(f"no record: {self.error}" if self.record is None else repr(self.record)[1:-1])
        return "\n".join([*lines, *self.history, *(f"problem: {problem}" for problem in self.problems)])


@takes(ColumnOptions)
def inspect(
    source: str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame,
    *,
    profile: str | os.PathLike[str] | None = None,
    **columns: Unpack[ColumnOptions],
) -> Inspection:
    """Shows what a file, a DataFrame or a mapping of arrays holds, and how `read` reads it.

    profile: as for `read`

    {options}

    >>> import numpy as np, piezoid as pz
    >>> t = np.arange(200)
    >>> seen = pz.inspect({"Time (ms)": t, "u [V]": np.sin(0.1 * t), "Position (nm)": np.cos(0.1 * t)})
    >>> list(seen.channels["role"]), seen.record.units
    (['time', 'input', 'output'], ('V', 'nm'))
    """
    settings, held, rig = known(inspect, columns), columns_of(source), profile_of(profile)
    with held.named():
        figures, core, error = held.core.inspect(held.name, settings, rig)
        record = None if core is None else Record._of(core)
        result = None if record is None else held.core.profile(settings, rig)
    return Inspection(figures, record, error, result)
