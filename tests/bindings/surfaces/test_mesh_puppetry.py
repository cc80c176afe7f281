# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons: against SciPy on the same residuals, random targets, and the skin that follows."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import bar

UP = np.array([0.0, 0.0, 1.0])


def chain(count: int, **limits) -> sn.Skeleton:
    """Bones of length 1 along z, with the axes of the world."""
    heads = np.outer(np.arange(count), UP)
    axes = np.broadcast_to(np.eye(3), (count, 3, 3))
    return sn.Skeleton(heads, heads + UP, np.arange(count) - 1, axes=axes, **limits)


def joints_of(rotations: list[Rotation]) -> np.ndarray:
    """Where the heads and the last tail of a chain are (count + 1, 3): forward kinematics by SciPy."""
    place, turn, places = np.zeros(3), Rotation.identity(), [np.zeros(3)]
    for rotation in rotations:
        turn = turn * rotation
        place = place + turn.apply(UP)
        places.append(place)
    return np.array(places)


def energy_and_residuals(turns, goal, count, rest=1e-4, angles=False):
    turns = turns.reshape(count, 3)
    rotations = [Rotation.from_euler("xyz", t) if angles else Rotation.from_rotvec(t) for t in turns]
    residuals = np.concatenate(
        ((joints_of(rotations)[-1] - goal) / count, np.sqrt(rest) * turns.ravel())  # the size of the chain
    )
    return 0.5 * residuals @ residuals, residuals


def least(residuals: Callable, start: np.ndarray, **bounds):
    """By SciPy, as closely as it can."""
    return least_squares(residuals, start.ravel(), xtol=1e-15, ftol=1e-15, gtol=1e-12, **bounds)


@pytest.mark.slow
@pytest.mark.parametrize("goal", [(1.8, 0.0, 2.6), (0.5, -1.2, 3.0), (5.0, 2.0, 1.0), (-1.0, 2.0, -1.5)])
@pytest.mark.parametrize("pole", [0.05, 0.2, 0.4])
def test_the_minimum_is_scipys_from_unrelated_starts(goal, pole):
    count = 4
    turns, _moves, report = chain(count).solve(
        [count - 1], [count * UP], [goal], max_iterations=500, tolerance=1e-13, pole=pole
    )
    start = np.zeros((count, 3))
    start[:, 0] = 1e-3
    theirs = least(lambda x: energy_and_residuals(x, np.array(goal), count)[1], start)
    assert report.converged
    energy, _ = energy_and_residuals(turns, np.array(goal), count)
    assert report.energy == pytest.approx(energy, rel=1e-12)  # the same function
    assert report.energy == pytest.approx(theirs.cost, rel=1e-9)  # the same minimum
    np.testing.assert_allclose(turns.ravel(), theirs.x, atol=5e-4)  # flat along what rest alone decides


@pytest.mark.parametrize("goal", [(0.5, 1.0, 1.5), (1.5, -0.5, 1.0), (-0.5, -1.5, -1.0), (2.0, 3.0, 1.0)])
@pytest.mark.parametrize("swing", [0.0, 1.0, 5.0])
def test_what_turns_aside_of_a_hinge_counts_more(goal, swing):
    joints = np.array([(0, 0, 0), (0, 0.3, 1), (0, 0, 2), (0.2, -0.1, 3)], dtype=float)
    bones, count = np.diff(joints, axis=0), 3
    skeleton = sn.Skeleton(
        joints[:-1], joints[1:], np.arange(count) - 1, axes=np.broadcast_to(np.eye(3), (count, 3, 3))
    )
    size = np.linalg.norm(np.ptp(joints, axis=0))
    stiff = [np.eye(3)]
    for bend in np.cross(bones[:-1], bones[1:]):
        hinge = np.outer(bend, bend) / (bend @ bend)
        stiff.append(hinge + np.sqrt(1 + swing) * (np.eye(3) - hinge))

    def residuals(turns):
        turns, tip, turn = turns.reshape(count, 3), np.zeros(3), Rotation.identity()
        for own, bone in zip(turns, bones, strict=True):
            turn = turn * Rotation.from_rotvec(own)
            tip = tip + turn.apply(bone)
        kept = [k @ own for k, own in zip(stiff, turns, strict=True)]
        return np.concatenate([(tip - goal) / size, 1e-2 * np.ravel(kept)])

    turns, _moves, report = skeleton.solve([2], [joints[-1]], [goal], swing=swing, tolerance=1e-13)
    theirs = least(residuals, turns)
    assert report.converged
    assert report.energy == pytest.approx(
        0.5 * residuals(turns.ravel()) @ residuals(turns.ravel()), rel=1e-12
    )
    assert report.energy == pytest.approx(theirs.cost, rel=1e-9)


