# SPDX-License-Identifier: GPL-3.0-or-later
"""The multiresolution deformation around each other surface method, and with any number of bands."""

import itertools

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import BENT, STILL, ends, grid, moved, sphere, turn
from ..methods import SURFACE_METHODS, required

POINTS, FACES = grid(12)
BASES = [method for method in SURFACE_METHODS if "base" not in required(method)]
DETAILS = ["displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer"]


def around(base: type, **options: object) -> sn.Multiresolution:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    method = sn.Multiresolution(mesh, base(mesh), **options)
    method.set_handles(ends(POINTS))
    return method


@pytest.mark.parametrize("details", DETAILS)
@pytest.mark.parametrize("base", BASES)
def test_any_method_can_be_the_base(base: type, details: str) -> None:
    method = around(base, details=details)
    positions, report = method.solve(np.stack([STILL, STILL]))
    np.testing.assert_allclose(positions, POINTS, atol=1e-11)
    assert report.converged
    handles = ends(POINTS)
    positions, _ = method.solve(BENT)
    assert np.isfinite(positions).all()
    for pose, handle in zip(BENT, handles, strict=True):
        np.testing.assert_allclose(positions[handle], moved(pose, POINTS[handle]), atol=1e-12)
    pose = turn((1, 2, 3), 100, (4, 5, 6), (1, 2, 3))
    alone = base(sn.SurfaceMesh(POINTS, FACES))
    alone.set_handles(handles)
    if np.allclose(alone.solve(np.stack([pose, pose]))[0], moved(pose, POINTS), atol=1e-8):  # it can turn
        positions, _ = method.solve(np.stack([pose, pose]))
        np.testing.assert_allclose(positions, moved(pose, POINTS), atol=1e-8)


def test_levels_are_the_rest_shape_and_ever_smoother_ones_that_agree_on_handles() -> None:
    points, faces = grid(30)
    points[:, 2] = 2.4 * np.maximum(0.0, np.sin(0.25 * np.pi * points[:, :2]).prod(axis=1)) ** 2
    mesh, held = sn.SurfaceMesh(points, faces), np.concatenate(ends(points, 3.0))
    method = sn.Multiresolution(mesh, sn.ThinShell(mesh), bands=3, wavelength=4.0)
    np.testing.assert_array_equal(method.levels(), [points])
    method.set_handles(ends(points, 3.0))
    levels = method.levels()
    assert [level.shape for level in levels] == [points.shape] * 4
    np.testing.assert_array_equal(levels[0], points)
    heights = [np.linalg.norm(level[:, 2]) for level in levels]
    assert all(after < 0.99 * before for before, after in itertools.pairwise(heights))
    for level in levels:
        np.testing.assert_array_equal(level[held], points[held])


def test_details_without_a_height_are_counted() -> None:
    """Noise of two edges, as the base below it is not flat either."""
    noise = np.random.default_rng(1).uniform(-2, 2, POINTS.shape)
    mesh = sn.SurfaceMesh(POINTS + noise, FACES)
    counts = {}
    for details in DETAILS:
        method = sn.Multiresolution(mesh, sn.ThinShell(mesh), details=details)
        counts[details] = method.set_handles(ends(POINTS)).detail_vectors
        again = sn.Multiresolution(mesh, sn.ThinShell(mesh), details=details)
        assert again.rebind(method, ends(POINTS)).detail_vectors == counts[details]
    assert 0 < counts.pop("normal_displacements") < 20
    assert not any(counts.values())


def test_volumes_in_a_tight_bend_are_counted_as_fallbacks() -> None:
    method = around(sn.ThinShell, details="displacement_volumes")
    assert method.solve(np.stack([STILL, STILL]))[1].fallbacks == 0
    doubled = np.column_stack([2 * np.eye(3), np.zeros(3)])
    assert method.solve(np.stack([doubled, doubled]))[1].fallbacks == 1


def test_what_does_not_fit_is_refused() -> None:
    mesh, other = sn.SurfaceMesh(POINTS, FACES), sn.SurfaceMesh(POINTS + 1, FACES)
    base = sn.ThinShell(mesh)
    with pytest.raises(TypeError):
        sn.Multiresolution(mesh, None)
    with pytest.raises(sn.InvalidOption, match="make both on the same mesh"):
        sn.Multiresolution(other, base)
    with pytest.raises(sn.InvalidOption, match="details: 'heights' is not one of 'displacement_vectors'"):
        sn.Multiresolution(mesh, base, details="heights")


TURNED = turn((1, 2, 3), 70, (0.5, 0.0, 0.0), (0.1, 0.2, 0.3))


def limbs() -> tuple[np.ndarray, np.ndarray]:
    """A ball with six limbs along the axes, each with a bump at its end: smooth bases shrink to threads."""
    points, faces = sphere(4)
    along = np.abs(points).max(axis=1)
    length = 0.3 + 4.0 * np.clip((along - 0.9) / 0.1, 0.0, 1.0) + 0.1 * (along > 0.99)
    return points * length[:, None], faces


LIMBS, LIMB_FACES = limbs()
HELD = [np.flatnonzero(LIMBS[:, 0] > 3.0), np.flatnonzero(LIMBS[:, 1] < -3.0)]


@pytest.mark.parametrize("bands", [1, 4, 8])
@pytest.mark.parametrize("details", DETAILS)
def test_rest_and_rigid_motions_are_kept_with_any_number_of_bands(details: str, bands: int) -> None:
    mesh = sn.SurfaceMesh(LIMBS, LIMB_FACES)
    method = sn.Multiresolution(mesh, sn.Arap(mesh), details=details, bands=bands)
    remarks = method.set_handles(HELD).remarks
    off = [
        np.linalg.norm(method.solve([pose, pose])[0] - moved(pose, LIMBS), axis=1).max()
        for pose in (STILL, TURNED)
    ]
    used = len(method.levels()) - 1
    print(f"{details}: {used} of {bands} bands, rest off by {off[0]:.1e}, a rigid motion by {off[1]:.1e}")
    assert max(off) < 1e-6
    assert used == bands or bands > 1
    assert len(remarks) == (used < bands)
    assert all(text.startswith(f"only {used} of {bands} bands are used") for text in remarks)


@pytest.mark.parametrize("bands", [1, 4, 8])
@pytest.mark.parametrize("details", DETAILS)
def test_a_space_method_as_the_base_keeps_them_too(details: str, bands: int) -> None:
    places = LIMBS[np.concatenate(HELD)]
    mesh = sn.SurfaceMesh(LIMBS, LIMB_FACES)
    method = sn.MultiresolutionSpace(places, sn.Rbf(places), mesh, details=details, bands=bands)
    method.bind(LIMBS)
    for pose in (STILL, TURNED):
        off = np.linalg.norm(method.warp(moved(pose, places)) - moved(pose, LIMBS), axis=1).max()
        assert off < 1e-6
