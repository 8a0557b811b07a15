"""Types that many files speak of."""

from collections.abc import Callable
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Samples, of shape (n,)."""

Samples: TypeAlias = npt.ArrayLike
"""What numpy makes an array of shape (n,) of."""

Told: TypeAlias = Callable[[str, int, int], Any]
"""Called with what is being done, how many steps of it are done, and of how many."""


class Bar(Protocol):
    """A bar as tqdm has them."""

    n: Any
    total: Any

    def update(self, n: Any = ..., /) -> Any: ...


Progress: TypeAlias = "bool | Told | Bar | type[Any] | None"
"""True for a tqdm bar, a class of bars such as `tqdm.tqdm`, a bar, a function that is told, or nothing."""

Units: TypeAlias = tuple[str, str]
"""Of input and output."""

Offset: TypeAlias = Literal["kept", "free"]
Begin: TypeAlias = Literal["rest", "settled", "motion", "likely"]