@pytest.mark.parametrize("goal", [(1.0, 0.5, 3.0), (3.0, 0.0, 1.0), (-0.4, -2.0, 2.0), (0.0, 0.0, 2.5)])
def test_the_minimum_within_bounds_is_scipys(goal):
    count, lower, upper = 4, np.array([-0.5, -0.4, -0.1]), np.array([0.7, 0.6, 0.2])
    angles = dict.fromkeys(range(count), (lower, upper, "XYZ"))
    turns, _moves, report = chain(count, angles=angles).solve(
        [count - 1], [count * UP], [goal], max_iterations=500, tolerance=1e-13
    )
    # Within limits there are several minima. From next to ours, SciPy finds nothing better.
    theirs = least(
        lambda x: energy_and_residuals(x, np.array(goal), count, angles=True)[1],
        np.clip(turns, lower * 0.999, upper * 0.999),
        bounds=(np.tile(lower, count), np.tile(upper, count)),
    )
    assert (turns >= lower).all()
    assert (turns <= upper).all()
    energy, _ = energy_and_residuals(turns, np.array(goal), count, angles=True)
    assert report.energy == pytest.approx(energy, rel=1e-12)
    assert report.energy == pytest.approx(theirs.cost, rel=1e-9)


def test_rotations_and_turns_are_those_of_scipy():
    rng = np.random.default_rng(3)
    orders = ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]
    free = (np.full(3, -np.inf), np.full(3, np.inf))
    skeleton = chain(7, angles={bone: (*free, order) for bone, order in enumerate(orders)})
    turns = rng.uniform(-1.5, 1.5, (7, 3))
    rotations = skeleton.rotations(turns)
    for bone, order in enumerate(orders):
        by_order = ["XYZ".index(axis) for axis in order]
        expected = Rotation.from_euler(order.lower(), turns[bone][by_order]).as_matrix()
        np.testing.assert_allclose(rotations[bone], expected, atol=1e-14)
    np.testing.assert_allclose(rotations[6], Rotation.from_rotvec(turns[6]).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(skeleton.turns(rotations), turns, atol=1e-13)


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
        heads[bone] = (
            rng.normal(size=3) if parents[bone] < 0 else tails[parents[bone]] + 0.1 * rng.normal(size=3)
        )
        tails[bone] = heads[bone] + rng.normal(size=3) * rng.choice([0.01, 1.0])
    most = rng.choice([0.0, 0.3, 2.0, np.inf], count)
    limits = {}
    for bone in np.flatnonzero(rng.random(count) < 0.4):
        ends = np.sort(rng.uniform(-2, 2, (2, 3)), axis=0)
        ends[1] = np.where(rng.random(3) < 0.2, ends[0], ends[1])  # a locked axis
        limits[int(bone)] = (ends[0], ends[1], str(rng.choice(["XYZ", "ZXY", "YZX"])))
    skeleton = sn.Skeleton(heads, tails, parents, most=most, angles=limits)
    targets = rng.integers(0, count, rng.integers(1, 5))
    support = rng.normal(size=(5, 3)) if balance else None
    turns, moves, report = skeleton.solve(
        targets,
        tails[targets],
        far * rng.normal(size=(len(targets), 3)),
        weights=rng.choice([1.0, 1e3], len(targets)),
        moving_roots=rng.random(count) < 0.5,
        turns=rng.uniform(-3, 3, (count, 3)),
        support=support,
    )
    assert np.isfinite(turns).all()
    assert np.isfinite(moves).all()
    assert np.isfinite(report.energy)
    for bone in range(count):
        if bone in limits:
            assert (turns[bone] >= limits[bone][0]).all()
            assert (turns[bone] <= limits[bone][1]).all()
        else:
            assert np.linalg.norm(turns[bone]) <= most[bone] * (1 + 1e-15)
    assert (moves[parents >= 0] == 0).all()
    poses = skeleton.poses(turns, moves)

    def place(points):
        return np.einsum("kij,kj->ki", poses[:, :, :3], points) + poses[:, :, 3]

    lengths = np.linalg.norm(place(tails) - place(heads), axis=1)
    # Far from the origin, places round to their own size.
    rounding = 1e-12 * max(1.0, np.abs(poses).max())
    np.testing.assert_allclose(lengths, np.linalg.norm(tails - heads, axis=1), atol=rounding)
    joined = parents >= 0
    on_parent = np.einsum("kij,kj->ki", poses[parents][:, :, :3], heads) + poses[parents][:, :, 3]
    np.testing.assert_allclose(place(heads)[joined], on_parent[joined], atol=rounding)
    again = skeleton.solve(targets, tails[targets], tails[targets])  # nothing of the last solve is left
    assert again[2].iterations == 0 or again[2].energy >= 0


def test_a_support_holds_the_centre_of_mass():
    skeleton = chain(4)
    corners = np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)])
    goal = [(1.8, 0.0, 2.6)]
    free, _, loose = skeleton.solve([3], [4 * UP], goal)
    held, _, report = skeleton.solve([3], [4 * UP], goal, support=corners)

    def centre(turns):
        joints = joints_of([Rotation.from_rotvec(t) for t in turns])
        return (joints[1:] + joints[:-1]).mean(axis=0) / 2

    assert centre(free)[0] > 0.3
    assert 0.199 < centre(held)[0] <= 0.2
    np.testing.assert_allclose(report.centre, centre(held), atol=1e-12)
    assert report.overhang == 0.0
    assert report.energy > loose.energy
    # Masses count: a heavy foot lets the rest lean.
    _, _, light = skeleton.solve([3], [4 * UP], goal, support=corners, masses=[100.0, 1, 1, 1])
    assert light.energy < report.energy


