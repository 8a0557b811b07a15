"""Types that many files use."""

from collections.abc import Callable
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Samples, of shape (n,)."""

Samples: TypeAlias = npt.ArrayLike
"""Anything that numpy converts to an array of shape (n,)."""

OnProgress: TypeAlias = Callable[[str, int, int], Any]
"""Called with the kind of work, the number of steps done, and the total number of steps."""


class Bar(Protocol):
    """A bar with the interface of tqdm."""

    n: Any
    total: Any

    def update(self, n: Any = ..., /) -> Any: ...


Progress: TypeAlias = "bool | OnProgress | Bar | type[Any] | None"
"""True for a tqdm bar, a class of bars such as `tqdm.tqdm`, a bar, a function to call, or None."""

Units: TypeAlias = tuple[str, str]
"""Units of input and output."""

Begin: TypeAlias = Literal["rest", "settled", "from-above", "from-below", "demagnetised", "motion", "likely"]
