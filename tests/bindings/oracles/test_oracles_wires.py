# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires against a loop over them in NumPy, which follows the paper step by step."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sinew_native as sn


def by_numpy(points, rest, posed, radius: float, scale: float = 1.0, rotation: float = 1.0) -> np.ndarray:
    """The moves D_i (n, 3) by one wire, with the rule of the nearest place."""
    sides = np.diff(rest, axis=0)
    along = np.einsum("nsk,sk->ns", points[:, None] - rest[:-1], sides) / (sides**2).sum(1)
    along = np.clip(along, 0.0, 1.0)
    feet = rest[:-1] + along[..., None] * sides
    near = np.linalg.norm(points[:, None] - feet, axis=2).argmin(1)
    row = np.arange(len(points))
    t = along[row, near][:, None]

    def at(curve):
        return (1 - t) * curve[near] + t * curve[near + 1]

    def tangents(curve):
        ends = np.concatenate((curve[:1], curve, curve[-1:]))
        found = ends[2:] - ends[:-2]
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    before, after = tangents(rest), tangents(posed)
    axes = np.cross(before, after)
    sine = np.linalg.norm(axes, axis=1, keepdims=True)
    angle = np.arctan2(sine, (before * after).sum(1, keepdims=True))
    turns = rotation * angle * np.divide(axes, sine, out=np.zeros_like(axes), where=sine > 0)
    from_wire, turn, move = points - at(rest), at(turns), at(posed - rest)
    share = np.clip(np.linalg.norm(from_wire, axis=1, keepdims=True) / radius, 0.0, 1.0)
    F = (1 - share**2) ** 2
    scaled = from_wire * (1 + (scale - 1) * F)
    return Rotation.from_rotvec(F * turn).apply(scaled) - from_wire + F * move


@pytest.mark.parametrize("exponent", [0.0, 1.0, 3.0])
def test_several_wires_are_those_of_the_loop(exponent: float) -> None:
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 1, (2000, 3))
    rest = [np.cumsum(rng.normal(0, 0.2, (9, 3)), axis=0) for _ in range(4)]
    posed = [wire + rng.normal(0, 0.2, wire.shape) for wire in rest]
    if exponent:
        posed[3] = rest[3]  # which holds nothing back; without an exponent, all in reach count alike
    radius, scale, rotation = [0.9, 0.6, 1.2, 1.5], [1.0, 1.8, 0.4, 1.0], [1.0, 0.3, 0.0, 1.0]
    moves = [by_numpy(points, *each) for each in zip(rest, posed, radius, scale, rotation, strict=True)]
    lengths = np.linalg.norm(moves, axis=2, keepdims=True)
    weights = (lengths > 0) * lengths**exponent
    expected = points + (weights * moves).sum(0) / np.maximum(weights.sum(0), 1e-300)
    words = {"radius": radius, "scale": scale, "rotation": rotation, "exponent": exponent, "smoothing": 0.0}
    found = warped(np.concatenate(rest), np.concatenate(posed), points, [9, 9, 9, 9], **words)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_beside_a_straight_wire_there_is_nothing_to_smooth() -> None:
    rest = np.linspace((-5, 0, 0), (5, 0, 0), 41)
    points, posed = np.random.default_rng(3).uniform(-1.5, 1.5, (300, 3)), rest + (0, 1, 0)
    found = warped(rest, posed, points, radius=1.25)
    np.testing.assert_allclose(found - points, by_numpy(points, rest, posed, 1.25), atol=1e-14)


def test_counts_flags_and_values_come_as_numbers_or_one_per_curve() -> None:
    line = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0)])
    twice = np.concatenate((line, line + (0, 0, 3)))
    wires = sn.Wires(twice, [3, 3], closed=[True, False], radius=[1.0, 2.0], domain=np.full((6, 3), np.nan))
    assert (wires.curve_count, wires.sample_count) == (2, 6)
    wrong = {"radius": [1.0, 2.0, 3.0], "closed": [True, False, True], "domain": line, "rotation": 2.0}
    for name, value in (*wrong.items(), ("counts", [3, 2]), ("counts", [5, 1])):
        with pytest.raises(sn.Error):
            sn.Wires(twice, **{"counts": [3, 3], name: value})
    for few in (line[:0], line[:1]):
        with pytest.raises(sn.Error):
            sn.Wires(few)
    with pytest.raises(sn.InvalidConstraint, match="no length") as refused:
        sn.Wires(np.concatenate((line, np.ones((3, 3)))), [3, 3])
    assert (refused.value.element_kind, list(refused.value.elements)) == ("handle", [1])
    with pytest.raises(sn.InvalidConstraint) as refused:
        sn.Wires([*line, (0, np.inf, 0)])
    assert (refused.value.element_kind, list(refused.value.elements)) == ("vertex", [3])


def arc(samples: int) -> np.ndarray:
    """A quarter of the unit circle in the plane z = 0, from +x to +y."""
    angles = np.linspace(0, np.pi / 2, samples)
    return np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


