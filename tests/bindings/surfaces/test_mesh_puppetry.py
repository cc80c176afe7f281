# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons: against SciPy on the same residuals, random targets, and the skin that follows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import carried, moved, tube

UP = np.array([0.0, 0.0, 1.0])


def chain(count: int, **limits) -> sn.Skeleton:
    """Bones of length 1 along z, with the axes of the world."""
    heads = np.outer(np.arange(count), UP)
    axes = np.broadcast_to(np.eye(3), (count, 3, 3))
    return sn.Skeleton(heads, heads + UP, np.arange(count) - 1, axes=axes, **limits)


def residuals(turns, goal, bones, stiff=None, angles=False) -> np.ndarray:
    """How far the tip is from its goal, as a share of the size, and how far each bone turns, all by SciPy."""
    turns, tip, turn = turns.reshape(-1, 3), np.zeros(3), Rotation.identity()
    for own, bone in zip(turns, bones, strict=True):
        turn = turn * (Rotation.from_euler("xyz", own) if angles else Rotation.from_rotvec(own))
        tip = tip + turn.apply(bone)
    size = np.linalg.norm(np.ptp([np.zeros(3), *np.cumsum(bones, axis=0)], axis=0))
    kept = turns if stiff is None else np.einsum("kij,kj->ki", stiff, turns)
    return np.concatenate([(tip - goal) / size, 1e-2 * kept.ravel()])


def expect_minimum(found: tuple, start: np.ndarray, *of: object, angles: bool = False, **bounds: object):
    """The energy is that of the residuals, and SciPy finds none that is less, as closely as it can."""
    turns, _moves, report = found
    own, closely = residuals(turns, *of, angles=angles), {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-12}
    words = {"args": of, "kwargs": {"angles": angles}} | closely | bounds
    theirs = least_squares(residuals, start.ravel(), **words)
    assert report.energy == pytest.approx(0.5 * own @ own, rel=1e-12)
    assert report.energy == pytest.approx(theirs.cost, rel=1e-9)
    return report, theirs.x


@pytest.mark.slow
@pytest.mark.parametrize("goal", [(1.8, 0.0, 2.6), (0.5, -1.2, 3.0), (5.0, 2.0, 1.0), (-1.0, 2.0, -1.5)])
@pytest.mark.parametrize("pole", [0.05, 0.2, 0.4])
def test_the_minimum_is_scipys_from_unrelated_starts(goal, pole):
    found = chain(4).solve([3], [4 * UP], [goal], max_iterations=500, tolerance=1e-13, pole=pole)
    report, theirs = expect_minimum(found, np.outer(np.ones(4), (1e-3, 0, 0)), goal, [UP] * 4)
    assert report.converged
    np.testing.assert_allclose(found[0].ravel(), theirs, atol=5e-4)  # flat along what rest alone decides


@pytest.mark.parametrize("goal", [(0.5, 1.0, 1.5), (1.5, -0.5, 1.0), (-0.5, -1.5, -1.0), (2.0, 3.0, 1.0)])
@pytest.mark.parametrize("swing", [0.0, 1.0, 5.0])
def test_what_turns_aside_of_a_hinge_counts_more(goal, swing):
    joints = np.array([(0, 0, 0), (0, 0.3, 1), (0, 0, 2), (0.2, -0.1, 3)], dtype=float)
    bones, axes = np.diff(joints, axis=0), np.broadcast_to(np.eye(3), (3, 3, 3))
    stiff = [np.eye(3)]
    for bend in np.cross(bones[:-1], bones[1:]):
        hinge = np.outer(bend, bend) / (bend @ bend)
        stiff.append(hinge + np.sqrt(1 + swing) * (np.eye(3) - hinge))
    skeleton = sn.Skeleton(joints[:-1], joints[1:], np.arange(3) - 1, axes=axes)
    found = skeleton.solve([2], [joints[-1]], [goal], swing=swing, tolerance=1e-13)
    assert expect_minimum(found, found[0], goal, bones, stiff)[0].converged


@pytest.mark.parametrize("goal", [(1.0, 0.5, 3.0), (3.0, 0.0, 1.0), (-0.4, -2.0, 2.0), (0.0, 0.0, 2.5)])
def test_the_minimum_within_bounds_is_scipys(goal):
    lower, upper = np.array([-0.5, -0.4, -0.1]), np.array([0.7, 0.6, 0.2])
    skeleton = chain(4, angles=dict.fromkeys(range(4), (lower, upper, "XYZ")))
    found = skeleton.solve([3], [4 * UP], [goal], max_iterations=500, tolerance=1e-13)
    assert ((found[0] >= lower) & (found[0] <= upper)).all()
    # Within limits there are several minima. From next to ours, SciPy finds nothing better.
    start, bounds = np.clip(found[0], lower * 0.999, upper * 0.999), (np.tile(lower, 4), np.tile(upper, 4))
    expect_minimum(found, start, goal, [UP] * 4, angles=True, bounds=bounds)


