# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths of frames. A frame is four points (4, 3): its origin, and the ends of its three axes."""

import math
from itertools import pairwise

import numpy as np

AXES = np.concatenate((np.zeros((1, 3)), np.eye(3)))  # the frame of an object in its own space


def scale_of(frame: np.ndarray) -> float:
    """The mean length of the axes of a frame."""
    return float(np.linalg.norm(frame[1:] - frame[0], axis=1).mean())


def cut(path: np.ndarray, share: float, reach: float) -> np.ndarray:
    """A path (n + 1, 4, 3) without its first frame, as far as a ``share`` of the way: (n, 4, 3).

    A turn by an angle counts as a way of ``reach`` times the angle.
    """
    ways = [_way(before, after, reach) for before, after in pairwise(path)]
    if share >= 1.0 or not sum(ways):
        return path[1:]
    left, found = max(share, 0.0) * sum(ways), []
    for number, way in enumerate(ways):
        if left >= way:
            found.append(path[number + 1])
            left -= way
            continue
        last = between(path[number], path[number + 1], left / way)
        return np.array([*found, *[last] * (len(ways) - number)])
    return np.array(found)


def between(before: np.ndarray, after: np.ndarray, share: float) -> np.ndarray:
    """A frame between two: it has moved, turned and stretched evenly."""
    rotation, stretch = _polar(_map(before, after))
    axis, angle = _axis_and_angle(rotation)
    linear = _rotation(axis, share * angle) @ ((1.0 - share) * np.eye(3) + share * stretch)
    found = (before - before[0]) @ linear.T
    return found + (1.0 - share) * before[0] + share * after[0]


def _way(before: np.ndarray, after: np.ndarray, reach: float) -> float:
    angle = _axis_and_angle(_polar(_map(before, after))[0])[1]
    return float(np.linalg.norm(after[0] - before[0])) + reach * angle


def _map(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The linear map (3, 3) that takes the axes of one frame to those of another; that of a flat one is 1."""
    axes = (before[1:] - before[0]).T
    if abs(np.linalg.det(axes)) < 1e-30:
        return np.eye(3)
    return (after[1:] - after[0]).T @ np.linalg.inv(axes)


def _polar(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A rotation and a symmetric matrix whose product is the matrix."""
    u, _values, vt = np.linalg.svd(matrix)
    flip = np.diag((1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0))
    rotation = u @ flip @ vt
    return rotation, rotation.T @ matrix


def _axis_and_angle(rotation: np.ndarray) -> tuple[np.ndarray, float]:
    """The axis (3,) and the angle, in [0, pi]."""
    twice = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0]])
    twice = np.append(twice, rotation[1, 0] - rotation[0, 1])
    sine, cosine = 0.5 * float(np.linalg.norm(twice)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return 0.5 * twice / sine, angle
    outer = 0.5 * (rotation + np.eye(3))  # of half a turn, the axis times itself
    axis = outer[:, np.argmax(np.diag(outer))]
    length = float(np.linalg.norm(axis))
    return (axis / length if length else np.array((0.0, 0.0, 1.0))), angle if cosine < 0.0 else 0.0


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
