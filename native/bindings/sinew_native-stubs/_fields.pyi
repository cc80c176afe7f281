# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Sequence
from typing import Literal

from numpy.typing import ArrayLike

from ._space import SpaceMethod
from ._types import Floats

_Tool = Literal["drag", "twist", "bend"]

class VectorField(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        counts: Sequence[int] | None = None,
        *,
        tools: _Tool | Sequence[_Tool] = "drag",
        inner: ArrayLike = 0.5,
        outer: ArrayLike = 1.0,
        width: ArrayLike = 1.0,
        order: Literal[1, 2, 4] = 4,
        steps: int = 0,
        tolerance: float = 1e-5,
    ) -> None: ...
    def velocities(self, cage_points: ArrayLike, piece: int, time: float, points: ArrayLike) -> Floats: ...
    def piece_count(self, cage_points: ArrayLike) -> int: ...
    @property
    def tool_count(self) -> int: ...
