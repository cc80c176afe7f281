# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Sequence
from typing import Literal

from ._mesh import SurfaceMesh
from ._space import SpaceMethod
from ._types import Floats, Precision

class CageCoordinates(SpaceMethod):
    def influence(self, vertices: Sequence[int]) -> Floats: ...
    @property
    def vertex_weights(self) -> Floats: ...

class Green(CageCoordinates):
    def __init__(
        self,
        cage: SurfaceMesh,
        *,
        precision: Precision = "single",
        threshold: float = 0.0,
        outside: Literal["nearest", "face", "error"] = "nearest",
        exit_face: int = -1,
        faces: Literal["triangles", "quads"] = "triangles",
    ) -> None: ...
    @property
    def face_weights(self) -> Floats: ...

class MeanValue(CageCoordinates):
    def __init__(
        self, cage: SurfaceMesh, *, precision: Precision = "single", threshold: float = 0.0
    ) -> None: ...

class Harmonic(CageCoordinates):
    def __init__(
        self,
        cage: SurfaceMesh,
        *,
        precision: Precision = "single",
        threshold: float = 0.0,
        quality: Literal["fast", "medium", "fine", "finest"] = "medium",
        outside: Literal["error", "mean_value"] = "error",
        solver: Literal["auto", "boundary", "lattice"] = "auto",
    ) -> None: ...
    @property
    def unknowns(self) -> int: ...
    @property
    def residual_rms(self) -> float: ...
    @property
    def residual_max(self) -> float: ...

class PositiveMeanValue(CageCoordinates):
    def __init__(
        self,
        cage: SurfaceMesh,
        *,
        precision: Precision = "single",
        threshold: float = 0.0,
        exact: bool = True,
        directions: int = 1024,
        outside: Literal["error", "mean_value"] = "error",
    ) -> None: ...
