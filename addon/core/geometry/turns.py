# SPDX-License-Identifier: GPL-3.0-or-later
"""How points turn that are only known to move."""

import numpy as np

_LITTLE = 1e-3  # how much the turn of all points counts beside that of the edges at a point
_LEAST = 1e-9  # how much no turn at all counts, so that points on a line turn as little as they can


def turned_poses(rest: np.ndarray, posed: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """A rigid motion (n, 3, 4) per point that takes it from ``rest`` to ``posed``, (n, 3) each.

    It turns as the edges (e, 2) at the point do, by the best rotation; a little as all points do, too, which
    decides where the edges leave a turn open, and alone for a point without edges.
    """
    local, moved = rest - rest.mean(axis=0), posed - posed.mean(axis=0)
    size = max(float((local**2).sum()), 1e-300)
    everything = _nearest_rotations(moved.T @ local / size + _LEAST * np.eye(3))
    before, after = (points[edges[:, 1]] - points[edges[:, 0]] for points in (rest, posed))
    squares = (before**2).sum(axis=1)
    shares = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0.0)
    products = after[:, :, None] * (shares[:, None] * before)[:, None, :]
    together = np.tile(_LITTLE * everything, (len(rest), 1, 1))
    for end in (0, 1):
        np.add.at(together, edges[:, end], products)
    turns = _nearest_rotations(together)
    moves = posed - np.einsum("nij,nj->ni", turns, rest)
    return np.concatenate((turns, moves[:, :, None]), axis=2)


def _nearest_rotations(matrices: np.ndarray) -> np.ndarray:
    u, _values, vt = np.linalg.svd(matrices)
    u[..., 2] *= np.linalg.det(u @ vt)[..., None]
    return u @ vt
