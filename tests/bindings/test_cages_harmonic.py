# SPDX-License-Identifier: GPL-3.0-or-later
"""Harmonic and positive mean value coordinates against finite differences and ray casting in NumPy."""

import numpy as np
import pytest
import scipy.sparse as sparse
import scipy.sparse.linalg as linalg

import sinew_native as sn

from .cages import CUBE, OUTLINE, QUADS, bound, u_prism

CAPS = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]  # triangles of the outline


def surface() -> sn.SurfaceMesh:
    return u_prism(CAPS)


def inside(count: int, depth: float = 0.05) -> np.ndarray:
    points = np.random.default_rng(0).uniform(
        (depth, depth, depth), (3 - depth, 3 - depth, 1 - depth), (4 * count, 3)
    )
    hollow = (abs(points[:, 0] - 1.5) < 0.5 + depth) & (points[:, 1] > 1 - depth)
    return points[~hollow][:count]


METHODS = {
    "harmonic": lambda **options: sn.Harmonic(surface(), quality="fast", **options),
    "positive": lambda **options: sn.PositiveMeanValue(surface(), **options),
    "rays": lambda **options: sn.PositiveMeanValue(surface(), exact=False, **options),
}


@pytest.fixture(params=METHODS)
def method(request):
    return METHODS[request.param]


