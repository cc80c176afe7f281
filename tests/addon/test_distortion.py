# SPDX-License-Identifier: GPL-3.0-or-later
"""Distortion against maps whose singular values are known, and against NumPy's SVD."""

from collections.abc import Callable

import numpy as np
import pytest

from sinew.core.geometry import distortion
from sinew.core.geometry.distortion import COLLAPSED, Measure

RANDOM = np.random.default_rng(11)


def some_triangles(count: int = 50) -> tuple[np.ndarray, np.ndarray]:
    """Triangles in space that share no vertex, none of them thin."""
    points = RANDOM.normal(size=(count, 3))[:, None] + np.array(((0, 0, 0), (1, 0.1, 0), (0.2, 0.9, 0.3)))
    return points.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def rotation() -> np.ndarray:
    turn, upper = np.linalg.qr(RANDOM.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(upper))
    return turn * np.sign(np.linalg.det(turn))


def folded(points: np.ndarray, across: np.ndarray) -> np.ndarray:
    """A sheet of two triangles bent by a right angle along the edge that they share."""
    bent, middle = points.copy(), 0.5 * (points[1] + points[2])
    bent[3] = middle + np.linalg.norm(points[3] - middle) * across
    return bent


SHEET = np.array(((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)), dtype=float), np.array(((0, 1, 2), (1, 3, 2)))
ISOMETRIES = {
    "rigid motion": (some_triangles(), lambda points: points @ rotation().T + (1.0, 2.0, 3.0)),
    "mirror image": (some_triangles(), lambda points: points * (-1.0, 1.0, 1.0)),
    "bent along an edge": (SHEET, lambda points: folded(points, np.array((0.0, 0.0, 1.0)))),
}


@pytest.mark.parametrize(("mesh", "move"), ISOMETRIES.values(), ids=ISOMETRIES)
def test_an_isometry_of_the_surface_has_ones(mesh: tuple, move: Callable):
    points, triangles = mesh
    values = distortion.singular_values(distortion.rest_metric(points, triangles), move(points))
    assert np.abs(np.array(values) - 1.0).max() < 1e-13


