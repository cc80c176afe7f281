# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformation transfer between two meshes, through the Python module."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import grid, moved, turn

POINTS, FACES = grid(8)
STOUT = POINTS * (1.0, 1.5, 1.0) + 0.1 * np.sin(POINTS)


def test_a_turn_of_the_source_turns_the_target() -> None:
    both = sn.MeshTransfer(sn.SurfaceMesh(POINTS, FACES), sn.SurfaceMesh(STOUT, FACES))
    pose = turn((1, 2, 3), 100)
    np.testing.assert_allclose(both.transfer(moved(pose, POINTS)), moved(pose, STOUT), atol=1e-11)
    bent = POINTS + np.outer(POINTS[:, 0] ** 2, (0.0, 0.0, 0.05))
    found = both.transfer(bent)
    edges = [(STOUT, found), (POINTS, bent)]
    stretch = [
        np.linalg.norm(np.diff(after[:9], axis=0)) / np.linalg.norm(np.diff(before[:9], axis=0))
        for before, after in edges
    ]
    assert stretch[0] == pytest.approx(stretch[1], rel=0.02)


def test_what_does_not_fit_is_refused() -> None:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    other = FACES.copy()
    other[5] = other[5][::-1]
    with pytest.raises(sn.InvalidMesh, match=r"faces of the target .*: 5") as refused:
        sn.MeshTransfer(mesh, sn.SurfaceMesh(POINTS, other))
    assert (refused.value.elements, refused.value.element_kind) == ([5], "face")
    with pytest.raises(sn.InvalidMesh, match="vertices, and the target"):
        sn.MeshTransfer(mesh, sn.SurfaceMesh(*grid(9)))
    same = sn.MeshTransfer(mesh, mesh)
    for wrong in (POINTS[1:], POINTS[:, :2], np.full_like(POINTS, np.nan)):
        with pytest.raises(sn.InvalidConstraint, match="source"):
            same.transfer(wrong)
