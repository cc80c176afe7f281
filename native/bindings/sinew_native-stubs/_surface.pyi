# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Sequence
from typing import Literal

from numpy.typing import ArrayLike

from ._core import BindReport, SolveReport
from ._mesh import SurfaceMesh
from ._operators import Discretization
from ._types import Floats, Ints, Progress, Singles, Weights

FreeParts = Literal["stay", "follow"]
Field = Literal["harmonic", "geodesic", "euclidean"]
Details = Literal[
    "displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer"
]
LocalTransforms = Literal["none", "explicit", "estimated", "implicit"]

class SurfaceMethod:
    def set_handles(
        self,
        handles: Sequence[ArrayLike],
        weights: Weights | None = None,
        continuity: ArrayLike | None = None,
        progress: Progress | None = None,
        *,
        free_parts: FreeParts = "stay",
        free_part_stiffness: ArrayLike | None = None,
    ) -> BindReport: ...
    def rebind(
        self,
        former: SurfaceMethod,
        handles: Sequence[ArrayLike],
        weights: Weights | None = None,
        continuity: ArrayLike | None = None,
        progress: Progress | None = None,
        *,
        free_parts: FreeParts = "stay",
        free_part_stiffness: ArrayLike | None = None,
    ) -> BindReport: ...
    def can_reuse(self, former: object) -> bool: ...
    def solve(
        self,
        poses: ArrayLike,
        *,
        incoming: ArrayLike | None = None,
        from_rest: bool | Sequence[bool] | None = None,
        start: ArrayLike | None = None,
        max_iterations: int | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
        out: Singles | None = None,
        substeps: int = 1,
        morph: float = 0.0,
        grid: ArrayLike | None = None,
    ) -> tuple[Floats | Singles, SolveReport]: ...
    @property
    def rest(self) -> SurfaceMesh: ...

class ThinShell(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        stretching: ArrayLike = 0.0,
        bending: ArrayLike = 1.0,
        variation: ArrayLike = 0.0,
        laplacian: Discretization = "cotan_voronoi",
        affine_basis: bool = True,
    ) -> None: ...
    def set_stiffness(
        self,
        stretching: ArrayLike,
        bending: ArrayLike,
        variation: ArrayLike = 0.0,
        progress: Progress | None = None,
    ) -> BindReport: ...

class AffineBasis:
    def __init__(self, thin_shell: ThinShell) -> None: ...
    @property
    def matrix(self) -> Floats: ...
    def solve(self, poses: ArrayLike) -> tuple[Floats, SolveReport]: ...

class Propagation(SurfaceMethod):
    def __init__(
        self, mesh: SurfaceMesh, *, field: Field = "harmonic", transfer: ArrayLike | None = None
    ) -> None: ...

class GradientEditing(SurfaceMethod):
    def __init__(self, mesh: SurfaceMesh, *, field: Field = "harmonic") -> None: ...

class RotationInvariantCoordinates(SurfaceMethod):
    def __init__(self, mesh: SurfaceMesh, *, laplacian: Literal["uniform", "cotan"] = "cotan") -> None: ...

class HierarchicalSmoothing(SurfaceMethod):
    def __init__(self, mesh: SurfaceMesh, *, levels: int = 64, relaxations: int = 4) -> None: ...

class SplineSurface(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        degree: int = 3,
        columns: int = 8,
        rows: int = 8,
        smoothing: float = 1e-3,
        margin: float = 0.2,
        uv_map: ArrayLike | None = None,
    ) -> None: ...
    def control_grids(
        self,
        poses: ArrayLike,
        *,
        incoming: ArrayLike | None = None,
        from_rest: ArrayLike | None = None,
        grid: ArrayLike | None = None,
    ) -> list[Floats]: ...

class SubdivisionEditing(SurfaceMethod):
    def __init__(
        self, mesh: SurfaceMesh, *, coarsening: Literal["automatic", "levels"] = "automatic", levels: int = 1
    ) -> None: ...
    def level_counts(self) -> list[int]: ...
    def control_mesh(self) -> SurfaceMesh: ...

class LaplacianEditing(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        transforms: LocalTransforms = "estimated",
        laplacian: Discretization = "cotan_voronoi",
        field: Field = "harmonic",
        refits: int = 2,
        second_stage: Literal["polar", "length"] = "polar",
        mean_frame: bool = True,
    ) -> None: ...

class VolumetricGraphLaplacian(SurfaceMethod):
    def __init__(
        self, mesh: SurfaceMesh, *, volume: float = 1.0, laplacian: Discretization = "cotan_voronoi"
    ) -> None: ...
    def inner_points(self) -> Floats: ...

class Arap(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        smoothness: float = 5e-4,
        cells: Literal["spokes", "rims"] = "spokes",
        rigidity: ArrayLike = 1.0,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
        point_handles: float = 0.0,
    ) -> None: ...
    def energy(self, positions: ArrayLike) -> float: ...

