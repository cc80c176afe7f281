# SPDX-License-Identifier: GPL-3.0-or-later
"""The shares of handles over a surface, by propagation: what a vertex moves of each handle's unit step."""

import igl
import numpy as np
import pytest

import sinew_native as sn

from ..meshes import bar, edges_of, ends, grid, joined, shift, sphere

Meshes = tuple[np.ndarray, np.ndarray]
FIELDS = ("harmonic", "geodesic", "euclidean")
EVERY_FIELD = pytest.mark.parametrize("field", FIELDS)


def bound(mesh: Meshes, handles: list, weights: list | None, field: str) -> sn.Propagation:
    method = sn.Propagation(sn.SurfaceMesh(*mesh), field=field)
    method.set_handles(handles, weights)
    return method


def shares(mesh: Meshes, handles: list, weights: list | None, field: str) -> np.ndarray:
    """(n, h)"""
    method, count = bound(mesh, handles, weights, field), len(handles)
    moved = [[shift(float(h == k), 0, 0) for k in range(count)] for h in range(count)]
    return np.stack([(method.solve(poses)[0] - mesh[0])[:, 0] for poses in moved], 1)


def two_spheres(gap: float) -> Meshes:
    points, faces = sphere(2)
    return joined(sphere(3), (points + (gap, 0, 0), faces))


FIRST = len(sphere(3)[0])  # vertices of the first of them
OF_BOTH = [[0, FIRST], [1], [4, FIRST + 5], [40, 41, 42]]
WEIGHTS = [None, None, None, [0.5, 0.5, 0.9]]


@EVERY_FIELD
def test_shares_are_linear_along_a_regular_tube(field: str) -> None:
    points, faces = bar(20, 3)
    found = shares((points, faces), ends(points, 1), None, field)
    expected = np.clip((points[:, 0] - 1) / 18, 0, 1)
    np.testing.assert_allclose(found, np.column_stack([1 - expected, expected]), atol=1e-12)


@EVERY_FIELD
def test_shares_are_one_on_their_handle_and_sum_to_one_in_each_part(field: str) -> None:
    found = shares(two_spheres(5), OF_BOTH, WEIGHTS, field)
    assert found.min() >= -1e-14
    assert found.max() <= 1 + 1e-14
    np.testing.assert_allclose(found.sum(1), 1, atol=1e-14)
    np.testing.assert_allclose(found[FIRST:, [1, 3]], 0, atol=1e-15)
    for handle in (0, 1, 2):
        np.testing.assert_array_equal(found[OF_BOTH[handle]], np.eye(4)[[handle] * len(OF_BOTH[handle])])


def test_moves_add_up_by_shares_and_what_all_have_in_common_stays() -> None:
    mesh, moves = two_spheres(5), np.random.default_rng(1).uniform(-1, 1, (4, 3))
    method = bound(mesh, OF_BOTH, WEIGHTS, "harmonic")
    found = method.solve([shift(*move) for move in moves])[0] - mesh[0]
    np.testing.assert_allclose(found, shares(mesh, OF_BOTH, WEIGHTS, "harmonic") @ moves, atol=1e-14)
    alike = method.solve([shift(*moves[0])] * 4)[0]
    np.testing.assert_allclose(alike, mesh[0] + moves[0], rtol=0, atol=1e-15)


def test_harmonic_shares_stay_between_their_handles_where_angles_are_obtuse() -> None:
    """Rows of flat triangles, whose long edges have negative weights: the plain equation leaves [0, 1]."""
    i, j = np.mgrid[:6, :8].reshape(2, -1)
    points = np.column_stack([4.0 * j + 3.6 * (i % 2), i, 0.3 * ((i + j) % 3)])
    a = np.flatnonzero((i < 5) & (j < 7))
    faces = np.concatenate([np.stack([a, a + 1, a + 8], 1), np.stack([a + 1, a + 9, a + 8], 1)])
    handles, weights = [[18], [20], [27]], [None, None, [0.4]]
    L = -igl.cotmatrix(points, faces).toarray()
    L[27, 27] += 0.4 / 0.6 * L[27, 27]
    free = np.setdiff1d(np.arange(48), [18, 20])
    plain = np.linalg.solve(L[np.ix_(free, free)], -L[free, 20])
    assert plain.min() < -0.1
    found = shares((points, faces), handles, weights, "harmonic")
    assert found.min() >= -1e-12
    assert found.max() <= 1 + 1e-12


def test_shares_by_straight_distances_are_those_of_their_inverses() -> None:
    points, faces = mesh = two_spheres(2.5)
    handles = [[*range(50, 250, 3), FIRST + 1], [1], [4, FIRST + 5], [40, 41]]  # more than a leaf of the tree
    weights = [np.ones(len(handle)) for handle in handles[:3]] + [np.array([0.5, 0.9])]
    sides = edges_of(faces)
    edge = np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1).mean()
    part = np.arange(len(points)) >= FIRST
    nearest = []
    for handle, weight in zip(handles, weights, strict=True):
        far = np.linalg.norm(points[:, None] - points[handle], axis=2) + edge * (1 - weight) / weight
        nearest.append(np.where(part[:, None] == part[handle], far, np.inf).min(1))
    free = np.setdiff1d(np.arange(len(points)), np.concatenate(handles[:3]))
    close = 1 / np.stack(nearest, 1)[free]
    found = shares(mesh, handles, weights, "euclidean")[free]
    np.testing.assert_allclose(found, close / close.sum(1, keepdims=True), atol=1e-13)


@EVERY_FIELD
def test_shares_of_soft_handles_near_those_of_hard_ones_as_the_weight_nears_one(field: str) -> None:
    points, faces = grid(8)
    handles, gaps = ends(points, 1.5), [1.0]
    hard = shares((points, faces), handles, None, field)
    for weight in (0.5, 0.99, 0.9999, 1 - 1e-8):
        found = shares((points, faces), handles, [1.0, weight], field)
        gaps.append(np.abs(found - hard).max())
        assert gaps[-1] < 0.5 * gaps[-2]
    assert gaps[-1] < 1e-7
    assert shares((points, faces), handles, [1.0, 1e-300], field)[40, 1] < 1e-9
