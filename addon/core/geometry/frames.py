# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames and poses, as NumPy arrays: points are (n, 3) rows, matrices act on columns."""

from functools import lru_cache

import numpy as np

from ..errors import ConstraintError

FARTHEST = 1e18  # Blender keeps an infinite coordinate as the largest float


def is_place(points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) lie somewhere: not NaN, not infinite, not so far that squares overflow."""
    return (np.abs(points) < FARTHEST).all(axis=1)


def newell_normals(points: np.ndarray, counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Twice the vector area of each polygon, (m, 3). ``counts`` (m,), ``corners`` (sum of counts,)."""
    if len(counts) == 0:
        return np.zeros((0, 3))
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    following = np.arange(1, len(corners) + 1)
    following[starts + counts - 1] = starts
    return np.add.reduceat(np.cross(points[corners], points[corners[following]]), starts, axis=0)


def region_frame(
    points: np.ndarray, counts: np.ndarray, corners: np.ndarray, members: np.ndarray
) -> np.ndarray:
    """Centre and mean normal of a region as a 4x4 rigid matrix whose z axis is the normal.

    A closed or flat-less region has no mean normal: then the axes are the object's.
    """
    frame = np.eye(4)
    frame[:3, 3] = points[members].mean(axis=0)
    inside = np.zeros(len(points), dtype=bool)
    inside[members] = True
    normal = np.zeros(3)
    if len(counts):
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        whole = np.logical_and.reduceat(inside[corners], starts)
        areas = newell_normals(points, counts, corners)[whole]
        normal = areas.sum(axis=0)
        if np.linalg.norm(normal) <= 1e-3 * np.linalg.norm(areas, axis=1).sum():
            return frame
    length = np.linalg.norm(normal)
    if length > 0.0:
        frame[:3, :3] = axes_from_normal(normal / length)
    return frame


def axes_from_normal(normal: np.ndarray) -> np.ndarray:
    """A rotation whose third column is ``normal``, its first as near to x (else y) as can be."""
    toward = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    side = toward - normal * (normal @ toward)
    side /= np.linalg.norm(side)
    return np.column_stack((side, np.cross(normal, side), normal))


def inverse(matrix: np.ndarray, whose: str) -> np.ndarray:
    """The inverse of a 4x4 matrix, read-only; a flattened object is refused by name."""
    return _inverse(np.asarray(matrix, dtype=np.float64).tobytes(), whose)


@lru_cache(maxsize=256)  # rest frames, and objects at rest: most matrices come again in the next frame
def _inverse(data: bytes, whose: str) -> np.ndarray:
    matrix = np.frombuffer(data).reshape(4, 4)
    linear = matrix[:3, :3]
    scale = np.prod(np.linalg.norm(linear, axis=0))
    if not np.isfinite(matrix).all() or abs(np.linalg.det(linear)) <= 1e-9 * max(scale, 1e-30):
        raise ConstraintError(f"{whose} is scaled to zero - give it a scale other than 0")
    found = np.linalg.inv(matrix)
    found.setflags(write=False)
    return found


def pose(target: np.ndarray, control: np.ndarray, rest: np.ndarray, whose: str = "The control") -> np.ndarray:
    """The affine map of a handle in the target's object space, (3, 4).

    ``target`` and ``control`` are world matrices now, ``rest`` the control's matrix relative to the target
    at rest.
    """
    return (inverse(target, "The mesh object") @ control @ inverse(rest, whose))[:3]


def fit(before: np.ndarray, after: np.ndarray, rigid: bool = False) -> np.ndarray:
    """The pose (3, 4) that moves ``before`` to ``after`` with least squares.

    The rigid part is fitted first. Unless ``rigid``, the rest is fitted by a linear map of least norm, so
    that points on a plane or a line give a proper motion too.
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


def placed(world: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """A rigid frame of object space in the world, (4, 4): its z stays the normal under any scale."""
    rigid = np.eye(4)
    rigid[:3, 3] = transformed(world, frame[None, :3, 3])[0]
    normal = inverse(world, "The mesh object")[:3, :3].T @ frame[:3, 2]
    rigid[:3, :3] = axes_from_normal(normal / np.linalg.norm(normal))
    return rigid


def radius(points: np.ndarray) -> float:
    """The distance of the farthest point from the mean."""
    return float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