class ThinShellNonlinear(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        measure: Literal["share", "length", "stiffness"] = "share",
        thickness: ArrayLike = 0.02,
        stretching: ArrayLike = 1.0,
        bending: ArrayLike = 1.0,
        max_iterations: int = 60,
        tolerance: float = 1e-4,
    ) -> None: ...
    def energy(self, positions: ArrayLike) -> float: ...

class EditKeys:
    def __init__(self, keys: ArrayLike) -> None: ...
    def at(self, handle: int, frame: float) -> Floats: ...
    @property
    def handle_count(self) -> int: ...

class MeshSequence(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        smoothness: float = 5e-4,
        cells: Literal["spokes", "rims"] = "spokes",
        rigidity: ArrayLike = 1.0,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
        point_handles: float = 0.0,
    ) -> None: ...
    def solve_frame(
        self,
        frame: float,
        *,
        poses: ArrayLike | None = None,
        keys: ArrayLike | None = None,
        incoming: ArrayLike | None = None,
        from_rest: bool | Sequence[bool] | None = None,
        start: ArrayLike | None = None,
        max_iterations: int | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
        out: Singles | None = None,
    ) -> tuple[Floats | Singles, SolveReport]: ...
    def solve_frames(
        self,
        frames: ArrayLike,
        shapes: ArrayLike,
        *,
        keys: ArrayLike | None = None,
        poses: ArrayLike | None = None,
        from_rest: bool | Sequence[bool] | None = None,
        max_iterations: int | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[Floats, list[SolveReport]]: ...
    def edits(
        self,
        frame: float,
        *,
        poses: ArrayLike | None = None,
        keys: ArrayLike | None = None,
        incoming: ArrayLike | None = None,
        from_rest: bool | Sequence[bool] | None = None,
    ) -> Floats: ...
    def poses(
        self,
        frame: float,
        *,
        poses: ArrayLike | None = None,
        keys: ArrayLike | None = None,
        incoming: ArrayLike | None = None,
        from_rest: bool | Sequence[bool] | None = None,
    ) -> Floats: ...
    def still_poses(
        self, *, incoming: ArrayLike | None = None, from_rest: bool | Sequence[bool] | None = None
    ) -> Floats: ...
    def energy(self, positions: ArrayLike) -> float: ...

class MeshPuppetry(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        bending: float = 1e-3,
        max_iterations: int = 20,
        tolerance: float = 1e-4,
    ) -> None: ...

class HandleAwareIsolines(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        bands: int = 24,
        field: Field = "harmonic",
        max_iterations: int = 200,
        tolerance: float = 1e-6,
    ) -> None: ...
    def bands(self) -> Ints: ...

class SubspaceLaplacian(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        cage: SurfaceMesh | None = None,
        cage_faces: int = 0,
        clusters: int = 60,
        bending: float = 0.0015,
        keep_volume: bool = True,
        max_iterations: int = 60,
        tolerance: float = 1e-5,
    ) -> None: ...
    def cages(self) -> list[SurfaceMesh]: ...
    def clusters(self) -> Ints: ...

class Primo(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        height: ArrayLike = 0.05,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
    ) -> None: ...

class PyramidCoordinates(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        *,
        side: float = 0.05,
        similarity: bool = False,
        target_shape: SurfaceMesh | None = None,
        max_iterations: int = 40,
        tolerance: float = 1e-4,
    ) -> None: ...
    @property
    def folded_rings(self) -> Ints: ...

class Multiresolution(SurfaceMethod):
    def __init__(
        self,
        mesh: SurfaceMesh,
        base: SurfaceMethod,
        *,
        details: Details = "displacement_vectors",
        wavelength: float = 10.0,
        bands: int = 1,
    ) -> None: ...
    def levels(self) -> list[Floats]: ...

class MeshTransfer:
    def __init__(self, source: SurfaceMesh, target: SurfaceMesh) -> None: ...
    def transfer(self, source: ArrayLike) -> Floats: ...

class SilhouetteSketch:
    def __init__(
        self,
        mesh: SurfaceMesh,
        edges: ArrayLike,
        shares: ArrayLike,
        held: ArrayLike,
        *,
        laplacian: str = "cotan_voronoi",
        refits: int = 2,
        sharpness: float = 0.0,
        weight: float = 0.99,
    ) -> None: ...
    def solve(self, targets: ArrayLike) -> Floats: ...

def silhouette_lines(
    mesh: SurfaceMesh, axes: ArrayLike, eye: ArrayLike | None = None
) -> list[tuple[Ints, Floats, bool]]: ...
def fit_stroke(
    mesh: SurfaceMesh,
    stroke: ArrayLike,
    axes: ArrayLike,
    eye: ArrayLike | None = None,
    edges: ArrayLike | None = None,
    nearness: float = 0.5,
    hidden: bool = False,
) -> tuple[Ints, Floats, Floats] | None: ...