def warped(rest: np.ndarray, posed: np.ndarray, points, counts=None, **options: object) -> np.ndarray:
    wires = sn.Wires(rest, counts, **options)
    wires.bind(np.array(points, float))
    return wires.warp(posed)


@pytest.mark.parametrize("smoothing", [0.0, 0.2, 1.0])
def test_points_on_a_wire_follow_it_and_those_outside_stay(smoothing: float) -> None:
    rest, outside = arc(9), np.array([(1.51, 0, 0), (-1, -1, 0)])
    posed = rest + np.random.default_rng(1).uniform(-1, 1, rest.shape)
    found = warped(rest, posed, [*rest, *outside], radius=0.5, scale=3.0, smoothing=smoothing)
    np.testing.assert_allclose(found[:9], posed, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(found[9:], outside)


def test_smoothing_joins_where_the_nearest_point_jumps() -> None:
    """A V, whose legs are equally near on the plane x = 0. The left one moves down, the right one up."""
    rest = np.array([(-1.0, 1, 0), (0, 0, 0), (1, 1, 0)])
    posed = rest + np.outer((-1, 0, 1), (0, 0, 1))

    def jump(step: float, smoothing: float) -> float:
        sides = [(-step, 0.8, 0), (step, 0.8, 0)]
        left, right = warped(rest, posed, sides, rotation=0.0, smoothing=smoothing)
        return np.linalg.norm(right - left)

    assert jump(1e-7, 0.0) > 0.3, "the rule of the paper tears"
    jumps = [jump(10.0**-k, 0.2) for k in range(2, 9)]
    assert all(later < 0.11 * former for former, later in itertools.pairwise(jumps))


def test_a_walk_past_every_curve_has_no_jump() -> None:
    """Halving the step halves the longest difference."""
    rng, longest = np.random.default_rng(8), []
    rest = rng.uniform(-1, 1, (24, 3))
    posed = rest + rng.uniform(-0.3, 0.3, rest.shape)
    for steps in (200_000, 400_000):
        walk = np.linspace((-1, -0.7, 0.2), (1, 0.8, -0.1), steps + 1)
        found = warped(rest, posed, walk, [12, 12], radius=0.7)
        longest.append(np.linalg.norm(np.diff(found, axis=0), axis=1).max())
    assert longest[1] < 0.6 * longest[0]


def test_a_domain_curve_limits_the_wire_on_its_side_and_a_closed_wire_has_a_last_segment() -> None:
    rest = np.linspace((-5, 0, 0), (5, 0, 0), 21)
    points = np.array([(0, 0.5, 0), (0, 0.7, 0), (0, 0.25, 0), (0, -0.5, 0), (0, 0, -0.5)])
    found = warped(rest, rest + (0, 0, 1), points, domain=rest + (0, 0.5, 0), smoothing=0.0)
    half = 0.5625  # f(1/2)
    np.testing.assert_allclose((found - points)[:, 2], (0, 0, half, half, half), rtol=0, atol=1e-14)
    corner, point = np.array([(0.0, 0, 0), (4, 0, 0), (0, 4, 0)]), np.array([(0.0, 2, 0)])
    for closed, height in ((False, 0), (True, 1)):
        found = warped(corner, corner + (0, 0, 1), point, closed=[closed])
        np.testing.assert_allclose(found, point + (0, 0, height), rtol=0, atol=1e-15)


@pytest.mark.parametrize("fewer", [0, 1, 2, 3])
def test_a_point_moves_the_same_alone_and_among_many(fewer: int) -> None:
    """Points are bound in slabs, and contacts packed by fours: the packs end elsewhere in each of these."""
    rest = np.concatenate([arc(40), np.linspace((-1, -0.5, 0.5), (1, -0.5, 0.5), 9)])
    posed, options = rest + 0.3 * rest[:, :1] * (0, 0, 1), {"closed": [True, False], "radius": [0.8, 0.6]}
    many = np.random.default_rng(3).uniform(-1.5, 1.5, (70000, 3))[fewer:]
    found = warped(rest, posed, many, [40, 9], **options)
    for i in (0, 1, 2, 3, *range(65533, 65539), 69990):
        np.testing.assert_array_equal(warped(rest, posed, many[i : i + 1], [40, 9], **options)[0], found[i])


def test_doubled_samples_and_turned_wires_stay_finite() -> None:
    rest = np.outer((0, 1, 1, 2, 3), (1.0, 0, 0))
    points = np.random.default_rng(3).uniform(-2, 2, (200, 3))
    for posed in (rest[::-1], 0 * rest):  # turned round, and contracted to a point
        assert np.isfinite(warped(rest, posed.copy(), points, radius=2.0)).all()


def test_wires_say_what_they_cost() -> None:
    points = np.random.default_rng(3).uniform(-0.5, 0.5, (1000, 3))
    points[500:, 2] += 10
    cost = sn.Wires(np.array([(-9.0, 0, 0), (9, 0, 0)])).bind(points).weight_bytes
    # In reach: 44 bytes and two samples of 12; each point: 4 bytes; and one more of each list.
    assert cost == 500 * (46 + 2 * 8) + 1001 * 4 + 8
