"""Types that many files speak of."""

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Samples, of shape (n,)."""

Samples: TypeAlias = npt.ArrayLike
"""What numpy makes an array of shape (n,) of."""

Told: TypeAlias = Callable[[str, int, int], Any]
"""Called with what is being done, how many steps of it are done, and of how many."""

Progress: TypeAlias = "bool | Told | None"
"""True for a tqdm bar, a function that is told, or nothing."""

Units: TypeAlias = tuple[str, str]
"""Of input and output."""

Offset: TypeAlias = Literal["kept", "free"]
Begin: TypeAlias = Literal["rest", "settled", "motion", "likely"]
