"""Hysteresis models of piezo actuators: identified from records, proven, inverted, exported.

>>> import piezoid as pz
>>> plant = pz.plants["pl140"]
>>> small = plant.measure(pz.excite.prbs(ts=5e-4, duration=2, amplitude=1), ts=5e-4)
>>> rich = plant.measure(pz.excite.rising_sine(ts=5e-4, duration=2, amplitude=28, frequency=5), ts=5e-4)
>>> model = pz.identify(linear=[small], rich=[rich], operator="prandtl-ishlinskii")
>>> y = model.simulate([0.0, 1.0, 2.0])

Voltages are in volts, displacements in the unit of the records (um unless they say otherwise), times in seconds. Series are
numpy arrays of shape (n,); anything numpy makes such an array of may be given. What is wrong raises `PiezoidError`, a
`ValueError` that says what, where, and what to do.
"""

from . import excite, fleet, linear
from ._piezoid import PiezoidError, __version__
from .control import Comparison, control
from .export import export
from .identify import identify
from .lists import controllers, drivers, estimators, excitations, operators, references, targets
from .model import Compensation, FeedForward, Model, Validation, load
from .plants import Plant, plants
from .records import Record, read, read_reference
from .study import Study, study

__all__ = [
    "Comparison",
    "Compensation",
    "FeedForward",
    "Model",
    "PiezoidError",
    "Plant",
    "Record",
    "Study",
    "Validation",
    "__version__",
    "control",
    "controllers",
    "drivers",
    "estimators",
    "excitations",
    "excite",
    "export",
    "fleet",
    "identify",
    "linear",
    "load",
    "operators",
    "plants",
    "read",
    "read_reference",
    "references",
    "study",
    "targets",
]