def test_rotations_and_turns_are_those_of_scipy():
    orders = ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]
    free = (np.full(3, -np.inf), np.full(3, np.inf))
    skeleton = chain(7, angles={bone: (*free, order) for bone, order in enumerate(orders)})
    turns = np.random.default_rng(3).uniform(-1.5, 1.5, (7, 3))
    rotations = skeleton.rotations(turns)
    for bone, order in enumerate(orders):
        by_order = ["XYZ".index(axis) for axis in order]
        expected = Rotation.from_euler(order.lower(), turns[bone][by_order]).as_matrix()
        np.testing.assert_allclose(rotations[bone], expected, atol=1e-14)
    np.testing.assert_allclose(rotations[6], Rotation.from_rotvec(turns[6]).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(skeleton.turns(rotations), turns, atol=1e-13)
    turns[0] = 0.4, np.pi / 2, -0.3  # two axes are one: there are many angles, and one of them is given
    rotations = skeleton.rotations(turns)
    np.testing.assert_allclose(skeleton.rotations(skeleton.turns(rotations)), rotations, atol=1e-13)


BONES = st.integers(2, 12)
SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=150)
@given(count=BONES, seed=SEEDS, far=st.sampled_from([0.1, 1.0, 10.0, 1e6]), balance=st.booleans())
def test_limits_and_lengths_hold_for_random_targets(count, seed, far, balance):
    rng = np.random.default_rng(seed)
    heads, tails, parents = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count, dtype=int)
    for bone in range(count):
        parents[bone] = rng.integers(-1, bone) if bone else -1
        heads[bone] = rng.normal(size=3)
        if parents[bone] >= 0:
            heads[bone] = tails[parents[bone]] + 0.1 * heads[bone]
        tails[bone] = heads[bone] + rng.normal(size=3) * rng.choice([0.01, 1.0])
    most = rng.choice([0.0, 0.3, 2.0, np.inf], count)
    limits = {}
    for bone in np.flatnonzero(rng.random(count) < 0.4):
        ends = np.sort(rng.uniform(-2, 2, (2, 3)), axis=0)
        ends[1] = np.where(rng.random(3) < 0.2, ends[0], ends[1])  # a locked axis
        limits[int(bone)] = (ends[0], ends[1], str(rng.choice(["XYZ", "ZXY", "YZX"])))
    skeleton = sn.Skeleton(heads, tails, parents, most=most, angles=limits)
    targets = rng.integers(0, count, rng.integers(1, 5))
    turns, moves, report = skeleton.solve(
        targets,
        tails[targets],
        far * rng.normal(size=(len(targets), 3)),
        weights=rng.choice([1.0, 1e3], len(targets)),
        moving_roots=rng.random(count) < 0.5,
        turns=rng.uniform(-3, 3, (count, 3)),
        support=rng.normal(size=(5, 3)) if balance else None,
    )
    assert np.isfinite([*turns.ravel(), *moves.ravel(), report.energy]).all()
    for bone, turn in enumerate(turns):
        if bone in limits:
            assert ((turn >= limits[bone][0]) & (turn <= limits[bone][1])).all()
        else:
            assert np.linalg.norm(turn) <= most[bone] * (1 + 1e-15)
    joined, poses = parents >= 0, skeleton.poses(turns, moves)
    assert (moves[joined] == 0).all()
    lengths = np.linalg.norm(carried(poses, tails) - carried(poses, heads), axis=1)
    # Far from the origin, places round to their own size.
    rounding = 1e-12 * max(1.0, np.abs(poses).max())
    np.testing.assert_allclose(lengths, np.linalg.norm(tails - heads, axis=1), atol=rounding)
    on_parent = carried(poses[parents], heads)
    np.testing.assert_allclose(carried(poses, heads)[joined], on_parent[joined], atol=rounding)


def test_masses_count_where_a_support_holds_the_centre_of_mass():
    """A heavy foot lets the rest lean."""
    corners = np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)])
    loose, held, light = (
        chain(4).solve([3], [4 * UP], [(1.8, 0.0, 2.6)], **words)[2]
        for words in ({}, {"support": corners}, {"support": corners, "masses": [100.0, 1, 1, 1]})
    )
    assert 0.199 < held.centre[0] <= 0.2
    assert held.overhang == 0.0
    assert max(loose.energy, light.energy) < held.energy


