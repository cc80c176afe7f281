# SPDX-License-Identifier: GPL-3.0-or-later
"""Substeps of all surface methods, and handles that hold almost fully, which move it almost as hard ones."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import BENT, STILL, ends, grid, moved, off, sphere, turn
from ..methods import EVERY_SURFACE_METHOD, SURFACE_METHODS, called, made

POINTS, FACES = grid(8)
EVERY = pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)


def bound(method: type, options: dict[str, object]) -> sn.SurfaceMethod:
    surface = made(method, sn.SurfaceMesh(POINTS, FACES), **options)
    surface.set_handles(ends(POINTS))
    return surface


@EVERY
def test_substeps_keep_rest_and_handles(method: type, options: dict[str, object]) -> None:
    surface = bound(method, options)
    still, _ = surface.solve(np.stack([STILL, STILL]), substeps=3)
    np.testing.assert_allclose(still, POINTS, atol=1e-9)
    entering = POINTS + (1, 2, 3)
    still, _ = surface.solve(np.stack([STILL, STILL]), incoming=entering, substeps=3)
    np.testing.assert_allclose(still, entering, atol=1e-9)
    positions, report = surface.solve(BENT, substeps=3)
    assert report.converged
    assert np.isfinite(positions).all()
    for pose, handle in zip(BENT, ends(POINTS), strict=True):
        np.testing.assert_allclose(positions[handle], moved(pose, POINTS[handle]), atol=1e-10)
    np.testing.assert_array_equal(positions, surface.solve(BENT, substeps=3)[0])


@EVERY
def test_substeps_change_the_shape_only_where_they_can(method: type, options: dict[str, object]) -> None:
    surface = bound(method, options)
    once, more = surface.solve(BENT)[0], surface.solve(BENT, substeps=4)[0]
    transforms = options.get("transforms", "estimated") if method is sn.LaplacianEditing else "explicit"
    # The base of Multiresolution is a thin shell here.
    if method in (sn.ThinShell, sn.Multiresolution) or transforms != "explicit":
        assert np.abs(more - once).max() > 1e-3
    else:
        np.testing.assert_array_equal(more, once)


def test_what_makes_no_sense_is_refused() -> None:
    shell = bound(sn.ThinShell, {})
    with pytest.raises(sn.InvalidOption, match="substeps"):
        shell.solve(BENT, substeps=0)
    mirror = np.column_stack([-np.eye(3), np.zeros(3)])
    with pytest.raises(sn.InvalidConstraint, match="flat in the middle") as refused:
        shell.solve(np.stack([STILL, mirror]), substeps=4)
    assert (refused.value.elements, refused.value.element_kind) == ([1], "handle")
    shares: list[float] = []
    with pytest.raises(sn.Cancelled):
        shell.solve(BENT, substeps=3, progress=lambda share, _stage: shares.append(share) or share < 0.5)
    assert shares == sorted(shares)
    assert shares[0] < 0.5
    pose = turn((1, 2, 3), 100, (4, 5, 6), (1, 2, 3))
    implicit = bound(sn.LaplacianEditing, {"transforms": "implicit"})
    found, _ = implicit.solve(np.stack([pose, pose]), substeps=3)
    np.testing.assert_allclose(found, moved(pose, POINTS), atol=1e-8)


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_weights_near_one_are_nearly_one(method: type) -> None:
    points, faces = sphere(4)
    points = points * (3, 1, 1)
    surface = made(method, sn.SurfaceMesh(points, faces))
    shapes = []
    for weight in (1.0, 0.999, 1.0 - 1e-5, 1.0 - 1e-9):
        surface.set_handles(ends(points, 0.8), [1.0, weight])
        shapes.append(surface.solve([STILL, turn((0, 0, 1), 60, move=(-0.5, 0.8, 0.0))])[0])
    assert max(off(shape, shapes[0]) for shape in shapes[1:]) < 0.003 * 6.0
