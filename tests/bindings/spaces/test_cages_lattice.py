# SPDX-License-Identifier: GPL-3.0-or-later
"""Harmonic coordinates by a lattice: what they share with those by the boundary, and where cages are thin."""

import numpy as np
import pytest

import sinew_native as sn

from .. import limits
from ..cages import bound, u_prism
from ..meshes import angles_filled, halved, joined, sphere
from .test_cage_weights import expect_barycentric, inside_u, off_the_mean, star

SLENDER = np.array((1, 0.4, 0.4))  # the time of a lattice is that of its nodes inside


def box(cells: tuple[int, int, int], size, triangles: bool = True) -> sn.SurfaceMesh:
    """The box [0, size], each side a grid of squares, or of twice as many triangles."""
    corners, u, v = [], np.array((0, 1, 1, 0)), np.array((0, 0, 1, 1))
    for axis, side in np.ndindex(3, 2):
        for i, j in np.ndindex(cells[(axis + 1) % 3], cells[(axis + 2) % 3]):
            square = np.full((4, 3), side * cells[axis])
            square[:, (axis + 1) % 3], square[:, (axis + 2) % 3] = i + u, j + v
            corners.append(square[:: 2 * side - 1])
    points, faces = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    quads = faces.reshape(-1, 4)
    return sn.SurfaceMesh(points / cells * size, halved(quads) if triangles else quads)


def slender_ball(level: int, low: float = 0.98) -> sn.SurfaceMesh:
    points, faces = sphere(level)
    return sn.SurfaceMesh(
        points * SLENDER * np.random.default_rng(3).uniform(low, 1, (len(points), 1)), faces
    )


def in_ball(count: int, radius: float) -> np.ndarray:
    points = np.random.default_rng(1).normal(size=(count, 3))
    points *= np.random.default_rng(2).uniform(0, radius, (count, 1)) / np.linalg.norm(
        points, axis=1, keepdims=True
    )
    return points * SLENDER


def by_lattice(cage: sn.SurfaceMesh, points: np.ndarray, **options: object) -> np.ndarray:
    words = {"quality": "fast", "solver": "lattice"} | options
    weights = bound(sn.Harmonic, cage, points, **words).vertex_weights
    expect_barycentric(weights, cage, points)
    return weights


@pytest.mark.parametrize(
    ("cage", "points", "most"),
    [(slender_ball(1), in_ball(400, 0.7), 0.1), (u_prism(), inside_u(400, 0.05), 0.011)],
    ids=["ball", "u"],
)
def test_the_lattice_agrees_with_the_boundary_within_what_both_tell(cage, points, most: float) -> None:
    errors, weights = [], []
    for solver in ("boundary", "lattice"):
        harmonic = sn.Harmonic(cage, quality="fast", solver=solver, precision="double")
        errors.append(harmonic.bind(points).error)
        weights.append(harmonic.vertex_weights)
    difference = np.abs(weights[1] - weights[0]).max()
    assert 1e-5 < difference < sum(errors) < most, "they are two"


def test_the_lattice_is_chosen_beyond_600_triangles() -> None:
    point = np.array([(0.43, 0.03, 0.06)])
    for cells, count in ((74, 596), (75, 604)):
        rod = box((cells, 1, 1), (1, 0.1, 0.1))
        assert len(rod.triangles) == count
        chosen, lattice = (by_lattice(rod, point, solver=solver) for solver in ("auto", "lattice"))
        assert np.array_equal(chosen, lattice) == (count > 600)


