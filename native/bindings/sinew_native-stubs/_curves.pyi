# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Sequence

from numpy.typing import ArrayLike

from ._space import SpaceMethod

class Wires(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        counts: Sequence[int] | None = None,
        *,
        closed: ArrayLike | None = None,
        radius: ArrayLike = 1.0,
        scale: ArrayLike = 1.0,
        rotation: ArrayLike = 1.0,
        domain: ArrayLike | None = None,
        exponent: float = 1.0,
        smoothing: float = 0.2,
    ) -> None: ...
    @property
    def curve_count(self) -> int: ...
    @property
    def sample_count(self) -> int: ...
