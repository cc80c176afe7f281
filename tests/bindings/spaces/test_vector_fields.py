# SPDX-License-Identifier: GPL-3.0-or-later
"""What vector fields promise: rigid motions where they hold, volume, order and tolerance of their steps; and
fields written from the formulas with derivatives by hand, and SciPy's integrator.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import STILL, moved, off, shift, turn
from ..methods import bound_to

FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))
DRAG = {"tools": "drag", "inner": 0.4, "outer": 1.2, "width": 1.5}
TWIST = DRAG | {"tools": "twist"}
# A bend of wide things on a short way would squeeze what lies on its inner side.
BEND = {"tools": "bend", "inner": 0.2, "outer": 2.2, "width": 0.7}
SOME = turn((1, 2, -1), 70, move=(0.5, -0.3, 0.6))  # small enough to leave points in every region


def scattered(count: int, reach: float = 1.6) -> np.ndarray:
    return np.random.default_rng(4).uniform(-reach, reach, (count, 3))


def warped(points: np.ndarray, *poses: np.ndarray, **options: object) -> np.ndarray:
    field = bound_to(sn.VectorField(np.tile(FRAME, (len(poses), 1)), **options), points)
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
    points, move = scattered(100, 0.5), np.array((0.3, 0.7, -0.2))
    options = DRAG | {"inner": 2.0, "outer": 3.0, "order": order, "steps": 3}
    out = warped(points, shift(*move), **options)
    np.testing.assert_allclose(out, points + move, rtol=0, atol=1e-14)
    field = sn.VectorField(FRAME, **options)
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


def test_a_scaled_tool_reaches_farther_and_one_about_another_axis_does_nothing() -> None:
    point, grown = np.array([(0, 0, 1.5)]), np.column_stack([2 * np.eye(3), (0.5, 0, 0)])
    np.testing.assert_array_equal(warped(point, shift(0.5, 0, 0), **DRAG), point)
    assert off(warped(point, grown, **DRAG), point) > 1e-3
    points = scattered(100)  # a turn about another axis is no twist and no bend
    np.testing.assert_array_equal(warped(points, turn((0, 0, 1), 80), **BEND), points)
    np.testing.assert_allclose(warped(points, turn((1, 0, 0), 80), **TWIST), points, rtol=0, atol=1e-12)
    gone = np.column_stack([np.zeros((3, 3)), (0.5, 0, 0)])
    assert np.isfinite(warped(scattered(100), gone, **DRAG)).all()


INNER, OUTER = 0.4, 1.2


def rotation(vector) -> np.ndarray:
    return Rotation.from_rotvec(vector).as_matrix()


def share(u: np.ndarray) -> np.ndarray:
    u = np.clip(u, 0.0, 1.0)
    return 4 * u**3 * (1 - u) + u**4


def differences(function, x: np.ndarray, step: float) -> list[np.ndarray]:
    """Of each axis the central difference along it."""
    return [(function(x + step * axis) - function(x - step * axis)) / (2 * step) for axis in np.eye(3)]


def curl(potential, x: np.ndarray) -> np.ndarray:
    """Of a vector potential (n, 3) -> (n, 3)."""
    d = differences(potential, x, 1e-5)
    return np.stack((d[1][:, 2] - d[2][:, 1], d[2][:, 0] - d[0][:, 2], d[0][:, 1] - d[1][:, 0]), axis=1)


def drag_field(move: np.ndarray, turn: np.ndarray):
    """grad p x grad q, from p and q themselves: curl(p grad q) for the move, and beta w x y for the turn."""

    def field(t: float, x: np.ndarray) -> np.ndarray:
        y = x - t * move
        across = np.linalg.svd(move[None])[2][1:]  # two unit vectors across the move
        sign = np.sign(np.linalg.det(np.vstack((across, move))))

        def beta(z):
            return 1 - share((np.linalg.norm(z, axis=1) - INNER) / (OUTER - INNER))

        p = differences(lambda z: beta(z) * (z @ across[0]) * np.linalg.norm(move) * sign, y, 1e-6)
        q = differences(lambda z: beta(z) * (z @ across[1]), y, 1e-6)
        return np.cross(p, q, axis=0).T + beta(y)[:, None] * np.cross(turn, y)

    return field


def test_the_field_of_a_drag_is_the_product_of_two_gradients() -> None:
    move, turn = np.array((0.5, -0.3, 0.6)), 0.8 * np.array((2.0, 1.0, -2.0)) / 3.0
    posed = FRAME @ rotation(turn).T + move
    points = np.random.default_rng(1).uniform(-1.3, 1.3, (500, 3))
    field = sn.VectorField(FRAME, inner=INNER, outer=OUTER)
    assert field.piece_count(posed) == 1
    for time in (0.0, 0.4, 1.0):
        expected = drag_field(move, turn)(time, points)
        # Differences over 1e-6 are good to 1e-9, but for the points within that of a kink: there are none.
        np.testing.assert_allclose(field.velocities(posed, 0, time, points), expected, atol=1e-8)


def test_the_field_of_a_bend_is_the_curl_of_its_potential() -> None:
    angle = 0.7
    posed = FRAME @ rotation((angle, 0, 0)).T
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (500, 3))
    field = sn.VectorField(FRAME, tools="bend", inner=-0.5, outer=0.8, width=0.6)
    for time in (0.0, 0.5, 1.0):
        own = rotation((time * angle, 0, 0))[:, 2]
        halfway = rotation((0.5 * time * angle, 0, 0))[:, 2]
        w = angle * np.eye(3)[0]

        def potential(x, own=own, halfway=halfway, w=w):
            h = x @ own
            out = x - h[:, None] * own
            n2 = (out**2).sum(1) - out[:, 0] ** 2
            full = share((x @ halfway + 0.5) / 1.3) * (1 - share(np.linalg.norm(out, axis=1) / 0.6 - 1))
            return full[:, None] * ((h * (x @ w))[:, None] * own - 0.5 * n2[:, None] * w)

        expected = curl(potential, points)
        np.testing.assert_allclose(field.velocities(posed, 0, time, points), expected, atol=1e-7)


@pytest.mark.parametrize("turned", [False, True])
def test_the_flow_is_that_of_scipy(turned: bool) -> None:
    move, turn = np.array((0.9, 0.2, -0.4)), np.array((0.0, 0.9, 0.3)) * turned
    posed = FRAME @ rotation(turn).T + move
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (150, 3))
    field = bound_to(sn.VectorField(FRAME, inner=INNER, outer=OUTER, tolerance=1e-9), points)

    def velocity(t, x):
        return field.velocities(posed, 0, t, x.reshape(-1, 3)).ravel()

    found = solve_ivp(velocity, (0.0, 1.0), points.ravel(), method="DOP853", rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(field.warp(posed), found.y[:, -1].reshape(-1, 3), atol=1e-7)


def test_tools_act_one_after_the_other() -> None:
    two = np.concatenate((FRAME, FRAME + (0.3, 0.0, 0.0)))
    posed = two + np.repeat(((0.0, 0.5, 0.0), (0.0, 0.0, -0.4)), 4, axis=0)
    points = np.random.default_rng(5).uniform(-1, 1, (300, 3))
    both = bound_to(sn.VectorField(two, [1, 1], tools=["drag", "drag"], inner=[0.2, 0.1], outer=0.9), points)
    first = bound_to(sn.VectorField(two[:4], inner=0.2, outer=0.9), points)
    second = bound_to(sn.VectorField(two[4:], inner=0.1, outer=0.9), first.warp(posed[:4]))
    np.testing.assert_allclose(both.warp(posed), second.warp(posed[4:]), atol=1e-14)
    assert both.tool_count == 2


def test_a_twist_counts_every_turn_of_the_path() -> None:
    """By the closed form: around, the width of 1.5 fades to nothing at twice that."""
    points = np.random.default_rng(4).uniform(-1.6, 1.6, (300, 3))
    for degrees in ([100.0], [150.0, 300.0, 450.0, 600.0, 750.0]):
        turns = np.radians(degrees)
        frames, words = np.tile(FRAME, (len(turns), 1)), {"inner": INNER, "outer": OUTER, "width": 1.5}
        field = bound_to(sn.VectorField(frames, tools="twist", **words), points)
        found = field.warp(np.concatenate([FRAME @ rotation((0, 0, angle)).T for angle in turns]))
        around = np.linalg.norm(points[:, :2], axis=1)
        part = share((points[:, 2] - INNER) / (OUTER - INNER)) * (1 - share(around / 1.5 - 1))
        expected = [rotation((0, 0, turns[-1] * s)) @ x for s, x in zip(part, points)]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


def test_refusals_name_tools() -> None:
    flat = FRAME.copy()
    flat[3] = 0.0
    unknown = FRAME * (1, 1, np.nan)
    with pytest.raises(sn.InvalidConstraint, match="flat") as refused:
        sn.VectorField(np.concatenate((FRAME, flat)), [1, 1])
    assert (refused.value.element_kind, list(refused.value.elements)) == ("handle", [1])
    apart = np.concatenate((FRAME, FRAME + (1, 0, 0)))  # at rest, the frames of a path are one
    unfit = [(sn.InvalidConstraint, unknown), (sn.InvalidConstraint, apart)]
    for error, frames in (*unfit, (sn.InvalidOption, FRAME[:0]), (sn.InvalidOption, FRAME[:3])):
        with pytest.raises(error):
            sn.VectorField(frames)
    wrong_values = {"tools": "pull", "order": 3, "inner": 2.0, "outer": [1.0, 2.0, 3.0], "counts": [2]}
    # An inner radius below zero means nothing to a drag.
    for wrong in [*wrong_values.items(), ("inner", -0.1), ("counts", [1, 0])]:
        with pytest.raises(sn.InvalidOption):
            sn.VectorField(FRAME, **dict([wrong]))
    field = sn.VectorField(FRAME)
    assert field.piece_count(FRAME) == 0
    with pytest.raises(sn.InvalidConstraint):
        field.velocities(FRAME, 0, 0.5, FRAME)