def caps_data(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(n, 8) the outline's vertices as linear functions on the triangles of a cap."""
    found = np.zeros((len(x), 8))
    done = np.zeros(len(x), bool)
    for triangle in CAPS:
        system = np.vstack((OUTLINE[list(triangle)].T, np.ones(3)))
        hats = np.linalg.solve(system, np.vstack((x, y, np.ones_like(x)))).T
        holds = (hats > -1e-9).all(1) & ~done
        found[np.ix_(holds, triangle)] = hats[holds]
        done |= holds
    return found


def side_data(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(n, 8) the same along the sides of the outline."""
    found = np.zeros((len(x), 8))
    done = np.zeros(len(x), bool)
    for i, (start, along) in enumerate(zip(OUTLINE, np.roll(OUTLINE, -1, 0) - OUTLINE, strict=True)):
        away = np.stack((x, y), -1) - start
        share = away @ along / (along @ along)
        holds = (abs(away[:, 0] * along[1] - away[:, 1] * along[0]) < 1e-9) & (abs(share - 0.5) < 0.5 + 1e-9)
        holds &= ~done
        found[holds, i], found[holds, (i + 1) % 8] = 1 - share[holds], share[holds]
        done |= holds
    return found


def by_differences(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes inside the U and the harmonic functions there, by the seven-point Laplacian on an even grid."""
    x, y, z = (part.ravel() for part in np.mgrid[: 3 * cells + 1, : 3 * cells + 1, : cells + 1])
    hollow = (x > cells) & (x < 2 * cells) & (y > cells)
    rim = (x == 0) | (x == 3 * cells) | (y == 0) | (y == 3 * cells)
    rim |= ((x == cells) | (x == 2 * cells)) & (y >= cells)
    rim |= (y == cells) & (x >= cells) & (x <= 2 * cells)
    caps = (z == 0) | (z == cells)
    used = ~hollow
    free = used & ~rim & ~caps
    data = np.zeros((len(x), 16))
    for level, half in ((0, slice(0, 8)), (1, slice(8, 16))):
        on_side = used & rim
        height = z[on_side] / cells
        share = height if level else 1 - height
        data[on_side, half] = share[:, None] * side_data(x[on_side] / cells, y[on_side] / cells)
        on_cap = used & ~rim & (z == level * cells)
        data[on_cap, half] = caps_data(x[on_cap] / cells, y[on_cap] / cells)
    strides = ((3 * cells + 1) * (cells + 1), cells + 1, 1)
    at = np.flatnonzero(free)
    number = np.full(len(x), -1)
    number[at] = np.arange(len(at))
    matrix = sparse.identity(len(at), format="csr") * 6.0
    right = np.zeros((len(at), 16))
    for step in (*strides, *(-stride for stride in strides)):
        beside = at + step
        linked = number[beside] >= 0
        rows = np.flatnonzero(linked)
        matrix -= sparse.csr_matrix(
            (np.ones(len(rows)), (rows, number[beside[linked]])), shape=(len(at), len(at))
        )
        right[~linked] += data[beside[~linked]]
    solution = linalg.splu(matrix.tocsc()).solve(right)
    return np.stack((x, y, z), -1)[at] / cells, solution


def test_finite_differences_converge_to_harmonic() -> None:
    errors = []
    for cells in (5, 10):
        nodes, expected = by_differences(cells)
        harmonic = bound(sn.Harmonic, surface(), nodes, quality="medium")
        errors.append(np.abs(harmonic.vertex_weights - expected).max(axis=1))
    coarse, fine = errors
    # The grid errs by h^(2/3) at the two edges of 270 degrees, by h^2 log h elsewhere: 1.6 to 4 a halving.
    assert fine.max() < 4e-2
    assert fine.mean() < 2e-3
    assert coarse.mean() > 1.6 * fine.mean()


def first_faces(points, triangles, x, directions) -> np.ndarray:
    """Positive mean values by casting every ray at every triangle."""
    corners = points[triangles] - x
    normals = np.cross(np.roll(corners, -1, 1), np.roll(corners, -2, 1))  # of the sides opposite each corner
    volume = np.einsum("tk,tk->t", corners[:, 0], normals[:, 0])
    hats = np.einsum("tck,dk->dtc", normals / volume[:, None, None], directions)  # over the distance
    hit = (hats >= 0).all(2)
    inverse = np.where(hit, hats.sum(2), 0.0)
    first = inverse.argmax(1)
    weights = np.zeros(len(points))
    for corner in range(3):
        np.add.at(weights, triangles[first, corner], hats[np.arange(len(directions)), first, corner])
    return weights / weights.sum()


def test_positive_mean_values_agree_with_ray_casting() -> None:
    cage = surface()
    x = np.array([(0.5, 2.5, 0.5), (1.5, 0.5, 0.5), (0.2, 0.3, 0.7), (2.4, 1.2, 0.1)])
    random = np.random.default_rng(1).standard_normal((40_000, 3))
    directions = random / np.linalg.norm(random, axis=1)[:, None]
    positive = bound(sn.PositiveMeanValue, cage, x)
    for row, at in zip(positive.vertex_weights, x, strict=True):
        expected = first_faces(cage.points, cage.triangles, at, directions)
        assert np.abs(row - expected).max() < 5e-3  # four standard errors of 40,000 random rays


def test_weights_are_barycentric(method) -> None:
    x = inside(300)
    coordinates = method(precision="double")
    report = coordinates.bind(x)
    weights = coordinates.vertex_weights
    assert report.point_count == len(x)
    assert len(report.outside) == 0
    assert weights.min() >= 0
    assert np.abs(weights.sum(1) - 1).max() < 1e-12
    assert np.abs(weights @ surface().points - x).max() < 1e-9
    np.testing.assert_allclose(coordinates.warp(surface().points * 2 + 1), x * 2 + 1, atol=1e-9)


def test_single_precision_is_close_to_double(method) -> None:
    x = inside(50)
    single, double = method(), method(precision="double")
    single.bind(x)
    double.bind(x)
    assert np.abs(single.vertex_weights - double.vertex_weights).max() < 1e-7


def test_points_outside_are_named_or_bound_by_mean_values(method) -> None:
    x = np.array([(0.5, 0.5, 0.5), (1.5, 2.0, 0.5), (0.5, 0.5, -1.0)])
    with pytest.raises(sn.InvalidConstraint) as refusal:
        method().bind(x)
    assert refusal.value.elements == [1, 2]
    assert refusal.value.element_kind == "vertex"
    coordinates = method(precision="double", outside="mean_value")
    assert coordinates.bind(x).outside.tolist() == [1, 2]
    plain = bound(sn.MeanValue, surface(), x)
    np.testing.assert_allclose(coordinates.vertex_weights[1:], plain.vertex_weights[1:], atol=1e-12)


def test_cancelled_bind_leaves_the_last_one(method) -> None:
    coordinates = method()
    coordinates.bind(inside(10))
    before = coordinates.vertex_weights
    with pytest.raises(sn.Cancelled):
        coordinates.bind(inside(20), progress=lambda fraction, stage: False)
    np.testing.assert_array_equal(coordinates.vertex_weights, before)


def test_progress_rises_to_one(method) -> None:
    told = []
    method().bind(inside(500), progress=lambda fraction, stage: told.append((fraction, stage)) or True)
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert all(stage for _, stage in told)


def test_unknown_choices_are_refused() -> None:
    for make in (
        lambda: sn.Harmonic(surface(), quality="best"),
        lambda: sn.Harmonic(surface(), outside="zero"),
        lambda: sn.Harmonic(surface(), solver="grid"),
        lambda: sn.PositiveMeanValue(surface(), outside="zero"),
        lambda: sn.PositiveMeanValue(surface(), exact=False, directions=7),
    ):
        with pytest.raises(sn.InvalidOption):
            make()


def test_harmonic_report_tells_quality() -> None:
    x = inside(200)
    steps = []
    for quality in ("fast", "medium"):
        harmonic = sn.Harmonic(surface(), quality=quality)
        assert harmonic.unknowns == 0
        steps.append(
            (harmonic.bind(x).error, harmonic.residual_rms, harmonic.residual_max, harmonic.unknowns)
        )
    (error, rms, largest, unknowns), (finer_error, finer_rms, finer_largest, more) = steps
    assert unknowns <= 1000 < more <= 2000
    assert 0 < finer_error < error
    assert finer_rms < rms
    assert max(largest, finer_largest) < 0.02


def test_harmonic_above_the_memory_limit_is_refused() -> None:
    sn.limit_memory(1_000_000)
    try:
        with pytest.raises(sn.OutOfMemory, match="memory limit"):
            sn.Harmonic(surface()).bind(inside(5))
    finally:
        sn.limit_memory(0)


def test_harmonic_cube_is_trilinear_from_python() -> None:
    x = np.random.default_rng(0).uniform(0, 1, (200, 3))
    harmonic = sn.Harmonic(sn.SurfaceMesh(CUBE, QUADS))
    harmonic.bind(x)
    expected = np.prod(np.where(CUBE > 0.5, x[:, None], 1 - x[:, None]), axis=2)
    assert np.abs(harmonic.vertex_weights - expected).max() < 1e-4


def test_lattice_and_boundary_agree_from_python() -> None:
    x = inside(200)
    found = {}
    for solver in ("boundary", "lattice"):
        harmonic = sn.Harmonic(surface(), precision="double", quality="medium", solver=solver)
        found[solver] = (harmonic.bind(x).error, harmonic.vertex_weights)
    (boundary_error, boundary), (lattice_error, lattice) = found["boundary"], found["lattice"]
    assert np.abs(boundary - lattice).max() < boundary_error + lattice_error < 0.1
    assert harmonic.residual_max == 0
    assert np.abs(lattice @ surface().points - x).max() < 1e-11
