# SPDX-License-Identifier: GPL-3.0-or-later
from typing import Literal

from numpy.typing import ArrayLike

from ._mesh import SurfaceMesh
from ._space import SpaceMethod
from ._types import Floats

class Rbf(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        kernel: Literal[
            "triharmonic", "biharmonic", "wendland_c0", "wendland_c2", "wendland_c4"
        ] = "triharmonic",
        degree: int = 2,
        radius: float = 0.5,
        tolerance: float = 1e-4,
        precision: Literal["single", "double"] = "single",
    ) -> None: ...
    @property
    def control(self) -> Floats: ...
    @property
    def centres(self) -> Floats: ...

class Mls(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        maps: Literal["affine", "similarity", "rigid"] = "rigid",
        alpha: float = 2.0,
        segments: ArrayLike | None = None,
        precision: Literal["single", "double"] = "single",
    ) -> None: ...
    @property
    def control(self) -> Floats: ...
    @property
    def maps(self) -> Literal["affine", "similarity", "rigid"]: ...

class SpacePropagation(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        transfer: ArrayLike | None = None,
    ) -> None: ...
    @property
    def control(self) -> Floats: ...

class MultiresolutionSpace(SpaceMethod):
    def __init__(
        self,
        points: ArrayLike,
        base: SpaceMethod,
        mesh: SurfaceMesh,
        counts: ArrayLike | None = None,
        *,
        weights: ArrayLike | None = None,
        details: Literal[
            "displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer"
        ] = "displacement_vectors",
        wavelength: float = 10.0,
        bands: int = 1,
    ) -> None: ...
    @property
    def control(self) -> Floats: ...
