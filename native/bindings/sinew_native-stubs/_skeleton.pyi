# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Mapping

from numpy.typing import ArrayLike

from ._mesh import SurfaceMesh
from ._types import Floats, Ints

class PoseReport:
    @property
    def iterations(self) -> int: ...
    @property
    def rejected(self) -> int: ...
    @property
    def energy(self) -> float: ...
    @property
    def converged(self) -> bool: ...
    @property
    def gaps(self) -> Floats: ...
    @property
    def centre(self) -> Floats: ...
    @property
    def overhang(self) -> float: ...

class Skeleton:
    def __init__(
        self,
        heads: ArrayLike,
        tails: ArrayLike,
        parents: ArrayLike,
        *,
        axes: ArrayLike | None = None,
        most: ArrayLike | None = None,
        angles: Mapping[int, tuple[ArrayLike, ArrayLike, str]] | None = None,
        stiffness: ArrayLike | None = None,
    ) -> None: ...
    @property
    def bone_count(self) -> int: ...
    def poses(self, turns: ArrayLike | None = None, moves: ArrayLike | None = None) -> Floats: ...
    def rotations(self, turns: ArrayLike) -> Floats: ...
    def turns(self, rotations: ArrayLike) -> Floats: ...
    def regions(self, mesh: SurfaceMesh, margin: float = 0.25) -> list[Ints]: ...
    def solve(
        self,
        bones: ArrayLike,
        points: ArrayLike,
        goals: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        turns: ArrayLike | None = None,
        moves: ArrayLike | None = None,
        moving_roots: ArrayLike | None = None,
        locked: ArrayLike | None = None,
        support: ArrayLike | None = None,
        up: ArrayLike | None = None,
        masses: ArrayLike | None = None,
        centres: ArrayLike | None = None,
        rest: float = 1e-4,
        pole: float = 1e-3,
        max_iterations: int = 200,
        tolerance: float = 1e-6,
        swing: float = 1.0,
    ) -> tuple[Floats, Floats, PoseReport]: ...
