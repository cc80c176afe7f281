# SPDX-License-Identifier: GPL-3.0-or-later
"""A handle that holds its vertices almost fully moves the surface almost as one that holds them fully."""

import numpy as np
import pytest

import sinew_native as sn

from .meshes import STILL, sphere, turn

METHODS = [
    sn.Arap,
    sn.ThinShell,
    sn.ThinShellNonlinear,
    sn.Primo,
    sn.MeshPuppetry,
    sn.SubspaceLaplacian,
    sn.HandleAwareIsolines,
    sn.LaplacianEditing,
    sn.GradientEditing,
]


@pytest.mark.parametrize("method", METHODS)
def test_weights_near_one_are_nearly_one(method: type) -> None:
    points, faces = sphere(4)
    points = points * (3, 1, 1)
    handles = [np.flatnonzero(points[:, 0] < -2.2), np.flatnonzero(points[:, 0] > 2.2)]
    poses = [STILL, turn((0, 0, 1), 60, move=(-0.5, 0.8, 0.0))]
    made = method(sn.SurfaceMesh(points, faces))
    shapes = []
    for weight in (1.0, 0.999, 1.0 - 1e-5, 1.0 - 1e-9):
        made.set_handles(handles, [np.ones(len(handles[0])), np.full(len(handles[1]), weight)])
        shapes.append(made.solve(poses)[0])
    off = [np.linalg.norm(shape - shapes[0], axis=1).max() / 6.0 for shape in shapes[1:]]
    print(f"{method.__name__}: off by {', '.join(f'{share:.1e}' for share in off)} of the size")
    assert max(off) < 0.013
