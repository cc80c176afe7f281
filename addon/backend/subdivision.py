# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that the native module refines in every frame."""

from dataclasses import dataclass

import numpy as np

from .native import _module as native_module, _translated as translated


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
