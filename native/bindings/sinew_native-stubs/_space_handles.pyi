# SPDX-License-Identifier: GPL-3.0-or-later
from typing import Any

from numpy.typing import ArrayLike, NDArray

from ._core import SolveReport
from ._mesh import SurfaceMesh
from ._space import SpaceMethod
from ._types import Floats, Ints, Singles

class HandleMethod(SpaceMethod):
    def warp_poses(
        self,
        poses: ArrayLike,
        out: Singles | None = None,
        *,
        incoming: ArrayLike | None = None,
        from_rest: ArrayLike | None = None,
    ) -> NDArray[Any]: ...
    def network(
        self, poses: ArrayLike, *, incoming: ArrayLike | None = None, from_rest: ArrayLike | None = None
    ) -> tuple[Floats, Ints]: ...
    def report_for(self, poses: ArrayLike) -> SolveReport: ...

class EmbeddedDeformation(HandleMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        points: ArrayLike,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        nodes: int = 300,
        rotation: float = 1.0,
        regularity: float = 10.0,
        pulls: float = 100.0,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
    ) -> None: ...
    def graph(self) -> dict[str, Any]: ...
    def weights(self) -> Floats: ...
    def answer(
        self,
        poses: ArrayLike,
        *,
        from_rotations: bool = True,
        tolerance: float = 1e-4,
        max_iterations: int = 40,
    ) -> tuple[Floats, SolveReport]: ...

class RigidCells(HandleMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        points: ArrayLike,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        cells: int = 2000,
        levels: int = 2,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
    ) -> None: ...
    def cells(self) -> dict[str, Any]: ...
    def answer(
        self,
        poses: ArrayLike,
        *,
        from_cascade: bool = True,
        tolerance: float = 1e-4,
        max_iterations: int = 40,
    ) -> tuple[Floats, SolveReport]: ...