def test_poses_of_a_skeleton_are_poses_of_handles():
    line = np.linspace(0, 8, 33)
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    points = np.array([(0.5 * np.cos(a), 0.5 * np.sin(a), z) for z in line for a in angle])
    mesh = sn.SurfaceMesh(points, bar(32, 4)[1])
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
        np.testing.assert_allclose(shown[region], points[region] @ pose[:, :3].T + pose[:, 3], atol=1e-12)
    # The joint is a smooth bend: no edge along the tube turns against the next one by more than a part of it.
    rows = shown.reshape(33, 16, 3).mean(axis=1)
    steps = np.diff(rows, axis=0)
    cosines = (
        (steps[1:] * steps[:-1]).sum(axis=1)
        / np.linalg.norm(steps[1:], axis=1)
        / np.linalg.norm(steps[:-1], axis=1)
    )
    assert np.degrees(np.arccos(cosines.min())) < 45


ONE = {"heads": [(0, 0, 0)], "tails": [UP], "parents": [-1]}
FREE = ((-1, -1, -1), (1, 1, 1))


@pytest.mark.parametrize(
    ("error", "given"),
    [
        (sn.InvalidConstraint, {"parents": [-1, 0]}),
        (sn.InvalidConstraint, {"tails": [(0, 0, 0)]}),  # no length
        (sn.InvalidConstraint, {"tails": [(np.nan, 0, 1)]}),
        (sn.InvalidConstraint, {"parents": [0]}),
        (sn.InvalidConstraint, {"parents": [-2]}),
        (sn.InvalidConstraint, {"axes": [2 * np.eye(3)]}),
        (sn.InvalidConstraint, {"axes": [-np.eye(3)]}),
        (sn.InvalidOption, {"most": -1.0}),
        (sn.InvalidOption, {"stiffness": 0.0}),
    ],
)
def test_skeletons_that_are_none_are_refused(error: type, given: dict) -> None:
    with pytest.raises(error):
        sn.Skeleton(**ONE | given)


