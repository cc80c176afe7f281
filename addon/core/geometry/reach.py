# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances along a surface from a selection, and the part of a mesh that lies within a distance.

Polygons are ``counts`` (m,) and ``corners`` (sum of counts,), as in ``frames``; masks are bool (n,).
"""

import numpy as np

_MINIMAL_GAIN = 1e-3  # a path that is shorter by less than this share makes no visible difference


def triangulated(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The polygons divided into triangles (t, 3) around their first corners."""
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])) if len(counts) else np.zeros(0, dtype=int)
    fans = np.maximum(counts - 2, 0)
    polygon = np.repeat(np.arange(len(counts)), fans)
    number = np.arange(len(polygon)) - np.repeat(np.cumsum(fans) - fans, fans)
    first = starts[polygon]
    return np.column_stack((corners[first], corners[first + number + 1], corners[first + number + 2]))


def _rows(starts: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The positions of all entries in the chosen rows of a compressed sparse table."""
    lengths = starts[chosen + 1] - starts[chosen]
    shift = np.repeat(starts[chosen] - (np.cumsum(lengths) - lengths), lengths)
    return np.arange(len(shift)) + shift


class TriangleMesh:
    """The triangles of a mesh, and the triangles around each vertex."""

    def __init__(self, size: int, counts: np.ndarray, corners: np.ndarray) -> None:
        self._triangles = triangulated(counts, corners)
        flat = self._triangles.ravel()
        self._starts = np.concatenate(([0], np.cumsum(np.bincount(flat, minlength=size))))
        self._triangles_of = np.argsort(flat, kind="stable") // 3

    def _around(self, vertices: np.ndarray) -> np.ndarray:
        """The triangles (t, 3) that have one of these vertices as a corner."""
        return self._triangles[np.unique(self._triangles_of[_rows(self._starts, vertices)])]

    def connected(self, sources: np.ndarray, barred: np.ndarray) -> np.ndarray:
        """Mask of the vertices that are connected to ``sources`` without crossing ``barred``."""
        reached = sources & ~barred
        front = np.flatnonzero(reached)
        while len(front):
            neighbours = np.unique(self._around(front))
            front = neighbours[~reached[neighbours] & ~barred[neighbours]]
            reached[front] = True
        return reached

    def lengths(
        self, points: np.ndarray, sources: np.ndarray, barred: np.ndarray, limit: float
    ) -> np.ndarray:
        """The lengths of the shortest paths over the surface from the sources, (n,); infinite beyond
        ``limit``.

        ``points`` (n, 3). The lengths at two corners give the length at the third: the triangle is unfolded
        into the plane of the source (Kimmel & Sethian 1998). This repeats while any length becomes shorter.
        On a plane the lengths are exact, except in the first ring around several sources, which treats a
        straight row of sources as a curved one.
        """
        found = np.full(len(points), np.inf)
        found[sources & ~barred] = 0.0
        front = np.flatnonzero(found == 0.0)
        while len(front):
            near = self._around(front)
            corner = np.concatenate((near[:, 0], near[:, 1], near[:, 2]))
            sides = np.concatenate((near[:, (1, 2)], near[:, (2, 0)], near[:, (0, 1)]))
            behind = (found[corner] > found[sides].min(axis=1)) & ~barred[corner]
            corner, sides = corner[behind], sides[behind]
            length = _unfolded(points[corner], points[sides], found[sides])
            better = (length <= limit) & (length < found[corner] * (1.0 - _MINIMAL_GAIN))
            corner, length = corner[better], length[better]
            # The last assignment to a corner wins, so the shortest path to it comes last.
            order = np.argsort(-length, kind="stable")
            found[corner[order]] = length[order]
            front = np.unique(corner)
        return found


def _unfolded(points: np.ndarray, sides: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Lengths (k,) at ``points`` (k, 3), which lie opposite to the sides (k, 2, 3).

    ``known`` (k, 2) are the lengths at the ends of the sides.
    """
    along, out = sides[:, 1] - sides[:, 0], points - sides[:, 0]
    by_edge = np.minimum(
        known[:, 0] + np.linalg.norm(out, axis=1), known[:, 1] + np.linalg.norm(points - sides[:, 1], axis=1)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        side = np.linalg.norm(along, axis=1)
        x = (out * along).sum(axis=1) / side
        y = np.sqrt(np.maximum((out**2).sum(axis=1) - x**2, 0.0))
        source_x = (known[:, 0] ** 2 - known[:, 1] ** 2 + side**2) / (2.0 * side)
        depth_squared = known[:, 0] ** 2 - source_x**2
        depth = np.sqrt(depth_squared)
        crossing = source_x + (x - source_x) * depth / (depth + y)
        straight = np.hypot(x - source_x, y + depth)
        usable = (depth_squared >= 0.0) & (crossing >= 0.0) & (crossing <= side) & np.isfinite(straight)
    return np.where(usable, np.minimum(straight, by_edge), by_edge)


def touching_faces(counts: np.ndarray, corners: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Mask (m,) of the faces with at least one corner in the mask ``inside``."""
    faces = np.zeros(len(counts), dtype=bool)
    faces[np.repeat(np.arange(len(counts)), counts)[inside[corners]]] = True
    return faces


def with_rings(counts: np.ndarray, corners: np.ndarray, inside: np.ndarray, rings: int) -> np.ndarray:
    """The mask ``inside``, grown by ``rings`` rings of vertices that faces connect to it."""
    for _ in range(rings):
        ring = corners[np.repeat(touching_faces(counts, corners, inside), counts)]
        inside = inside.copy()
        inside[ring] = True
    return inside


def submesh(
    counts: np.ndarray, corners: np.ndarray, inside: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The vertices in the mask ``inside`` as indices (k,), and the faces between them.

    The corners of these faces count among the k vertices.
    """
    members = np.flatnonzero(inside)
    place = np.full(len(inside), -1, dtype=np.int32)
    place[members] = np.arange(len(members), dtype=np.int32)
    if len(counts) == 0:
        return members, (counts, corners)
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    whole = np.logical_and.reduceat(inside[corners], starts)
    return members, (counts[whole], place[corners[np.repeat(whole, counts)]])
