# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in NumPy alone, as anyone may add them: steps of methods that the product does not give by themselves.

They are those of gradient editing in the tutorial's figure 15, and the first stage of implicit Laplacian
editing. They solve dense systems, so a case should have no more than a few thousand vertices.
"""

from __future__ import annotations

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
    """Figure 15 c: each triangle turned about its centre, by the turn of the second handle times a field.

    The field is harmonic: 1 on the second handle, 0 on the first. The points are those of ``apart(case)``.
    """
    field = np.zeros((len(case.points), 1))
    field[case.handles[1]] = 1.0
    share = _poisson(case, np.zeros_like(field), field)[case.triangles].mean(axis=(1, 2))
    axis, angle = _axis_and_angle(case.poses[1][:, :3])
    corners = case.points[case.triangles]
    centre = corners.mean(1, keepdims=True)
    arm = corners - centre
    turned = _turned(arm, axis, (share * angle)[:, None, None])
    return (centre + turned).reshape(-1, 3)


def apart(case: Case) -> Case:
    """The case with its triangles cut from each other."""
    corners = case.triangles.ravel()
    handles = tuple(np.flatnonzero(np.isin(corners, handle)) for handle in case.handles)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    return replace(case, points=case.points[corners], triangles=triangles, handles=handles, closed=False)


def implicit_first_stage(case: Case, substeps: int = 1) -> np.ndarray:
    """Laplacian editing with implicit transforms as they come: linear, so that they may shrink and grow.

    O. Sorkine et al., "Laplacian Surface Editing", SGP 2004, section 3. Each vertex has a scale s and a turn
    h, fitted to its ring by least squares. The sum of squares of (M^-1 L x')_i - s d_i - h x d_i is least.
    Each substep makes the matrix anew from the last shape. Only for closed meshes: a border needs more care.
    """
    shape = case.points.copy()
    for step in range(1, substeps + 1):
        target = shape.copy()
        for handle, pose in zip(case.handles, case.poses):
            axis, angle = _axis_and_angle(pose[:, :3])
            centre = case.points[handle].mean(0)
            share = step / substeps
            moved = centre + share * (pose[:, :3] @ centre + pose[:, 3] - centre)
            target[handle] = moved + _turned(case.points[handle] - centre, axis, share * angle)
        shape = _least_residual(shape, case.triangles, case.free, target)
    return shape


def _least_residual(
    points: np.ndarray, faces: np.ndarray, free: np.ndarray, target: np.ndarray
) -> np.ndarray:
    count = len(points)
    corners = points[faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    mass = sum(np.bincount(faces[:, k], area / 3.0, count) for k in range(3))
    L = cotan_laplacian(points, faces) / mass[:, None]
    delta = L @ points
    A = np.einsum("ij,ab->iajb", L, np.eye(3))
    i, j = _rings(faces, count)
    members = np.bincount(i, minlength=count)[:, None]
    arm = points[j] - (np.stack([np.bincount(i, x[j], count) for x in points.T], 1) / members)[i]
    square = np.bincount(i, (arm**2).sum(1), count)
    inertia = square[:, None, None] * np.eye(3)
    np.subtract.at(inertia, i, arm[:, :, None] * arm[:, None, :])
    turn = np.linalg.pinv(inertia, rcond=1e-9, hermitian=True)[i] @ _cross_matrix(arm)  # h = sum of turn x'
    scale = arm / square[i][:, None]  # s = sum of scale . x'
    A[i, :, j] -= delta[i][:, :, None] * scale[:, None, :] - _cross_matrix(delta[i]) @ turn
    A = (A * np.sqrt(mass)[:, None, None, None]).reshape(3 * count, 3 * count)
    open_rows = np.repeat(free, 3)
    normal, found = A.T @ A, target.ravel().copy()
    known = -normal[np.ix_(open_rows, ~open_rows)] @ found[~open_rows]
    found[open_rows] = np.linalg.solve(normal[np.ix_(open_rows, open_rows)], known)
    return found.reshape(-1, 3)


def _rings(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a vertex and a member of its ring, to which it belongs itself; (p,) each."""
    ends = np.concatenate([faces[:, [k, (k + step) % 3]] for k in range(3) for step in (1, 2)])
    itself = np.repeat(np.arange(count)[:, None], 2, axis=1)
    return tuple(np.unique(np.concatenate((ends, itself)), axis=0).T)


def _cross_matrix(v: np.ndarray) -> np.ndarray:
    """The matrices (k, 3, 3) of the cross products with vectors (k, 3)."""
    x, y, z = v.T
    none = np.zeros_like(x)
    rows = ((none, -z, y), (z, none, -x), (-y, x, none))
    return np.stack([np.stack(row, 1) for row in rows], 1)


def _axis_and_angle(turn: np.ndarray) -> tuple[np.ndarray, float]:
    """Of a rotation (3, 3) by less than half a turn."""
    axis = np.array((turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]))
    length = np.linalg.norm(axis)
    return axis / max(length, 1e-12), float(np.arctan2(length, np.trace(turn) - 1.0))


def _turned(arm: np.ndarray, axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Vectors (..., 3) about an axis, by Rodrigues."""
    c, s = np.cos(angle), np.sin(angle)
    return c * arm + s * np.cross(axis, arm) + (1.0 - c) * (arm @ axis)[..., None] * axis


def _poisson(case: Case, rest: np.ndarray, held: np.ndarray) -> np.ndarray:
    """The functions (n, k) with the gradients of ``rest``, and the values of ``held`` at the handles."""
    L, free, found = cotan_laplacian(case.points, case.triangles), np.flatnonzero(case.free), held.copy()
    known = (L @ rest)[free] - L[np.ix_(free, case.held)] @ held[case.held]
    found[free] = np.linalg.solve(L[np.ix_(free, free)], known)
    return found