def test_poses_of_a_skeleton_are_poses_of_handles():
    points, faces = tube(32, 16)
    points = points[:, [1, 2, 0]] * (0.5, 0.5, 0.25)
    mesh = sn.SurfaceMesh(points, faces)
    skeleton = sn.Skeleton([(0, 0, 0), (0, 0, 4)], [(0, 0, 4), (0, 0, 8)], [-1, 0])
    regions = skeleton.regions(mesh)
    assert [len(region) for region in regions] == [13 * 16, 13 * 16]
    skin = sn.MeshPuppetry(mesh)
    skin.set_handles(regions)
    turns, moves, _ = skeleton.solve([1], [(0, 0, 8)], [(4, 0, 4)])
    poses = skeleton.poses(turns, moves)
    shown, report = skin.solve(poses)
    assert report.converged
    assert report.iterations <= 10
    for region, pose in zip(regions, poses, strict=True):
        np.testing.assert_allclose(shown[region], moved(pose, points[region]), atol=1e-12)
    # The joint is a smooth bend: no edge along the tube turns against the next one by more than a part of it.
    steps = np.diff(shown.reshape(33, 16, 3).mean(axis=1), axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    assert np.degrees(np.arccos((steps[1:] * steps[:-1]).sum(axis=1).min())) < 45


NOTHING, CONSTRAINT, OPTION = np.zeros((0, 3)), sn.InvalidConstraint, sn.InvalidOption


@pytest.mark.parametrize(
    ("error", "words", "given"),
    [
        (CONSTRAINT, "the skeleton has no bones", {"heads": NOTHING, "tails": NOTHING, "parents": []}),
        (CONSTRAINT, "", {"parents": [-1, 0]}),
        (CONSTRAINT, "", {"tails": [(0, 0, 0)]}),  # no length
        (CONSTRAINT, "", {"tails": [(np.nan, 0, 1)]}),
        (CONSTRAINT, "bone 0: its parent 0 is no earlier bone", {"parents": [0]}),
        (CONSTRAINT, "", {"parents": [-2]}),
        (CONSTRAINT, "", {"axes": [2 * np.eye(3)]}),
        (CONSTRAINT, "", {"axes": [-np.eye(3)]}),
        (OPTION, "", {"most": -1.0}),
        (OPTION, "", {"stiffness": 0.0}),
        (OPTION, "the lower limit about y is above", {"angles": {0: ((0, 1, 0), (0, 0, 0), "XYZ")}}),
        (OPTION, "order", {"angles": {0: ((0, 0, 0), (0, 0, 0), "XYY")}}),
        (OPTION, "'AB' is not one of three axes", {"angles": {0: ((0, 0, 0), (0, 0, 0), "AB")}}),
        (CONSTRAINT, "there is no bone 4", {"angles": {4: ((0, 0, 0), (0, 0, 0), "XYZ")}}),
        (TypeError, "tuple", {"angles": {0: [0, 1]}}),
    ],
)
def test_skeletons_that_are_none_are_refused(error: type, words: str, given: dict) -> None:
    with pytest.raises(error, match=words or None):
        sn.Skeleton(**{"heads": [(0, 0, 0)], "tails": [UP], "parents": [-1]} | given)


@pytest.mark.parametrize(
    ("error", "words", "given"),
    [
        (CONSTRAINT, "target 0: there is no bone 3", {"bones": [3]}),
        (CONSTRAINT, "differ", {"bones": [0, 1]}),
        (CONSTRAINT, "target 0: its point or its goal is not finite", {"goals": [(np.nan, 0, 2)]}),
        (CONSTRAINT, "target 0: its weight is not a positive number", {"weights": 0.0}),
        (CONSTRAINT, "", {"locked": [True]}),
        (CONSTRAINT, "", {"turns": np.zeros((1, 3))}),
        (CONSTRAINT, "", {"support": np.zeros((3, 3))}),
        (CONSTRAINT, "support has no area", {"support": [UP, 2 * UP, 3 * UP]}),
        (CONSTRAINT, "", {"support": np.eye(3), "up": (0, 0, 0)}),
        (CONSTRAINT, "", {"support": np.eye(3), "masses": [1, 2]}),
        (CONSTRAINT, "", {"support": np.eye(3), "masses": [0, 0, 0]}),
        (CONSTRAINT, "", {"support": np.eye(3), "masses": [1, -1, 1]}),
        (OPTION, "rest", {"rest": -1.0}),
        (OPTION, "max_iterations", {"max_iterations": 0}),
        (OPTION, "swing", {"swing": -1.0}),
    ],
)
def test_requests_that_mean_nothing_are_refused(error: type, words: str, given: dict) -> None:
    with pytest.raises(error, match=words or None):
        chain(3).solve(**{"bones": [2], "points": [3 * UP], "goals": [(1, 0, 2)]} | given)


def test_a_skeleton_says_what_it_is_and_refuses_turns_and_margins_that_do_not_fit():
    skeleton = chain(3)
    assert repr(skeleton) == "<Skeleton: 3 bones>"
    with pytest.raises(CONSTRAINT, match="2 rows"):
        skeleton.poses(np.zeros((2, 3)))
    with pytest.raises(CONSTRAINT):
        skeleton.turns(np.zeros((4, 3, 3)))
    for margin in (-0.1, 0.5):
        with pytest.raises(OPTION, match="margin"):
            skeleton.regions(sn.SurfaceMesh([UP, 2 * UP, (1, 0, 0)], [[0, 1, 2]]), margin=margin)
