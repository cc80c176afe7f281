# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a surface reaches from a selection, and the part of a mesh that such a reach needs.

Polygons are ``counts`` (m,) and ``corners`` (sum of counts,), as in ``frames``; masks are bool (n,).
"""

import numpy as np

_CLOSE = 1e-3  # a way that is shorter by less than this share changes nothing that one could see


def triangulated(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Each polygon as a fan, (t, 3)."""
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])) if len(counts) else np.zeros(0, dtype=int)
    fans = np.maximum(counts - 2, 0)
    polygon = np.repeat(np.arange(len(counts)), fans)
    number = np.arange(len(polygon)) - np.repeat(np.cumsum(fans) - fans, fans)
    first = starts[polygon]
    return np.column_stack((corners[first], corners[first + number + 1], corners[first + number + 2]))


def _rows(starts: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Positions of all entries of the chosen rows of a compressed table."""
    lengths = starts[chosen + 1] - starts[chosen]
    shift = np.repeat(starts[chosen] - (np.cumsum(lengths) - lengths), lengths)
    return np.arange(len(shift)) + shift


class Surface:
    """The triangles of a mesh, and which of them each vertex knows."""

    def __init__(self, size: int, counts: np.ndarray, corners: np.ndarray) -> None:
        self._triangles = triangulated(counts, corners)
        flat = self._triangles.ravel()
        self._starts = np.concatenate(([0], np.cumsum(np.bincount(flat, minlength=size))))
        self._known = np.argsort(flat, kind="stable") // 3

    def _around(self, vertices: np.ndarray) -> np.ndarray:
        """The triangles (t, 3) that name some of these vertices."""
        return self._triangles[np.unique(self._known[_rows(self._starts, vertices)])]

    def connected(self, sources: np.ndarray, barred: np.ndarray) -> np.ndarray:
        """What one comes to from the sources without setting foot on ``barred``: a mask."""
        reached = sources & ~barred
        front = np.flatnonzero(reached)
        while len(front):
            met = np.unique(self._around(front))
            front = met[~reached[met] & ~barred[met]]
            reached[front] = True
        return reached

    def lengths(
        self, points: np.ndarray, sources: np.ndarray, barred: np.ndarray, limit: float
    ) -> np.ndarray:
        """The shortest ways over the surface from the sources, (n,), infinite beyond ``limit``.

        ``points`` (n, 3). Two known corners give the third by unfolding the triangle into the plane of the
        source (Kimmel & Sethian 1998); the front walks on while anything becomes shorter. In a plane that is
        exact but for the first ring, which takes a row of sources for a curved one.
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
            way = _unfolded(points[corner], points[sides], found[sides])
            better = (way <= limit) & (way < found[corner] * (1.0 - _CLOSE))
            corner, way = corner[better], way[better]
            order = np.argsort(-way, kind="stable")  # of several ways to a corner the shortest comes last
            found[corner[order]] = way[order]
            front = np.unique(corner)
        return found


def _unfolded(points: np.ndarray, sides: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Lengths (k,) at ``points`` (k, 3) across from the sides (k, 2, 3) whose ends have lengths (k, 2)."""
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


def met(counts: np.ndarray, corners: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Which faces have a corner inside: a mask (m,)."""
    faces = np.zeros(len(counts), dtype=bool)
    faces[np.repeat(np.arange(len(counts)), counts)[inside[corners]]] = True
    return faces


def surrounded(counts: np.ndarray, corners: np.ndarray, inside: np.ndarray, rings: int) -> np.ndarray:
    """The mask with ``rings`` more rings of vertices, as faces connect them."""
    for _ in range(rings):
        ring = corners[np.repeat(met(counts, corners, inside), counts)]
        inside = inside.copy()
        inside[ring] = True
    return inside


def part(
    counts: np.ndarray, corners: np.ndarray, inside: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Indices (k,) of the vertices inside, and the faces between them, by their place among those indices."""
    members = np.flatnonzero(inside)
    place = np.full(len(inside), -1, dtype=np.int32)
    place[members] = np.arange(len(members), dtype=np.int32)
    if len(counts) == 0:
        return members, (counts, corners)
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    whole = np.logical_and.reduceat(inside[corners], starts)
    return members, (counts[whole], place[corners[np.repeat(whole, counts)]])
