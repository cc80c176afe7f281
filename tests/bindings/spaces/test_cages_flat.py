# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat cages, a polygon and a sheet with a hole: what they keep in their plane, and over it."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import bound
from ..meshes import moved, quad_grid, turn
from .test_cages import FLAG

SHEET, SQUARES = quad_grid(3, 3)
POLYGON = sn.SurfaceMesh(FLAG, [range(6)])
RING = sn.SurfaceMesh(SHEET, np.delete(SQUARES, 4, axis=0))
SHEAR = np.array([(1.3, 0.4, 0, 1), (-0.2, 0.8, 0, 2), (0, 0, 1, 0)])
SIMILAR = turn((0, 0, 1), 130, move=(3, -1, 0)) * (2.5, 2.5, 1, 1)
BOTH = pytest.mark.parametrize("method", [sn.MeanValue, sn.Green])


def around(count: int, height: float, reach: float = 0.3) -> np.ndarray:
    """In a box around the flag."""
    low, high = (-reach, -reach, -height), (4 + reach, 3 + reach, height)
    return np.random.default_rng(1).uniform(low, high, (count, 3))


@pytest.mark.parametrize("cage", [POLYGON, RING], ids=["polygon", "ring"])
@BOTH
def test_maps_of_the_plane_are_kept_inside_outside_and_on_the_outline(method: type, cage) -> None:
    ends = np.roll(cage.points, -1, axis=0)
    on = np.concatenate([cage.points + share * (ends - cage.points) for share in (0, 0.2, 0.4, 0.6, 0.8)])
    beside = [on + (by, -by, 0) for by in (0, 1e-13, -1e-9, 1e-5, -1e-3)]
    points = np.concatenate([around(300, 0), around(200, 0, 3.0), *beside])
    pose = SHEAR if method is sn.MeanValue else SIMILAR
    coordinates = bound(method, cage, points)
    found = coordinates.warp(moved(pose, cage.points))
    np.testing.assert_allclose(found, moved(pose, points), rtol=0, atol=1e-11)
    if method is sn.MeanValue:
        np.testing.assert_allclose(coordinates.vertex_weights.sum(1), 1, rtol=0, atol=1e-12)


def test_mean_value_has_the_known_weights_of_a_square() -> None:
    points = np.array([(0.5, 0.5, 0), (0.5, 0, 0), (1, 1, 0)])
    weights = bound(sn.MeanValue, sn.SurfaceMesh(*quad_grid(1, 1)), points).vertex_weights
    expected = [(0.25,) * 4, (0.5, 0.5, 0, 0), (0, 0, 0, 1)]
    np.testing.assert_allclose(weights, expected, rtol=0, atol=1e-14)


def test_green_is_conformal_inside_and_mean_value_is_not() -> None:
    """Differences of the map satisfy the equations of Cauchy and Riemann for any pose in the plane."""
    pose = FLAG + np.random.default_rng(3).uniform(-0.5, 0.5, FLAG.shape) * (1, 1, 0)
    step, places = 1e-5, np.array([(0.5, 0.5, 0), (2, 0.7, 0), (3.6, 2, 0), (0.7, 2.2, 0)])
    stars = places[:, None] + step * np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    defects = []
    for method in (sn.Green, sn.MeanValue):
        y = bound(method, POLYGON, stars.reshape(-1, 3)).warp(pose).reshape(4, 4, 3)
        dx, dy = (y[:, 0] - y[:, 1]) / (2 * step), (y[:, 2] - y[:, 3]) / (2 * step)
        defects.append(np.hypot(dx[:, 0] - dy[:, 1], dx[:, 1] + dy[:, 0]).max())
    assert defects[0] < 1e-8  # step^2, and rounding / step
    assert defects[1] > 0.1


@BOTH
def test_points_over_the_plane_go_with_its_frame_and_keep_their_distance(method: type) -> None:
    placed, pose = turn((1, 2, -1), 50, move=(3, -1, 2)), turn((3, -1, 2), 75, (1, 2, 3), (-4, 0, 2))
    cage, points = moved(placed, FLAG), moved(placed, around(300, 1.0))
    found = bound(method, sn.SurfaceMesh(cage, [range(6)]), points).warp(moved(pose, cage))
    np.testing.assert_allclose(found, moved(pose, points), rtol=0, atol=2e-12)
    high = around(50, 1.0)
    wide = bound(method, POLYGON, high).warp(FLAG * (3, 1, 1))
    np.testing.assert_allclose(wide[:, 2], high[:, 2], rtol=0, atol=1e-14)


@BOTH
def test_poses_that_collapse_and_points_far_away_stay_finite(method: type) -> None:
    coordinates = bound(method, POLYGON, around(50, 0.3))
    for scale in (0.0, 1e100, 1e-100, (1, 0, 1)):
        assert np.isfinite(coordinates.warp(FLAG * scale)).all()
    far = np.array([(1e2, 3, 5), (1e100, -1e100, 3), (0, 0, -1e300)])
    assert np.isfinite(bound(method, POLYGON, far).vertex_weights).all()


@BOTH
def test_notches_and_holes_are_outside(method: type) -> None:
    points = np.array([(1, 1, 0), (2.5, 2, 0), (5, 1, 0), (2.5, 0.5, 3)])  # the last one is over the inside
    assert method(POLYGON).bind(points).outside.tolist() == [1, 2]
    assert method(RING).bind([(1.5, 1.5, 0)]).outside.tolist() == [0]
    if method is sn.Green:
        with pytest.raises(sn.InvalidConstraint):
            bound(method, POLYGON, points, outside="error")
        with pytest.raises(sn.InvalidOption):
            method(POLYGON, outside="face", exit_face=0)


@pytest.mark.parametrize("method", [sn.Harmonic, sn.PositiveMeanValue])
def test_methods_that_need_a_volume_refuse_a_flat_cage(method: type) -> None:
    with pytest.raises(sn.InvalidMesh) as refused:
        method(POLYGON)
    assert (refused.value.element_kind, refused.value.elements) == ("face", [0])
