"""The paper's experiment from end to end, as tables, figures and a page."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _files, _piezoid
from ._piezoid import PiezoidError
from ._keywords import known, takes
from ._options import StudyOptions
from ._progress import watched
from ._types import Progress

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import Unpack


@dataclass(frozen=True, eq=False)
class Study:
    """Results of the study of a plant."""

    figures: dict[str, Any] = field(repr=False)
    """All numbers, as the command line writes them."""
    svg: dict[str, str] = field(repr=False)
    """The figures by name."""
    html: str = field(repr=False)
    """The page."""
    verdict: str
    """The conclusions in words."""

    @property
    def table1(self) -> pd.DataFrame:
        """The error of each method at each frequency."""
        import pandas as pd

        return pd.DataFrame(self.figures["table1"])

    @property
    def table2(self) -> pd.DataFrame:
        """The linear block of each estimator."""
        import pandas as pd

        return pd.DataFrame(self.figures["table2"])

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes report.html and the figures."""
        place = Path(folder)
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PiezoidError(f"cannot create the folder {place}: {error.strerror}: choose another") from None
        _files.write(place / "report.html", self.html)
        for name, drawn in self.svg.items():
            _files.write(place / f"{name}.svg", drawn)


@takes(StudyOptions)
def study(plant: str = "paper", *, progress: Progress = None, **options: Unpack[StudyOptions]) -> Study:
    """The paper's experiment on one of `pz.plants`.

    PRBS, ARX by particle swarm, two spline branches per frequency, test on stepped sines of 7 steps.

    {options}
    """
    settings = {"plant": plant, **known(study, options)}
    with watched(progress) as watch:
        figures, svg, html, verdict = _piezoid.study(settings, watch)
    return Study(figures, dict(svg), html, verdict)
