# SPDX-License-Identifier: GPL-3.0-or-later
"""Vector fields against SciPy's integrator and fields written from the formulas with derivatives by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import sinew_native as sn

FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))
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
    field = sn.VectorField(FRAME, inner=INNER, outer=OUTER, tolerance=1e-9)
    field.bind(points)

    def velocity(t, x):
        return field.velocities(posed, 0, t, x.reshape(-1, 3)).ravel()

    found = solve_ivp(velocity, (0.0, 1.0), points.ravel(), method="DOP853", rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(field.warp(posed), found.y[:, -1].reshape(-1, 3), atol=1e-7)


def test_tools_act_one_after_the_other() -> None:
    two = np.concatenate((FRAME, FRAME + (0.3, 0.0, 0.0)))
    posed = two + np.repeat(((0.0, 0.5, 0.0), (0.0, 0.0, -0.4)), 4, axis=0)
    points = np.random.default_rng(5).uniform(-1, 1, (300, 3))
    both = sn.VectorField(two, [1, 1], tools=["drag", "drag"], inner=[0.2, 0.1], outer=0.9)
    both.bind(points)
    first = sn.VectorField(two[:4], inner=0.2, outer=0.9)
    first.bind(points)
    second = sn.VectorField(two[4:], inner=0.1, outer=0.9)
    second.bind(first.warp(posed[:4]))
    np.testing.assert_allclose(both.warp(posed), second.warp(posed[4:]), atol=1e-14)
    assert both.tool_count == 2


def test_a_twist_counts_every_turn_of_the_path() -> None:
    """By the closed form: around, the width of 1.5 fades to nothing at twice that."""
    points = np.random.default_rng(4).uniform(-1.6, 1.6, (300, 3))
    for degrees in ([100.0], [150.0, 300.0, 450.0, 600.0, 750.0]):
        turns = np.radians(degrees)
        frames, words = np.tile(FRAME, (len(turns), 1)), {"inner": INNER, "outer": OUTER, "width": 1.5}
        field = sn.VectorField(frames, tools="twist", **words)
        field.bind(points)
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
    for frames in (unknown, apart):
        with pytest.raises(sn.InvalidConstraint):
            sn.VectorField(frames)
    for frames in (FRAME[:0], FRAME[:3]):
        with pytest.raises(sn.InvalidOption):
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
