# SPDX-License-Identifier: GPL-3.0-or-later
"""How a piece of a surface has moved as a whole: what carries something that stands on it."""

import numpy as np

from . import frames, reach

_THIN = 1e-3  # points on a line, within this share of its length, do not tell how they turn about it
_MOST_RINGS = 3


def piece(points: np.ndarray, counts: np.ndarray, corners: np.ndarray, members: np.ndarray) -> np.ndarray:
    """The vertices that tell how ``members`` move: these, or if they lie on a line with some around them."""
    for _ring in range(_MOST_RINGS):
        if not len(members) or not len(counts) or not is_line(points[members]):
            break
        inside = np.zeros(len(points), dtype=bool)
        inside[members] = True
        members = np.flatnonzero(reach.with_rings(counts, corners, inside, 1))
    return members


def is_line(points: np.ndarray) -> bool:
    """Whether points (k, 3) lie on a line, or at one place."""
    if len(points) < 3:
        return True
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] <= _THIN * values[0])


def motion(before: np.ndarray, after: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """How points (k, 3) have moved, (4, 4): rigid in the world, to which ``linear`` (3, 3) takes them.

    Points on a line do not turn. Nothing moves where the points are not finite.
    """
    found = np.eye(4)
    if not len(before) or not frames.are_valid(after).all() or not frames.are_valid(before).all():
        return found
    back = np.linalg.inv(linear)
    before, after = before @ linear.T, after.astype(np.float64) @ linear.T
    if is_line(before):
        found[:3, 3] = back @ (after - before).mean(axis=0)
    else:
        rigid = frames.fit(before, after, rigid=True)
        found[:3] = np.column_stack((back @ rigid[:, :3] @ linear, back @ rigid[:, 3]))
    return found
