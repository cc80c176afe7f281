# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Sequence
from typing import Literal

from numpy.typing import ArrayLike

from ._mesh import SurfaceMesh
from ._space import SpaceMethod
from ._types import Floats

Interpolation = Literal["linear", "cardinal", "catmull_rom", "bspline"]

class Ffd(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike | SurfaceMesh,
        *,
        resolution: Sequence[int] | None = None,
        basis: Literal["bspline", "bezier", "blender"] = "bspline",
        degree: int = 3,
        interpolation: Interpolation | Sequence[Interpolation] = "bspline",
        outside: Literal["follow", "freeze"] = "follow",
        continuity: int = 1,
        smooth: int = 1,
        axes: ArrayLike | None = None,
    ) -> None: ...
    @property
    def control_count(self) -> int: ...

class InverseFfd(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        resolution: int | Sequence[int] = 5,
        basis: Literal["bspline", "bezier"] = "bspline",
        degree: int = 3,
        cut_off: float = 1e-3,
        frame: SurfaceMesh | ArrayLike | None = None,
    ) -> None: ...
    @property
    def lattice(self) -> Floats: ...
    @property
    def rank(self) -> int: ...
    def control_moves(self, posed: ArrayLike) -> Floats: ...
