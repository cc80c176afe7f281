# SPDX-License-Identifier: GPL-3.0-or-later
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix

from ._mesh import SurfaceMesh
from ._types import Floats, Ints

class SubdivisionSurface:
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        scheme: Literal["catmull_clark", "loop", "bilinear"] = "catmull_clark",
        level: int = 2,
        limit: bool = False,
        creases: tuple[ArrayLike, ArrayLike] | None = None,
        corners: tuple[ArrayLike, ArrayLike] | None = None,
        boundary_smooth: Literal["all", "preserve_corners"] = "all",
        uv_smooth: Literal[
            "none",
            "preserve_corners",
            "preserve_corners_and_junctions",
            "preserve_corners_junctions_and_concave",
            "preserve_boundaries",
            "smooth_all",
        ] = "preserve_boundaries",
        face_varying: ArrayLike | None = None,
    ) -> None: ...
    def refine(
        self, points: ArrayLike, out: NDArray[np.float32] | Floats | None = None
    ) -> NDArray[np.float32] | Floats: ...
    @property
    def matrix(self) -> csr_matrix: ...
    @property
    def faces(self) -> Ints | tuple[Ints, Ints]: ...
    def normals(self, refined: ArrayLike) -> Floats: ...
    def refine_face_varying(self, values: ArrayLike) -> Floats: ...
    @property
    def face_varying_matrix(self) -> csr_matrix: ...
    @property
    def face_varying_corners(self) -> Ints: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def control_count(self) -> int: ...
