"""Hysteresis models of piezo actuators: identified from records, validated, inverted, exported.

>>> import piezoid as pz
>>> plant = pz.plants["pl140"]
>>> small = plant.measure(pz.excite.prbs(ts=5e-4, duration=2, amplitude=1), ts=5e-4)
>>> large = plant.measure(pz.excite.rising_sine(ts=5e-4, duration=2, amplitude=28, frequency=5), ts=5e-4)
>>> model = pz.identify(small_signal=[small], large_signal=[large], operator="preisach")
>>> y = model.simulate([0.0, 1.0, 2.0])

Voltages are in volts, displacements in the unit of the records (um if no unit is given), times in seconds. Series are
numpy arrays of shape (n,); anything that numpy converts to such an array is accepted. Invalid input raises
`PiezoidError`, a `ValueError` that says what is wrong, where, and what to do.
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from . import excite, linear
from ._piezoid import PiezoidError, __version__
from .campaign import Campaign, campaign
from .compare import ModelComparison, compare
from .control import Comparison, control, reference
from .export import export
from .identify import identify
from .inspect import Inspection, inspect
from .lists import actuators, controllers, drivers, estimators, excitations, operators, references, targets
from .model import Certificate, Compensation, FeedForward, Model, Validation, Verdict, load
from .online import Online
from .plan import Plan, plan
from .plants import Plant, plants
from .records import Record, read, read_reference
from .stand_in import stand_in
from .study import Study, study
from .timing import Timing, timing

if TYPE_CHECKING:
    from . import fleet as fleet
    from . import learn as learn
    from . import plot as plot

__all__ = [
    "Campaign",
    "Certificate",
    "Comparison",
    "Compensation",
    "FeedForward",
    "Inspection",
    "Model",
    "ModelComparison",
    "Online",
    "PiezoidError",
    "Plan",
    "Plant",
    "Record",
    "Study",
    "Timing",
    "Validation",
    "Verdict",
    "__version__",
    "actuators",
    "campaign",
    "compare",
    "control",
    "controllers",
    "drivers",
    "estimators",
    "excitations",
    "excite",
    "export",
    "identify",
    "inspect",
    "linear",
    "load",
    "operators",
    "plan",
    "plants",
    "read",
    "read_reference",
    "reference",
    "references",
    "stand_in",
    "study",
    "targets",
    "timing",
]


def __getattr__(name: str) -> ModuleType:
    # These modules need further packages, and are imported on first use.
    if name in ("fleet", "learn", "plot"):
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, "fleet", "learn", "plot"])
