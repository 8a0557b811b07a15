"""Models for other machines: C, FMUs, Simulink, structured text, Rust, wave tables."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _piezoid
from ._checks import limits as checked
from ._checks import number, some, tuning, whole
from ._types import Samples
from .model import Model, as_model

if TYPE_CHECKING:
    from ._checks import Limits, Unpack


class Exported(dict[str, bytes]):
    """Files by their paths, and `notes`: what is worth knowing of them."""

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
    name: str = "piezo_model",
    float: bool = False,
    preview: int = 0,
    controller: str | None = None,
    late: int = 0,
    gain_margin: Any = None,
    phase_margin: Any = None,
    reference: Samples | None = None,
    servo_cycle: Any = None,
    range: Sequence[Any] | None = None,
    **limits: Unpack[Limits],
) -> Exported:
    """What a target (`pz.targets`) makes of a model: files by their paths, written into `folder` where one is named.

    name: what functions, types and files are called after; float: numbers of single precision
    preview: samples of the reference that the feed-forward is given ahead of time
    controller: one to go with it, tuned as `control` tunes it (`late`, `gain_margin`, `phase_margin`)
    reference: for the target waveform, one period of the wanted displacement [output unit], of shape (n,); `servo_cycle` [s] and
        `range` [V] are of the controllers that play it
    limits: of the voltage, as of `Model.compensation`

    >>> import piezoid as pz
    >>> model = pz.Model.from_dict({"piezoid": 1, "ts": 5e-4, "hysteresis": {"operator": "proportional", "gain": 1.0},
    ...                             "linear": {"a": [0.5], "b": [1.0]}, "identified": None})
    >>> sorted(pz.export(model, "c", name="bender", low=-30.0, high=30.0))
    ['bender.c', 'bender.h', 'bender.md', 'bender_test.c']
    """
    low_high = None if range is None else some("range", range, "low, high")
    ends = None if low_high is None else (number("range", low_high[0]), number("range", low_high[1]))
    files, notes = _piezoid.export(
        as_model(model)._core,
        target,
        name,
        (float, whole("preview", preview), controller),
        tuning(late, gain_margin, phase_margin),
        checked(limits),
        reference,
        (None if servo_cycle is None else number("servo_cycle", servo_cycle), ends),
        folder,
    )
    return Exported(files, notes)