@pytest.mark.parametrize(
    ("error", "words", "given"),
    [
        (sn.InvalidConstraint, "target 0: there is no bone 3", {"bones": [3]}),
        (sn.InvalidConstraint, "target 0: its point or its goal is not finite", {"goals": [(np.nan, 0, 2)]}),
        (sn.InvalidConstraint, "target 0: its weight is not a positive number", {"weights": 0.0}),
        (sn.InvalidConstraint, "", {"locked": [True]}),
        (sn.InvalidConstraint, "", {"turns": np.zeros((1, 3))}),
        (sn.InvalidConstraint, "", {"support": np.zeros((3, 3))}),
        (sn.InvalidConstraint, "", {"support": np.eye(3), "up": (0, 0, 0)}),
        (sn.InvalidConstraint, "", {"support": np.eye(3), "masses": [1, 2]}),
        (sn.InvalidConstraint, "", {"support": np.eye(3), "masses": [0, 0, 0]}),
        (sn.InvalidConstraint, "", {"support": np.eye(3), "masses": [1, -1, 1]}),
        (sn.InvalidOption, "rest", {"rest": -1.0}),
        (sn.InvalidOption, "max_iterations", {"max_iterations": 0}),
        (sn.InvalidOption, "swing", {"swing": -1.0}),
    ],
)
def test_requests_that_mean_nothing_are_refused(error: type, words: str, given: dict) -> None:
    request = {"bones": [2], "points": [3 * UP], "goals": [(1, 0, 2)]}
    with pytest.raises(error, match=words or None):
        chain(3).solve(**request | given)


def test_refusals_say_what_is_wrong():
    with pytest.raises(sn.InvalidConstraint, match="the skeleton has no bones"):
        sn.Skeleton(np.zeros((0, 3)), np.zeros((0, 3)), [])
    with pytest.raises(sn.InvalidConstraint, match="bone 1: its parent 1 is no earlier bone"):
        sn.Skeleton([UP, UP], [2 * UP, 3 * UP], [-1, 1])
    with pytest.raises(sn.InvalidOption, match="bone 0: the lower limit about y is above the upper one"):
        chain(1, angles={0: ((0, 1, 0), (0, 0, 0), "XYZ")})
    with pytest.raises(sn.InvalidOption, match="order"):
        chain(1, angles={0: ((0, 0, 0), (0, 0, 0), "XYY")})
    with pytest.raises(sn.InvalidOption, match="'AB' is not one of three axes"):
        chain(1, angles={0: ((0, 0, 0), (0, 0, 0), "AB")})
    with pytest.raises(TypeError, match="tuple"):
        chain(1, angles={0: [0, 1]})
    with pytest.raises(sn.InvalidConstraint, match="there is no bone 4"):
        chain(1, angles={4: ((0, 0, 0), (0, 0, 0), "XYZ")})
    skeleton = chain(2)
    with pytest.raises(sn.InvalidConstraint, match="differ"):
        skeleton.solve([0, 1], [UP], [UP])
    with pytest.raises(sn.InvalidConstraint, match="there is no bone 2"):
        skeleton.solve([2], [UP], [UP])
    with pytest.raises(sn.InvalidConstraint, match="support has no area"):
        skeleton.solve([1], [UP], [UP], support=[UP, 2 * UP, 3 * UP])
    with pytest.raises(sn.InvalidConstraint, match="2 rows"):
        chain(3).poses(np.zeros((2, 3)))
    with pytest.raises(sn.InvalidConstraint):
        chain(1).turns(np.zeros((1, 3, 3)))
    for margin in (-0.1, 0.5):
        with pytest.raises(sn.InvalidOption, match="margin"):
            skeleton.regions(sn.SurfaceMesh([UP, 2 * UP, (1, 0, 0)], [[0, 1, 2]]), margin=margin)
    assert repr(skeleton) == "<Skeleton: 2 bones>"
