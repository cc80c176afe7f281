# SPDX-License-Identifier: GPL-3.0-or-later
"""What vector fields promise: rigid motions where they hold, volume, order and tolerance of their steps."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, moved, off, shift, turn

FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))
DRAG = {"tools": "drag", "inner": 0.4, "outer": 1.2, "width": 1.5}
TWIST = DRAG | {"tools": "twist"}
# A bend of wide things on a short way would squeeze what lies on its inner side.
BEND = {"tools": "bend", "inner": 0.2, "outer": 2.2, "width": 0.7}
SOME = turn((1, 2, -1), 70, move=(0.5, -0.3, 0.6))  # small enough to leave points in every region


def scattered(count: int, reach: float = 1.6) -> np.ndarray:
    return np.random.default_rng(4).uniform(-reach, reach, (count, 3))


def warped(points: np.ndarray, *poses: np.ndarray, **options: object) -> np.ndarray:
    field = sn.VectorField(np.tile(FRAME, (len(poses), 1)), **options)
    field.bind(points)
    return field.warp(np.concatenate([moved(pose, FRAME) for pose in poses]))


def test_a_drag_moves_the_inner_ball_rigidly_and_nothing_outside() -> None:
    points, way = scattered(3000), SOME[:, 3]
    out = warped(points, SOME, **DRAG)
    inside = np.linalg.norm(points, axis=1) < 0.4
    along = np.clip(points @ way / (way @ way), 0, 1)
    outside = np.linalg.norm(points - along[:, None] * way, axis=1) > 1.2
    np.testing.assert_allclose(out[inside], moved(SOME, points)[inside], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(out[outside], points[outside])
    assert min(inside.sum(), outside.sum()) > 10


@pytest.mark.parametrize("order", [1, 2, 4])
def test_linear_p_and_q_translate_exactly_by_any_rule(order: int) -> None:
    points, move, options = (
        scattered(100, 0.5),
        np.array((0.3, 0.7, -0.2)),
        DRAG | {"inner": 2.0, "outer": 3.0},
    )
    out = warped(points, shift(*move), **options, order=order, steps=3)
    np.testing.assert_allclose(out, points + move, rtol=0, atol=1e-14)
    field = sn.VectorField(FRAME, **options, order=order, steps=3)
    velocities = field.velocities(FRAME + move, 0, 0.5, points)
    np.testing.assert_allclose(velocities, np.tile(move, (100, 1)), rtol=0, atol=1e-15)


def test_a_bend_takes_what_is_above_rigidly_and_keeps_what_is_below_and_beside() -> None:
    pose, points = turn((1, 0, 0), 60), scattered(20000, 3.0)
    out, rigid = warped(points, pose, **BEND), moved(pose, points)
    begin = np.array((0, 0, 1.0))
    end = moved(turn((1, 0, 0), 30), begin)  # the axis halfway turns by up to 30 degrees
    around = np.hypot(points[:, 0], points[:, 1])
    back = moved(turn((1, 0, 0), -60), points)
    above = (np.minimum(points @ begin, rigid @ end) > 2.25) & (around < 0.65)
    below = np.maximum(points @ begin, points @ end) < 0.2
    beside = (np.minimum(around, np.hypot(back[:, 0], back[:, 1])) > 1.4) & (points[:, 1] > 0)
    assert off(out[above], rigid[above]) < 1.2e-5, "the tolerance of the integration"
    np.testing.assert_array_equal(out[below], points[below])
    np.testing.assert_array_equal(out[beside], points[beside])  # the bend is to the other side
    assert min(above.sum(), beside.sum(), below.sum() / 5) > 20


def test_a_turn_about_another_axis_is_no_twist_and_no_bend() -> None:
    points = scattered(100)
    np.testing.assert_array_equal(warped(points, turn((0, 0, 1), 80), **BEND), points)
    np.testing.assert_allclose(warped(points, turn((1, 0, 0), 80), **TWIST), points, rtol=0, atol=1e-12)


def drift(points: np.ndarray, **options: object) -> float:
    """How far the determinant of the warp's derivative is from 1, by central differences."""
    step = 1e-4 * np.concatenate([np.eye(3), -np.eye(3)])
    out = warped((points[:, None] + step).reshape(-1, 3), SOME, **options).reshape(-1, 2, 3, 3)
    return np.abs(np.linalg.det((out[:, 0] - out[:, 1]) / 2e-4) - 1).max()


