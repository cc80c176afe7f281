# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformation transfer between two meshes, through the Python module."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import grid, joined, moved, sphere, turn

POINTS, FACES = grid(8)
STOUT = POINTS * (1.0, 1.5, 1.0) + 0.1 * np.sin(POINTS)


def test_a_turn_of_the_source_turns_the_target() -> None:
    both = sn.MeshTransfer(sn.SurfaceMesh(POINTS, FACES), sn.SurfaceMesh(STOUT, FACES))
    pose = turn((1, 2, 3), 100)
    np.testing.assert_allclose(both.transfer(moved(pose, POINTS)), moved(pose, STOUT), atol=1e-11)
    bent = POINTS + np.outer(POINTS[:, 0] ** 2, (0.0, 0.0, 0.05))
    found = both.transfer(bent)
    rows = [np.linalg.norm(np.diff(shape[:9], axis=0)) for shape in (found, STOUT, bent, POINTS)]
    assert rows[0] / rows[1] == pytest.approx(rows[2] / rows[3], rel=0.02)


BALL, BALL_FACES = sphere(2)
LOOSE = np.array([(9.0, 0, 1)]), np.zeros((0, 3), int)
TWO = joined((BALL, BALL_FACES), (BALL + (3, 1, 0), BALL_FACES), LOOSE)


def test_two_parts_and_a_loose_vertex_move_as_the_source_in_their_own_size() -> None:
    points, faces = TWO
    source = sn.SurfaceMesh(points, faces)
    rest = points * (1.5, 1, 1) * np.column_stack([np.ones((len(points), 2)), 1 + 0.1 * points[:, 0]])
    deformed = moved(turn((1, 2, 3), 70), rest) + np.random.default_rng(5).uniform(-0.05, 0.05, points.shape)
    for size in (1.0, 0.4):
        both = sn.MeshTransfer(source, sn.SurfaceMesh(size * points, faces))
        np.testing.assert_allclose(both.transfer(deformed), size * deformed, rtol=0, atol=1e-11)
        step = np.array((1.0, 2, 3))
        np.testing.assert_allclose(both.transfer(points + step), size * (points + step), rtol=0, atol=1e-11)
    other, pose = sn.MeshTransfer(source, sn.SurfaceMesh(rest, faces)), turn((1, -3, 2), 130)
    np.testing.assert_allclose(other.transfer(points), rest, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.transfer(moved(pose, points)), moved(pose, rest), rtol=0, atol=1e-11)


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
