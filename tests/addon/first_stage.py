# SPDX-License-Identifier: GPL-3.0-or-later
"""The first stage of implicit Laplacian editing in NumPy, which shares no code with ours."""

import numpy as np

from blend_samples.comparison import Case
from blend_samples.comparison.numpy_rows import axis_and_angle, cotan_laplacian, turned


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
            axis, angle = axis_and_angle(pose[:, :3])
            centre = case.points[handle].mean(0)
            share = step / substeps
            moved = centre + share * (pose[:, :3] @ centre + pose[:, 3] - centre)
            target[handle] = moved + turned(case.points[handle] - centre, axis, share * angle)
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