@pytest.mark.parametrize("tool", [DRAG, BEND], ids=["drag", "bend"])
def test_the_volume_drifts_less_with_a_higher_order(tool: dict) -> None:
    points = scattered(60, 0.9)
    drifts = [drift(points, **tool, order=order, steps=40) for order in (1, 2, 4)]
    assert drifts[1] < 0.2 * drifts[0]
    assert drifts[2] < 0.2 * drifts[1]
    assert drifts[2] < 1e-4
    assert drift(points, **tool, tolerance=1e-9) < 1e-4, "the tolerance over the step of differences"


@pytest.mark.parametrize("order", [1, 2, 4])
def test_halving_the_step_divides_the_error_by_a_power_of_the_order(order: int) -> None:
    pose, points = turn((0, 1, 1), 40, move=(0.2, 0.1, 0.3)), scattered(40, 0.8)
    smooth = DRAG | {"inner": 0.0, "outer": 2.0, "order": order}  # no kink within reach of the points
    coarse, fine, exact = (warped(points, pose, **smooth, steps=steps) for steps in (20, 40, 4000))
    assert np.log2(off(coarse, exact) / off(fine, exact)) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("tool", [DRAG, TWIST, BEND], ids=["drag", "twist", "bend"])
def test_the_way_back_restores(tool: dict) -> None:
    points = scattered(500)
    out = warped(points, SOME, shift(0, 0.2, 0), SOME, STILL, **tool, tolerance=1e-9)
    assert off(out, points) < 1e-6, "the tolerance times the growth of errors"


def test_more_steps_reach_the_tolerance() -> None:
    points, errors = scattered(500), [1.0]
    reference = warped(points, SOME, **DRAG, steps=4000)
    for tolerance in (1e-3, 1e-5, 1e-7):
        errors.append(off(warped(points, SOME, **DRAG, tolerance=tolerance), reference))
        assert errors[-1] < 5 * tolerance, "errors grow on the rest of the way as space is drawn out"
        assert errors[-1] < 0.1 * errors[-2]


def test_far_drags_do_not_turn_space_over() -> None:
    """Where plain displacements would fold, tiny cells keep their sides."""
    side = 1e-6  # far drags draw cells out by more than a thousand
    cells = scattered(2000, 1.2)[:, None] + side * FRAME
    far = DRAG | {"inner": 0.2, "outer": 1.0, "tolerance": 1e-12}
    out = warped(cells.reshape(-1, 3), shift(0.3, 0, 2.5), shift(1, 1, 0), **far).reshape(-1, 4, 3)
    np.testing.assert_allclose(np.linalg.det((out[:, 1:] - out[:, :1]) / side), 1, atol=0.2)


def test_the_path_counts_and_not_only_its_end() -> None:
    points, end = scattered(200), shift(0.8, 0.8, 0)
    exact = DRAG | {"tolerance": 1e-9}
    straight = warped(points, end, **exact)
    assert off(straight, warped(points, shift(0.8, 0, 0), end, **exact)) > 0.05
    assert off(straight, warped(points, shift(0.4, 0.4, 0), end, **exact)) < 1e-6, "a stop on the way"
    np.testing.assert_array_equal(warped(points, end, end, **exact), straight)


def test_a_scaled_tool_reaches_farther() -> None:
    point, grown = np.array([(0, 0, 1.5)]), np.column_stack([2 * np.eye(3), (0.5, 0, 0)])
    np.testing.assert_array_equal(warped(point, shift(0.5, 0, 0), **DRAG), point)
    assert off(warped(point, grown, **DRAG), point) > 1e-3
    gone = np.column_stack([np.zeros((3, 3)), (0.5, 0, 0)])
    assert np.isfinite(warped(scattered(100), gone, **DRAG)).all()
