# SPDX-License-Identifier: GPL-3.0-or-later
"""The bands of a multiresolution deformation by dense matrices: their base, and what details make of it."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, edges_of, ends, grid, nearest_rotations, sphere, turn
from .test_oracles_surface import MESHES, Rest, gradients

BALL, BALL_FACES = sphere(3)
WAVES = 0.1 * np.sin(9 * BALL[:, 0]) * np.cos(8 * BALL[:, 1])
MESHES["bumpy"] = (BALL * (1 + WAVES)[:, None] * (2, 1, 1), BALL_FACES)
MESHES["wide"] = grid(8)
WAVELENGTH = 6.0
POSES = np.stack([STILL, turn((0.2, 1, 0), 40, (1, 0, 0), (0.3, 0, 0.5))])


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
        self.moved = self.base + shell.solve(POSES)[0] - points  # it displaces all shapes alike
        self.found = method.solve(POSES)[0]

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
