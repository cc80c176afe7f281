# SPDX-License-Identifier: GPL-3.0-or-later
"""Multiresolution deformations around other methods, with any number of bands, also by dense matrices."""

import itertools

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import BENT, STILL, edges_of, ends, grid, moved, nearest_rotations, off, sphere, turn
from ..methods import SURFACE_METHODS, bound_to, required
from ..oracles.test_oracles_surface import MESHES, Rest, gradients

POINTS, FACES = grid(12)
BASES = [method for method in SURFACE_METHODS if "base" not in required(method)]
DETAILS = ["displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer"]


def around(base: type, **options: object) -> sn.Multiresolution:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    return bound_to(sn.Multiresolution(mesh, base(mesh), **options), ends(POINTS))


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
    alone = bound_to(base(sn.SurfaceMesh(POINTS, FACES)), handles)
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
    mesh, places = sn.SurfaceMesh(LIMBS, LIMB_FACES), LIMBS[np.concatenate(HELD)]
    method = sn.Multiresolution(mesh, sn.Arap(mesh), details=details, bands=bands)
    remarks = method.set_handles(HELD).remarks
    of_space = sn.MultiresolutionSpace(places, sn.Rbf(places), mesh, details=details, bands=bands)
    of_space.bind(LIMBS)
    for pose in (STILL, TURNED):
        assert off(method.solve([pose, pose])[0], moved(pose, LIMBS)) < 1e-6
        assert off(of_space.warp(moved(pose, places)), moved(pose, LIMBS)) < 1e-6
    used = len(method.levels()) - 1
    assert used == bands or bands > 1
    assert len(remarks) == (used < bands)
    assert all(text.startswith(f"only {used} of {bands} bands are used") for text in remarks)


BALL, BALL_FACES = sphere(3)
WAVES = 0.1 * np.sin(9 * BALL[:, 0]) * np.cos(8 * BALL[:, 1])
MESHES["bumpy"] = (BALL * (1 + WAVES)[:, None] * (2, 1, 1), BALL_FACES)
MESHES["wide"] = grid(8)
WAVELENGTH = 6.0
MOVED = np.stack([STILL, turn((0.2, 1, 0), 40, (1, 0, 0), (0.3, 0, 0.5))])


def frames(points: np.ndarray, triangles: np.ndarray, power: float) -> np.ndarray:
    """(t, 3, 3) two edges of each triangle and its normal, as long as a power of twice the area."""
    a, b, c = points[triangles].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    normal *= np.linalg.norm(normal, axis=1, keepdims=True) ** (power - 1)
    return np.stack([b - a, c - a, normal], -1)


class Band:
    """A bumpy body between two handles, its base, and where a thin shell takes that."""

    def __init__(self, details: str) -> None:
        points = MESHES["bumpy"][0]
        self.rest = Rest("bumpy", ends(points, 0.5))
        self.fine, self.triangles = points, self.rest.triangles
        shell = sn.ThinShell(self.rest.mesh)
        method = sn.Multiresolution(self.rest.mesh, shell, details=details, wavelength=WAVELENGTH)
        method.set_handles(self.rest.handles)
        shell.set_handles(self.rest.handles)
        self.base = method.levels()[1]
        self.moved = self.base + shell.solve(MOVED)[0] - points  # it displaces all shapes alike
        self.found = method.solve(MOVED)[0]

    def maps(self, power: float) -> np.ndarray:
        """(t, 3, 3) of the triangles of the base."""
        before, after = (frames(shape, self.triangles, power) for shape in (self.base, self.moved))
        return after @ np.linalg.inv(before)


@pytest.mark.parametrize(("name", "free"), [("bumpy", None), ("wide", 23)])
def test_the_base_is_what_implicit_fairing_leaves(name: str, free: int | None) -> None:
    """(M + (wavelength / 2 pi)^4 L M^-1 L) b = M y; two rings at an open border stay."""
    points = MESHES[name][0]
    rest = Rest(name, ends(points, 0.5) if name == "bumpy" else [np.array([40, 41])])
    if name == "wide":
        rim = np.abs(np.arange(9) - 4) > 2
        held = (rim[:, None] | rim).ravel()
        held[[40, 41]] = True
        rest.free = np.flatnonzero(~held)
        assert len(rest.free) == free
    method = sn.Multiresolution(rest.mesh, sn.ThinShell(rest.mesh), wavelength=WAVELENGTH)
    method.set_handles(rest.handles)
    pairs = edges_of(rest.faces)
    length = WAVELENGTH * np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1).mean()
    L, M = rest.laplacian("cotan_voronoi"), rest.mass("cotan_voronoi")
    A = np.diag(M) + (length / (2 * np.pi)) ** 4 * L @ (L / M[:, None])
    base = rest.solution(A, M[:, None] * points, points)
    assert np.abs(base - points).max() > 0.01
    np.testing.assert_allclose(method.levels()[1], base, rtol=0, atol=1e-10)


def test_vectors_turn_as_the_rings_of_the_base_do() -> None:
    band = Band("displacement_vectors")
    area = np.linalg.norm(frames(band.base, band.triangles, 1.0)[:, :, 2], axis=1) / 2
    sums = np.zeros((len(band.fine), 3, 3))
    for corner in range(3):
        np.add.at(sums, band.triangles[:, corner], area[:, None, None] * band.maps(0.0))
    expected = band.moved + np.einsum("vij,vj->vi", nearest_rotations(sums), band.fine - band.base)
    assert np.abs(band.fine - band.base).max() > 0.05
    np.testing.assert_allclose(band.found, expected, rtol=0, atol=1e-11)


def test_deformation_transfer_solves_for_the_gradients_that_the_base_maps() -> None:
    """With a normal times the root of the area on both sides, which makes similarities exact."""
    band = Band("deformation_transfer")
    G = gradients(band.fine, band.triangles)
    goal = (G @ band.fine) @ band.maps(0.5).swapaxes(1, 2)
    rows = G.reshape(-1, len(band.fine))
    area = np.repeat(np.linalg.norm(frames(band.fine, band.triangles, 1.0)[:, :, 2], axis=1) / 2, 3)
    weighted = rows.T * area
    expected = band.rest.solution(weighted @ rows, weighted @ goal.reshape(-1, 3), band.moved)
    np.testing.assert_allclose(band.found, expected, rtol=0, atol=1e-10)
