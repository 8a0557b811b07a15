"""Comparison of several models on the same records."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from . import _piezoid
from ._keywords import known, takes
from ._options import ValidateOptions
from .model import Model, as_model
from .records import as_record, sources

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack

    from .records import Source, Sources

    ModelSource: TypeAlias = "Model | str | os.PathLike[str]"


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Free runs of several models on the same records."""

    figures: dict[str, Any] = field(repr=False)
    """All figures, as the command line writes them."""
    html: str = field(repr=False)
    """A page with tables and figures."""

    @property
    def best(self) -> str | None:
        """Name of the model with the smallest error over all records; None if the outputs are constant."""
        name: str | None = self.figures["best"]
        return name

    @property
    def summary(self) -> str | None:
        """The comparison in one sentence; None if the outputs are constant."""
        text: str | None = self.figures["summary"]
        return text

    @property
    def table(self) -> pd.DataFrame:
        """Rms errors in percent of the peak-to-peak of the record: one row per model, one column per record, and
        `total` if there are several and none is called so."""
        import pandas as pd

        rows = {}
        for model in self.figures["models"]:
            errors = {file["file"]: file["rms_pp_percent"] for file in model["files"]}
            total = {"total": model["total"]["rms_pp_percent"]} if len(errors) > 1 and "total" not in errors else {}
            rows[model["model"]] = errors | total
        return pd.DataFrame.from_dict(rows, orient="index", dtype=float)

    def __repr__(self) -> str:
        return f"<ModelComparison: {self.summary or 'the outputs are constant'}>"


@takes(ValidateOptions)
def compare(
    models: Mapping[str, ModelSource] | Iterable[ModelSource] | ModelSource,
    data: Mapping[str, Source] | Sources,
    *,
    record: str | None = None,
    **options: Unpack[ValidateOptions],
) -> ModelComparison:
    """Compares free runs of several models with records that none of them has seen.

    models, data: models and records in dicts by their names (not a record as a dict of its columns), or in lists. Files
    in lists are called by their names, models by their operators, and records by their numbers.
    record: name of the record whose loops and residuals are drawn on the page; default: the first

    {options}

    >>> import piezoid as pz
    >>> def gain(k):
    ...     block = {"a": [0.5], "b": [0.5 * k]}
    ...     hysteresis = {"operator": "proportional", "gain": 1.0}
    ...     return pz.Model.from_dict({"piezoid": 1, "ts": 1e-3, "hysteresis": hysteresis, "linear": block})
    >>> u = pz.excite.sine(ts=1e-3, duration=1, amplitude=20, frequency=5)
    >>> compared = pz.compare({"two": gain(2), "three": gain(3)}, {"sine": pz.Record(u, 2.1 * u, ts=1e-3)})
    >>> compared.best
    'two'
    """
    one = [models] if isinstance(models, (Model, str, os.PathLike)) else models
    settings = {"record": record, **known(compare, options)}
    cores = _named("models", one, as_model, lambda model, _: as_model(model).operator)
    values = data if isinstance(data, Mapping) else sources(data)
    measured = _named("data", values, as_record, lambda _, number: f"record {number}")
    return ModelComparison(*_piezoid.compare(cores, measured, settings))


def _named(
    what: str, values: Mapping[str, Any] | Iterable[Any], read: Callable[[Any], Any], name: Callable[[Any, int], str]
) -> list[tuple[str, Any]]:
    """The cores of the members with their names; those of a list are called by their files, or by `name`."""
    if isinstance(values, Mapping):
        named = [(str(key), one) for key, one in values.items()]
    else:
        files = (str, os.PathLike)
        named = [(Path(one).name if isinstance(one, files) else name(one, k), one) for k, one in enumerate(values, 1)]
    if not named:
        raise _piezoid.PiezoidError(f"{what} is empty: give one at least")
    called = [key for key, _ in named]
    unique = [key if called.count(key) == 1 else f"{key} ({called[: k + 1].count(key)})" for k, key in enumerate(called)]
    return [(key, read(one)._core) for key, (_, one) in zip(unique, named)]