def test_the_lattice_is_barycentric_up_to_the_cage_and_harmonic_inside() -> None:
    cage = slender_ball(3)
    shares = np.random.default_rng(1).dirichlet((1, 1, 1), 700)
    shares[::3, 1] = shares[1::3, 2] = 0  # edges
    shares /= shares.sum(1, keepdims=True)
    on = np.einsum("nk,nkx->nx", shares, cage.points[np.resize(cage.triangles, (700, 3))])
    close = (1 - 10.0 ** -(2 + np.arange(700) % 7))[:, None] * on
    points = np.concatenate([close, in_ball(200, 0.7), star((0.31, -0.09, 0.07), 0.06)])
    weights = by_lattice(cage, points)
    assert weights.max() < 1
    assert weights[-207:].max() < 0.2  # far less than the 1 at a vertex
    assert off_the_mean(weights[-7:]) / 6 < 0.02 * weights[-7].max()
    with limits.threads(1):
        np.testing.assert_array_equal(by_lattice(cage, points), weights)


def test_the_lattice_follows_limbs_thinner_than_a_step() -> None:
    """A rod of a hundredth of a step, where no node lies inside, and beside it another one."""
    rod = box((200, 1, 1), (1, 1e-4, 1e-4))
    points = np.array([(0.5, 5e-5, 5e-5), (0.2525, 2e-5, 7e-5), (0.9, 9e-5, 1e-5)])
    weights = by_lattice(rod, points)
    far = np.abs(rod.points[:, 0] - points[:, :1]) > 0.011
    assert weights[far].max() < 1e-8  # what the mend may give to faint vertices
    arms = sn.SurfaceMesh(*joined((rod.points, rod.triangles), (rod.points + (0, 1.1e-4, 0), rod.triangles)))
    both = by_lattice(arms, points)
    np.testing.assert_allclose(both, np.hstack([weights, 0 * weights]), rtol=0, atol=1e-8)


@pytest.mark.parametrize("wide", [0.05, 0.009], ids=["five steps", "less than one"])
def test_the_lattice_is_close_to_the_boundary_in_a_thin_rod(wide: float) -> None:
    rod = box((20, 1, 1), (1, wide, wide))
    points = np.array([(0.52, 0.5, 0.5), (0.31, 0.3, 0.6), (0.77, 0.8, 0.7), (0.5, 0.1, 0.5)])
    points *= (1, wide, wide)
    expected = bound(sn.Harmonic, rod, points, quality="medium", solver="boundary").vertex_weights
    lattice = sn.Harmonic(rod, quality="fast", solver="lattice", precision="double")
    error = lattice.bind(points).error
    assert np.abs(lattice.vertex_weights - expected).max() < min(0.1, 2 * error + 1e-3)


def test_the_lattice_tells_inside_from_outside_as_angles_do() -> None:
    cage = slender_ball(3, 0.6)  # spikes of neighbours a third apart
    points = np.random.default_rng(1).uniform(-1, 1, (2000, 3)) * np.abs(cage.points).max(0)
    lattice = sn.Harmonic(cage, quality="fast", solver="lattice", outside="mean_value")
    outside = np.flatnonzero(angles_filled(points, cage.points, cage.triangles) < 0.5)
    np.testing.assert_array_equal(lattice.bind(points).outside, outside)


def test_the_lattice_is_refused_above_the_memory_limit() -> None:
    ball = sn.SurfaceMesh(*sphere(1))
    for size in (1 << 20, 8 << 20, 20 << 20):  # the lattice, its links, the work
        with limits.memory(size), pytest.raises(sn.OutOfMemory):
            by_lattice(ball, in_ball(10, 0.5))


def test_the_lattice_lives_with_flat_and_touching_faces() -> None:
    ball = slender_ball(1)
    flat = ball.points.copy()
    flat[ball.triangles[0, 0]] = flat[ball.triangles[0, 1]]
    by_lattice(sn.SurfaceMesh(flat, ball.triangles), in_ball(100, 0.8))
    points = np.random.default_rng(1).uniform(1e-3, 1 - 1e-3, (200, 3)) * SLENDER
    cube = box((2, 2, 2), SLENDER)
    pair = joined((cube.points, cube.triangles), (cube.points + (1, 0, 0), cube.triangles))
    weights = by_lattice(sn.SurfaceMesh(*pair), points)
    assert weights[:, cube.vertex_count :].max() < 1e-3, "what the cycles leave"
