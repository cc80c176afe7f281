# SPDX-License-Identifier: GPL-3.0-or-later
"""Points that lie on a surface, carried along while the surface takes another shape.

Modifiers give renders other vertices than viewports, and both lie on the same surface. So where one set of
them is known at rest, or posed, the other follows from it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mathutils.bvhtree import BVHTree

_NO_EDGES = np.zeros((0, 2), dtype=np.int32)


@dataclass(frozen=True)
class Surface:
    """One shape of a mesh: ``points`` (n, 3), ``triangles`` (t, 3), and ``edges`` (e, 2)."""

    points: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray

    @cached_property
    def normals(self) -> np.ndarray:
        """The normals of the vertices (n, 3); zero where there are no faces."""
        corners = self.points[self.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        found = np.zeros_like(self.points)
        for corner in range(3):
            np.add.at(found, self.triangles[:, corner], across)
        return _unit(found)

    def curved(self, corners: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Places (k, 3) at ``shares`` (k, 3) of three ``corners`` (k, 3), on a smooth surface through them.

        It lies half-way between the triangle and its projections onto the tangent planes at the corners
        (Boubekeur & Alexa 2008, Phong tessellation), which is exact for quadratic surfaces.
        """
        flat = (shares[:, :, None] * self.points[corners]).sum(axis=1)
        normals = self.normals[corners]
        heights = ((flat[:, None] - self.points[corners]) * normals).sum(axis=2)
        return flat - 0.5 * ((shares * heights)[:, :, None] * normals).sum(axis=1)

    def frames(self, corners: np.ndarray) -> np.ndarray:
        """An orthonormal frame (k, 3, 3) of each triangle: along its first side, across, and upwards."""
        first, second, third = (self.points[corners[:, i]] for i in range(3))
        along = _unit(second - first)
        upwards = _unit(np.cross(along, third - first))
        return np.stack((along, np.cross(upwards, along), upwards), axis=1)


class AttachedPoints:
    """Points (k, 3) that lie on or beside a surface, each in the frame of the place that is nearest to it."""

    def __init__(self, points: np.ndarray, surface: Surface) -> None:
        self.count = len(surface.points)
        self._triangles = surface.triangles
        if len(surface.triangles):
            self._corners, self._shares = _on_triangles(points, surface)
        else:
            self._corners, self._shares = _on_edges(points, surface)
        away = points - surface.curved(self._corners, self._shares)
        if not self._is_loose:
            away = np.einsum("kij,kj->ki", surface.frames(self._corners), away)
        self._beside = away

    @property
    def _is_loose(self) -> bool:
        """Whether there are no faces, so that points keep their way to the nearest place of an edge."""
        return not len(self._triangles)

    def blended(self, values: np.ndarray) -> np.ndarray:
        """The values (k,) at the places where they ride, from those of the vertices of the surface, (n,)."""
        return (self._shares * values[self._corners]).sum(axis=1)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Where they are carried to by the surface with its vertices at ``points`` (n, 3)."""
        surface = Surface(points.astype(np.float64), self._triangles, _NO_EDGES)
        found = surface.curved(self._corners, self._shares)
        if self._is_loose:
            return found + self._beside
        return found + np.einsum("kji,kj->ki", surface.frames(self._corners), self._beside)


def _on_triangles(points: np.ndarray, surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """The corners (k, 3) of the triangle nearest to each point, and the shares (k, 3) of the place there."""
    tree = BVHTree.FromPolygons(surface.points.tolist(), surface.triangles.tolist(), all_triangles=True)
    met = [tree.find_nearest(point) for point in points.tolist()]
    corners = surface.triangles[[0 if index is None else index for _place, _normal, index, _way in met]]
    places = np.array(
        [point if place is None else place for point, (place, *_) in zip(points, met, strict=True)]
    )
    first, second, third = (surface.points[corners[:, i]] for i in range(3))
    a, b, c = second - first, third - first, places - first
    aa, ab, bb, ac, bc = ((x * y).sum(axis=1) for x, y in ((a, a), (a, b), (b, b), (a, c), (b, c)))
    area = aa * bb - ab * ab
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = (bb * ac - ab * bc) / area, (aa * bc - ab * ac) / area
    shares = np.stack((1.0 - v - w, v, w), axis=1)
    shares[~np.isfinite(shares).all(axis=1)] = 1.0 / 3.0  # a triangle without an area
    return corners, shares


def _on_edges(points: np.ndarray, surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """The same for the nearest edge, or the nearest vertex where there are no edges."""
    alone = np.repeat(np.arange(len(surface.points))[:, None], 2, axis=1)
    ends = surface.edges if len(surface.edges) else alone
    first, along = surface.points[ends[:, 0]], surface.points[ends[:, 1]] - surface.points[ends[:, 0]]
    squares = (along**2).sum(axis=1)
    corners, shares = np.empty((len(points), 3), dtype=np.intp), np.zeros((len(points), 3))
    for row, point in enumerate(points):
        ways = ((point - first) * along).sum(axis=1) / np.where(squares > 0.0, squares, 1.0)
        ways = np.clip(ways, 0.0, 1.0)
        edge = int(((point - first - ways[:, None] * along) ** 2).sum(axis=1).argmin())
        corners[row] = ends[edge, 0], ends[edge, 1], ends[edge, 1]
        shares[row, :2] = 1.0 - ways[edge], ways[edge]
    return corners, shares


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
