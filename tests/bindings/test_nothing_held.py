# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that hold nothing, everything, or almost nothing, on meshes of any size. No method is named."""

import numpy as np
import pytest

import sinew_native as sn

from .meshes import STILL, grid, shift
from .methods import EVERY_SURFACE_METHOD, called, made

SIZES = (1, 5, 15, 16, 20, 45)  # 4 to 2,116 vertices


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)
def test_what_nobody_holds_stays(method: type, options: dict, size: int) -> None:
    points, faces = grid(size)
    surface = made(method, sn.SurfaceMesh(points, faces), **options)
    move = shift(1, 2, 3)
    for handles, weights in (([], None), ([[0, 1], [3]], [0.0, 0.0]), ([range(len(points))], [0.0])):
        report = surface.set_handles(handles, weights)
        assert (report.free_parts, len(report.free_vertices)) == (1, len(points))
        poses = np.repeat(move[None], len(handles), 0).reshape(-1, 3, 4)
        np.testing.assert_array_equal(surface.solve(poses)[0], points)
        np.testing.assert_array_equal(surface.solve(poses, incoming=2 * points)[0], 2 * points)
    surface.set_handles([range(len(points))])
    np.testing.assert_allclose(surface.solve([move])[0], points + move[:, 3], atol=1e-12)
    surface.set_handles([[0]])
    np.testing.assert_allclose(surface.solve([move])[0], points + move[:, 3], atol=1e-5 * size)


def test_an_affine_basis_needs_handles() -> None:
    shell = sn.ThinShell(sn.SurfaceMesh(*grid(4)))
    with pytest.raises(sn.InvalidConstraint, match=r"call set_handles\(\) first"):
        sn.AffineBasis(shell)
    shell.set_handles([])
    assert sn.AffineBasis(shell).matrix.shape == (25, 0)


@pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)
def test_a_bind_without_handles_may_follow_one_with_handles(method: type, options: dict) -> None:
    points, faces = grid(20)
    surface = made(method, sn.SurfaceMesh(points, faces), **options)
    surface.set_handles([[0, 1], [440]])
    surface.set_handles([])
    np.testing.assert_array_equal(surface.solve([])[0], points)
    surface.set_handles([[0, 1], [440]])
    np.testing.assert_allclose(surface.solve([STILL, STILL])[0], points, atol=1e-9)
