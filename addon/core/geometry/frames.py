# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames and poses, as NumPy arrays: points are (n, 3) rows, matrices act on columns."""

from functools import lru_cache
from math import cos, pi, sin

import numpy as np

from ..errors import ConstraintError

FARTHEST = 1e18  # Blender stores an infinite coordinate as the largest float, which is farther than this


def are_valid(points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) are valid: neither NaN nor infinite, nor so far away that squares overflow."""
    return (np.abs(points) < FARTHEST).all(axis=1)


def circle(count: int) -> np.ndarray:
    """Points (count, 2) on the unit circle at equal distances, counterclockwise from (1, 0).

    Sine and cosine are those of ``math``: the last bit of those of NumPy 1 depends on where arrays lie in
    memory, so that the same call may give other bits.
    """
    return np.array([(cos(turn), sin(turn)) for turn in (2.0 * pi * k / count for k in range(count))])


def newell_normals(points: np.ndarray, counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Twice the vector area of each polygon, (m, 3). ``counts`` (m,), ``corners`` (sum of counts,)."""
    if len(counts) == 0:
        return np.zeros((0, 3))
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    edges = face_edges(counts, corners)
    return np.add.reduceat(np.cross(points[edges[:, 0]], points[edges[:, 1]]), starts, axis=0)


def face_edges(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The vertices at both ends of the edge after each corner, (c, 2), in the direction of its face."""
    ends = np.cumsum(counts)
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = ends - counts
    return np.column_stack((corners, corners[following]))


def turned_faces(
    one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]
) -> np.ndarray | None:
    """Whether each face of ``one`` is turned over in ``other``, bool (m,); None if they are other faces.

    Faces are given as the number of corners of each, and the vertices of the corners. At which of its corners
    a face begins does not count.
    """
    if not np.array_equal(one[0], other[0]) or len(one[1]) != len(other[1]):
        return None
    turned = np.zeros(len(one[0]), dtype=bool)
    if np.array_equal(one[1], other[1]):
        return turned
    faces = np.repeat(np.arange(len(turned)), one[0])
    before, after = face_edges(*one), face_edges(*other)
    sides = _in_order(np.sort(before, axis=1), faces)
    if not np.array_equal(sides, _in_order(np.sort(after, axis=1), faces)):
        return None
    differ = _in_order(before, faces) != _in_order(after, faces)
    turned[faces[differ.any(axis=1)]] = True
    return turned


def _in_order(edges: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The edges (c, 2) of each face by rising vertices. ``faces`` (c,) are their faces."""
    return edges[np.lexsort((edges[:, 1], edges[:, 0], faces))]


def region_frame(
    points: np.ndarray, counts: np.ndarray, corners: np.ndarray, members: np.ndarray
) -> np.ndarray:
    """Centre and mean normal of a region as a 4x4 rigid matrix whose z axis is the normal.

    A region that is closed, or that has no faces, has no mean normal. Then the axes are those of the object.
    """
    frame = np.eye(4)
    frame[:3, 3] = points[members].mean(axis=0)
    inside = np.zeros(len(points), dtype=bool)
    inside[members] = True
    normal = np.zeros(3)
    if len(counts):
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        whole = np.logical_and.reduceat(inside[corners], starts)
        areas = newell_normals(points, counts[whole], corners[np.repeat(whole, counts)])
        normal = areas.sum(axis=0)
        if np.linalg.norm(normal) <= 1e-3 * np.linalg.norm(areas, axis=1).sum():
            return frame
    length = np.linalg.norm(normal)
    if length > 0.0:
        frame[:3, :3] = axes_from_normal(normal / length)
    return frame


def axes_from_normal(normal: np.ndarray) -> np.ndarray:
    """A rotation whose third column is ``normal``, whose first column is as near to x, else to y, as
    possible.
    """
    toward = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    side = toward - normal * (normal @ toward)
    side /= np.linalg.norm(side)
    return np.column_stack((side, np.cross(normal, side), normal))


def not_a_number(name: str) -> str:
    """Why an object cannot be used whose matrix has NaN or infinite entries."""
    return f"{name} has a location, rotation or scale that is not a number - undo, or type another one"


def inverse(matrix: np.ndarray, name: str) -> np.ndarray:
    """The inverse of a 4x4 matrix, read-only. The error for a matrix without one names ``name``."""
    return _inverse(np.asarray(matrix, dtype=np.float64).tobytes(), name)


@lru_cache(maxsize=256)  # most matrices are the same in the next frame: rest frames, and objects that stay
def _inverse(data: bytes, name: str) -> np.ndarray:
    matrix = np.frombuffer(data).reshape(4, 4)
    if not np.isfinite(matrix).all():
        raise ConstraintError(not_a_number(name))
    linear = matrix[:3, :3]
    scale = np.prod(np.linalg.norm(linear, axis=0))
    if abs(np.linalg.det(linear)) <= 1e-9 * max(scale, 1e-30):
        raise ConstraintError(f"{name} is scaled to zero - give it a scale other than 0")
    found = np.linalg.inv(matrix)
    found.setflags(write=False)
    return found


def pose(target: np.ndarray, control: np.ndarray, rest: np.ndarray, name: str = "The control") -> np.ndarray:
    """The affine map of a handle in the target's object space, (3, 4).

    ``target`` and ``control`` are the world matrices of this moment. ``rest`` is the matrix of the control
    relative to the target, both at rest.
    """
    return (inverse(target, "The mesh object") @ control @ inverse(rest, name))[:3]


def fit(before: np.ndarray, after: np.ndarray, rigid: bool = False) -> np.ndarray:
    """The pose (3, 4) that moves the points ``before`` to ``after``, in the sense of least squares.

    The rigid motion is fitted first. Unless ``rigid``, a linear map of least norm then fits what remains, so
    that points on a plane or a line give a regular motion, too.
    """
    centre, moved = before.mean(axis=0), after.mean(axis=0)
    local, target = before - centre, after - moved
    u, _, vt = np.linalg.svd(target.T @ local)
    linear = u @ np.diag((1.0, 1.0, np.linalg.det(u @ vt))) @ vt
    if not rigid:
        turned = local @ linear.T
        linear = (np.eye(3) + np.linalg.lstsq(turned, target - turned, rcond=1e-6)[0].T) @ linear
    return np.column_stack((linear, moved - linear @ centre))


def transformed(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) moved by a 4x4 matrix."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def corners_after(matrix: np.ndarray, counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The corners of faces whose points an affine ``matrix`` moves; ``counts`` (m,), ``corners`` (sum of
    counts,). A reflection turns them, so that the faces point to the same side. They begin at the same
    corner, so that polygons are cut into the same triangles.
    """
    if np.linalg.det(matrix[:3, :3]) >= 0.0:
        return corners
    count = np.repeat(counts, counts)
    first = np.repeat(np.cumsum(counts), counts) - count
    return corners[first + (first - np.arange(len(corners))) % count]


def in_world(world: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """A rigid frame of object space as a rigid frame of the world, (4, 4).

    Its z axis stays a normal at any scale.
    """
    rigid = np.eye(4)
    rigid[:3, 3] = transformed(world, frame[None, :3, 3])[0]
    normal = inverse(world, "The mesh object")[:3, :3].T @ frame[:3, 2]
    rigid[:3, :3] = axes_from_normal(normal / np.linalg.norm(normal))
    return rigid


def radius(points: np.ndarray) -> float:
    """The distance between the mean of the points and the point farthest from it."""
    return float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
