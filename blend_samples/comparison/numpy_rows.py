# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in NumPy alone, as anyone may add them: steps of methods that the product does not give by themselves.

They are those of gradient editing in the tutorial's figure 15. They solve dense systems, so a case should
have no more than a few thousand vertices.
"""

from dataclasses import replace

import numpy as np

from .cases import Case


def cotan_laplacian(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The dense Laplacian (n, n), positive semi-definite and not divided by areas."""
    L = np.zeros((len(points), len(points)))
    for k in range(3):
        corner, i, j = (faces[:, (k + step) % 3] for step in range(3))
        u, v = points[i] - points[corner], points[j] - points[corner]
        weight = 0.5 * (u * v).sum(1) / np.linalg.norm(np.cross(u, v), axis=1)
        for a, b, sign in ((i, j, -1), (j, i, -1), (i, i, 1), (j, j, 1)):
            np.add.at(L, (a, b), sign * weight)
    return L


def unrotated_gradients(case: Case) -> np.ndarray:
    """Figure 15 b: the gradients at rest with new places of the handles, L x' = L x, Eq. 15 with T = I."""
    return _poisson(case, case.points, case.targets)


def turned_triangles(case: Case) -> np.ndarray:
    """Figure 15 c: each triangle turned about its centre, by the turn of the second handle times a field. The
    field is harmonic: 1 on the second handle, 0 on the first. The points are those of ``apart(case)``."""
    field = np.zeros((len(case.points), 1))
    field[case.handles[1]] = 1.0
    share = _poisson(case, np.zeros_like(field), field)[case.triangles].mean(axis=(1, 2))
    axis, angle = axis_and_angle(case.poses[1][:, :3])
    corners = case.points[case.triangles]
    centre = corners.mean(1, keepdims=True)
    arm = corners - centre
    places = centre + turned(arm, axis, (share * angle)[:, None, None])
    return places.reshape(-1, 3)


def apart(case: Case) -> Case:
    """The case with its triangles cut from each other."""
    corners = case.triangles.ravel()
    handles = tuple(np.flatnonzero(np.isin(corners, handle)) for handle in case.handles)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    return replace(case, points=case.points[corners], triangles=triangles, handles=handles, closed=False)


def axis_and_angle(turn: np.ndarray) -> tuple[np.ndarray, float]:
    """Of a rotation (3, 3) by less than half a turn."""
    axis = np.array((turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]))
    length = np.linalg.norm(axis)
    return axis / max(length, 1e-12), float(np.arctan2(length, np.trace(turn) - 1.0))


def turned(arm: np.ndarray, axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Vectors (..., 3) about an axis, by Rodrigues."""
    c, s = np.cos(angle), np.sin(angle)
    return c * arm + s * np.cross(axis, arm) + (1.0 - c) * (arm @ axis)[..., None] * axis


def _poisson(case: Case, rest: np.ndarray, held: np.ndarray) -> np.ndarray:
    """The functions (n, k) with the gradients of ``rest``, and the values of ``held`` at the handles."""
    L, free, found = cotan_laplacian(case.points, case.triangles), np.flatnonzero(case.free), held.copy()
    known = (L @ rest)[free] - L[np.ix_(free, case.held)] @ held[case.held]
    found[free] = np.linalg.solve(L[np.ix_(free, free)], known)
    return found
