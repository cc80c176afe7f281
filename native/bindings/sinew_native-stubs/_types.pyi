# SPDX-License-Identifier: GPL-3.0-or-later
"""Types that the stubs share."""

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int32]
Progress = Callable[[float, str], bool | None]
Faces = ArrayLike | tuple[ArrayLike, ArrayLike]
Weights = Sequence[ArrayLike | None]
Reuse = Literal["anew", "updated", "kept"]
Precision = Literal["single", "double"]