SHEAR = np.outer((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
LINEAR = {
    **{f"scaled by {factor}": factor * np.eye(3) for factor in (1e-3, 0.5, 1.0, 3.0, 1e4)},
    **{f"sheared by {factor}": np.eye(3) + factor * SHEAR for factor in (0.1, 1.0, 4.0)},
    "stretched": np.diag((3.0, 0.5, 1.0)),
    "of each triangle its own": None,
}


@pytest.mark.parametrize("linear", LINEAR.values(), ids=LINEAR)
def test_a_map_has_the_singular_values_of_numpy(linear: np.ndarray | None):
    points, triangles = some_triangles()
    shown = RANDOM.normal(size=points.shape) if linear is None else points @ linear.T @ rotation().T
    largest, smallest = distortion.singular_values(distortion.rest_metric(points, triangles), shown)
    for row, corners in enumerate(triangles):
        edges = (points[corners[1:]] - points[corners[0]]).T
        moved = (shown[corners[1:]] - shown[corners[0]]).T
        expected = np.linalg.svd(moved @ np.linalg.pinv(edges), compute_uv=False)
        assert np.allclose((largest[row], smallest[row]), expected[:2])


def test_measures_of_known_singular_values():
    largest, smallest = np.array((2.0, 0.5, 1.0)), np.array((0.25, 0.5, 1.0))
    expected = {
        Measure.AREA: (0.5, 0.25, 1.0),
        Measure.ANGLE: (8.0, 1.0, 1.0),
        Measure.STRETCH: (2.0, 0.5, 1.0),
        Measure.DIRICHLET: ((4.0 + 0.0625 + 0.25 + 16.0) / 4.0, (0.5 + 8.0) / 4.0, 1.0),
    }
    for measure in Measure:
        assert np.allclose(distortion.ratio(measure, largest, smallest), expected[measure])


def test_one_sided_measures_never_fall_below_one():
    largest = np.exp(RANDOM.normal(size=500))
    smallest = largest * RANDOM.uniform(0.01, 1.0, size=500)
    for measure in Measure:
        found = distortion.ratio(measure, largest, smallest)
        assert measure.two_sided == bool((found < 1.0 - 1e-12).any())


def degenerate_rest() -> np.ndarray:
    """Corners in one place, two in one place, in a line, not a number, and a sound triangle."""
    nan = float("nan")
    return np.array(
        (
            ((1, 1, 1), (1, 1, 1), (1, 1, 1)),
            ((0, 0, 0), (0, 0, 0), (1, 0, 0)),
            ((0, 0, 0), (1, 0, 0), (0, 0, 0)),
            ((0, 0, 0), (1, 1, 0), (3, 3, 0)),
            ((0, 0, 0), (nan, 1, 0), (3, 3, 0)),
            ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
        ),
        dtype=float,
    ).reshape(-1, 3)


def test_triangles_without_a_shape_at_rest_count_as_unchanged():
    points = degenerate_rest()
    triangles = np.arange(len(points)).reshape(-1, 3)
    rest = distortion.rest_metric(points, triangles)
    largest, smallest = distortion.singular_values(rest, RANDOM.normal(size=points.shape))
    assert np.array_equal(largest[:-1], np.ones(5))
    assert np.array_equal(smallest[:-1], np.ones(5))
    assert np.array_equal(rest.area > 0.0, (False,) * 5 + (True,))
    for measure in Measure:
        values = distortion.at_vertices(rest, distortion.ratio(measure, largest, smallest))
        assert np.isfinite(values).all()
        assert np.array_equal(values[:15], np.ones(15))


def test_collapsed_triangles_are_finite():
    """A sound rest triangle crushed into a line, an edge, a point: never NaN, never infinite."""
    shapes = degenerate_rest().reshape(-1, 3, 3)
    points = np.concatenate([shapes[-1]] * len(shapes))
    rest = distortion.rest_metric(points, np.arange(len(points)).reshape(-1, 3))
    largest, smallest = distortion.singular_values(rest, shapes.reshape(-1, 3))
    assert np.allclose(largest[[0, 1, 2, 5]], (0.0, 1.0, 1.0, 1.0))
    assert np.allclose(smallest, (0.0, 0.0, 0.0, 0.0, 1.0, 1.0))
    for measure in Measure:
        found = distortion.ratio(measure, largest, smallest)
        assert np.isfinite(distortion.at_vertices(rest, found)).all()
    assert distortion.ratio(Measure.STRETCH, largest, smallest)[0] == COLLAPSED


def test_vertices_take_the_mean_by_area():
    """Two triangles of areas 1 and 3 at one edge, of ratios 2 and 8: 2^(1/4) 8^(3/4) on the edge."""
    points = np.array(((0, 0, 0), (0, 2, 0), (1, 0, 0), (-3, 0, 0)), dtype=float)
    rest = distortion.rest_metric(points, np.array(((0, 2, 1), (0, 1, 3))))
    assert np.allclose(rest.area, (1.0, 3.0))
    values = distortion.at_vertices(rest, np.array((2.0, 8.0)))
    edge = 2.0**0.25 * 8.0**0.75
    assert np.allclose(values, (edge, edge, 2.0, 8.0))


def test_vertices_without_triangles_are_unchanged():
    points = np.vstack((np.eye(3), (9.0, 9.0, 9.0)))
    rest = distortion.rest_metric(points, np.array(((0, 1, 2),)))
    assert distortion.at_vertices(rest, np.array((5.0,)))[3] == 1.0
    alone = distortion.rest_metric(points, np.zeros((0, 3), dtype=int))
    assert np.array_equal(distortion.at_vertices(alone, np.zeros(0)), np.ones(4))


def test_the_worst_is_the_farthest_from_one_either_way():
    assert distortion.worst(np.array((1.0, 1.9, 0.5))) == 2
    assert distortion.worst(np.array((1.0, 2.1, 0.5))) == 1
