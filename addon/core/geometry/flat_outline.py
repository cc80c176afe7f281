# SPDX-License-Identifier: GPL-3.0-or-later
"""An outline around points in a plane, to make a flat cage."""

import numpy as np

from . import frames

_FLATNESS = 1e-5  # of the size; coordinates have single precision
_NARROW = 1e-3  # points on a line are no flat shape
_DIRECTIONS = 32  # in which the outline keeps its distance
_TRIANGLES_PER_CORNER = 12  # an outline is posed with fewer vertices than a closed cage


def plane(points: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """The middle (3,) and the axes (3, 3) of the plane of points (n, 3), with the normal last.

    None if they lie in no plane, or on a line. Of the axes of the object, the two that are closest to the
    plane become those in the plane, so a shape that is symmetric along one of them gets a symmetric outline.
    """
    if len(points) < 3:
        return None
    middle = (points.min(0) + points.max(0)) / 2
    _, extents, axes = np.linalg.svd(points - points.mean(0), full_matrices=False)
    if not extents[1] > _NARROW * extents[0]:
        return None
    normal = axes[2]
    upright = int(np.abs(normal).argmax())
    normal = normal * np.sign(normal[upright])
    heights = (points - middle) @ normal
    if not np.ptp(heights) <= _FLATNESS * np.linalg.norm(np.ptp(points, axis=0)):
        return None
    first = np.eye(3)[(upright + 1) % 3]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return middle + heights.mean() * normal, np.stack((first, np.cross(normal, first), normal))


def around(points: np.ndarray, margin: float, triangles: int) -> np.ndarray | None:
    """The corners (k, 3) of a convex polygon around points (n, 3) of a plane; None if they lie in none.

    It keeps a distance of ``margin`` times the size of the points. ``triangles`` is how many a closed cage
    would have; an outline has a twelfth as many corners, spread along its sides.
    """
    found = plane(points)
    if found is None:
        return None
    middle, axes = found
    flat = (points - middle) @ axes[:2].T
    directions = frames.circle(_DIRECTIONS)
    reach = margin * float(np.linalg.norm(np.ptp(flat, axis=0)))
    far = (flat @ directions.T).max(0) + reach
    corners = _corners(directions, far, 1e-3 * reach)
    corners = _divided(corners, max(4, triangles // _TRIANGLES_PER_CORNER))
    return middle + corners @ axes[:2]


def _corners(directions: np.ndarray, far: np.ndarray, least: float) -> np.ndarray:
    """The corners of the polygon whose sides have these normals and distances, in counter-clockwise order."""
    following, beyond = np.roll(directions, -1, axis=0), np.roll(far, -1)
    turn = directions[:, 0] * following[:, 1] - directions[:, 1] * following[:, 0]
    crossings = np.stack(
        (
            (far * following[:, 1] - beyond * directions[:, 1]) / turn,
            (beyond * directions[:, 0] - far * following[:, 0]) / turn,
        ),
        1,
    )
    apart = np.linalg.norm(crossings - np.roll(crossings, 1, axis=0), axis=1) > least
    return crossings[apart]


def _divided(corners: np.ndarray, wanted: int) -> np.ndarray:
    """The polygon with points along its sides, so that there are about ``wanted``; its corners stay."""
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    parts = np.maximum(1, np.round(lengths / (lengths.sum() / wanted)).astype(int))
    return np.concatenate(
        [
            corner + np.arange(count)[:, None] / count * side
            for corner, side, count in zip(corners, sides, parts)
        ]
    )
