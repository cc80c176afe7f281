# SPDX-License-Identifier: GPL-3.0-or-later
"""What the native module measures on a surface: everything unusual about it, and how it bends."""

from dataclasses import dataclass

import numpy as np

from ..core.geometry import frames
from .native import _module as native_module, _translated as translated


@dataclass(frozen=True)
class Survey:
    """What a surface consists of. ``found`` are indices by name: vertices or faces (k,), edges (k, 2)."""

    parts: int
    borders: int
    one_sided: int
    euler_characteristic: int
    found: dict[str, np.ndarray]


@dataclass(frozen=True)
class Curvature:
    """Curvatures of each vertex, in 1 / length, ``gaussian`` in 1 / area; convex places are positive."""

    mean: np.ndarray  # (n,)
    gaussian: np.ndarray  # (n,)
    principal: np.ndarray  # (n, 2) the smallest and the largest
    directions: np.ndarray  # (n, 2, 3) unit tangents along which these are


def survey(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], crossings: bool) -> Survey:
    """Find everything unusual. ``points`` (n, 3) float64, ``faces`` (counts, corners).

    Points that are not finite are treated as points at the origin. ``crossings``: look for faces that pass
    through each other, too, which takes longest.
    """
    bad = ~frames.are_valid(points)
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(np.where(bad[:, None], 0.0, points), faces)
        told = mesh.diagnose()
        crossing = np.unique(mesh.crossing_faces()) if crossings else np.zeros(0, dtype=int)
    coincident = told.coincident_vertices
    found = {
        "not_finite": np.flatnonzero(bad),
        "border": np.unique(np.concatenate([*told.boundary_loops, np.zeros(0, dtype=int)])),
        "non_manifold": told.non_manifold_edges,
        "pinched": told.non_manifold_vertices,
        "degenerate": told.degenerate_faces,
        "duplicate": told.duplicate_faces,
        "flipped": told.flipped_faces,
        "slit": told.slit_edges,
        "coincident": coincident[~bad[coincident]],
        "loose": told.loose_vertices,
        "crossing": crossing,
    }
    borders = len(told.boundary_loops)
    return Survey(told.component_count, borders, told.one_sided_count, told.euler_characteristic, found)


def curvature(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], rings: int) -> Curvature:
    """The curvatures of a surface, from so many rings of neighbours of each vertex."""
    native = native_module()
    with translated(native):
        measured = native.curvature(native.SurfaceMesh(points, faces), rings)
        return Curvature(measured.mean, measured.gaussian, measured.principal, measured.directions)


@dataclass(frozen=True)
class Subdivision:
    """How a mesh is refined, as Blender's Subdivision modifier says."""

    levels: int
    scheme: str
    limit: bool
    boundary_smooth: str
    creased: bool


class RefinedSurface:
    """A control mesh refined in every frame.

    ``points`` (n, 3) float64, ``faces`` (counts, corners), ``creases`` of edges and of vertices: each the
    elements and their creases from 0 to 1, float64 (k,). Cost: about 1 us per refined vertex.
    """

    def __init__(
        self,
        points: np.ndarray,
        faces: tuple[np.ndarray, np.ndarray],
        creases: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
        subdivision: Subdivision,
    ) -> None:
        self._native = native = native_module()
        used = zip(("creases", "corners"), creases if subdivision.creased else (), strict=False)
        with translated(native):
            self._surface = native.SubdivisionSurface(
                native.SurfaceMesh(points, faces),
                level=subdivision.levels,
                scheme=subdivision.scheme,
                limit=subdivision.limit,
                boundary_smooth=subdivision.boundary_smooth,
                **{name: (where, 10.0 * crease**2) for name, (where, crease) in used if len(where)},
            )
        self.control_count, self.vertex_count = self._surface.control_count, self._surface.vertex_count
        self._refined = np.empty((self.vertex_count, 3), dtype=np.float32)

    @property
    def corners(self) -> np.ndarray:
        """The vertices at the corners of the refined faces, int32 (4 faces,). The levels are above 0."""
        return self._surface.faces.ravel()

    def put_in_order(self, order: np.ndarray) -> None:
        """Let vertex k be what was vertex ``order[k]``, int32 (m,)."""
        with translated(self._native):
            self._surface = self._surface.reordered(order)

    def refine(self, points: np.ndarray) -> np.ndarray:
        """The refined points, float32 (m, 3), of control points float32 (n, 3). The next call overwrites
        them.
        """
        return self._surface.refine(np.ascontiguousarray(points, dtype=np.float32), out=self._refined)
