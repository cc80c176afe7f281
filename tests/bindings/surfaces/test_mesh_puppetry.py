# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons: SciPy on the same residuals, random targets, the skin that follows, and known postures."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import carried, closed_bar, moved, tube, turn

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
    for bone, own in enumerate(turns):
        if bone in limits:
            assert ((own >= limits[bone][0]) & (own <= limits[bone][1])).all()
        else:
            assert np.linalg.norm(own) <= most[bone] * (1 + 1e-15)
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


GOAL = (1.8, 0, 2.6)
TO_THE_END = {"max_iterations": 1000, "tolerance": 1e-13}


def tip_to(skeleton: sn.Skeleton, goal, *others, **options):
    """The last bone of a chain along z is pulled, to several goals at once if there are any."""
    count, goals = skeleton.bone_count, [goal, *others]
    return skeleton.solve([count - 1] * len(goals), [count * UP] * len(goals), goals, **options)


class Body:
    """Bones that grow from each other, the first one from `foot`."""

    def __init__(self, foot) -> None:
        self.foot, self.heads, self.tails, self.parents = np.array(foot, float), [], [], []

    def add(self, parent: int, *ways) -> int:
        """One bone after the other, each along its way; the number of the last one."""
        for way in ways:
            self.heads.append(self.tails[parent] if parent >= 0 else self.foot)
            self.tails.append(self.heads[-1] + way)
            self.parents.append(parent)
            parent = len(self.parents) - 1
        return parent

    def skeleton(self, **limits) -> sn.Skeleton:
        return sn.Skeleton(self.heads, self.tails, self.parents, **limits)

    def places(self, poses: np.ndarray) -> np.ndarray:
        """The tails (k, 3)."""
        return carried(poses, self.tails)

    def roots(self) -> np.ndarray:
        return np.array(self.parents) < 0


class Figure(Body):
    """55 bones with fingers, 1.6 m tall."""

    def __init__(self) -> None:
        super().__init__(UP)
        self.hands, self.feet = [], []
        hip = self.add(-1, (0, 0, 0.1))
        chest = self.add(hip, *8 * [(0, 0, 0.06)])
        for s in (1, -1):
            self.hands.append(self.add(chest, *[(length * s, 0, 0) for length in (0.15, 0.28, 0.26, 0.1)]))
            for finger in range(-2, 3):
                self.add(self.hands[-1], *3 * [(0.03 * s, 0.02 * finger, 0)])
            leg = [(0.1 * s, 0, -0.1), (0, 0, -0.5), (0, -0.02, -0.45), (0, -0.15, -0.04)]
            self.feet.append(self.add(hip, *leg))

    def limited(self) -> sn.Skeleton:
        """Every third joint within a cone, and every third one within angles."""
        bones = np.arange(1, len(self.parents))
        most = np.where(np.arange(len(self.parents)) % 3 == 0, 0.6, np.inf)
        most[0] = np.inf
        box = ((-0.5, -0.3, -0.2), (1.2, 0.3, 0.4), "XYZ")
        return self.skeleton(most=most, angles=dict.fromkeys(bones[bones % 3 == 1].tolist(), box))

    def targets(self) -> tuple[list[int], np.ndarray]:
        """Both ends of the feet, and a hand."""
        bones = [*np.repeat(self.feet, 2), self.hands[0]]
        ends = [end[foot] for foot in self.feet for end in (self.heads, self.tails)]
        return bones, np.array([*ends, self.tails[self.hands[0]]])

    def pulled(self, skeleton: sn.Skeleton, pull, **options):
        """It stands on its feet, and its hand is pulled."""
        bones, points = self.targets()
        goals = points + np.outer([0, 0, 0, 0, 1], pull)
        weights = [1e3, 1e3, 1e3, 1e3, 1]
        return skeleton.solve(bones, points, goals, weights=weights, moving_roots=self.roots(), **options)


@pytest.mark.parametrize("degrees", [180.0, 80.0, 35.0])
def test_a_target_in_reach_is_met_within_limits(degrees: float) -> None:
    skeleton = chain(4, most=np.radians(degrees))
    turns, _moves, report = tip_to(skeleton, GOAL)
    assert report.converged
    assert report.iterations + report.rejected <= 30
    assert report.gaps[0] < 2e-3  # what the rest pose is worth at a weight of 1e-4
    assert np.linalg.norm(turns, axis=1).max() <= np.radians(degrees)  # not by a hair more
    assert tip_to(skeleton, GOAL, rest=1e-10, **TO_THE_END)[2].gaps[0] < 1e-7
    if degrees == 35:  # by a prototype in NumPy, which does not divide gaps by the size
        turns = tip_to(skeleton, GOAL, rest=1e-4 / 16, **TO_THE_END)[0]
        np.testing.assert_allclose(np.degrees(np.linalg.norm(turns, axis=1)), (15.6, 32.3, 35, 35), atol=0.1)


def test_a_chain_points_at_a_target_out_of_reach_and_joints_that_hardly_turn_make_an_arc() -> None:
    for goal in ((6, 1, 2), (0, 3, -5), (0, 0, 9)):
        gap = tip_to(chain(4), goal, rest=1e-9)[2].gaps[0]
        assert gap == pytest.approx(np.linalg.norm(goal) - 4, abs=1e-6)
    turns, _moves, report = tip_to(chain(4, most=np.pi / 18), (100, 0, 0), rest=1e-9)
    angles = np.arange(1, 5) * np.pi / 18
    tip = np.array([np.sin(angles).sum(), 0, np.cos(angles).sum()])
    assert report.gaps[0] == pytest.approx(np.linalg.norm(tip - (100, 0, 0)), abs=1e-6)
    assert np.linalg.norm(turns, axis=1).max() <= np.pi / 18


def test_targets_that_contradict_each_other_share_their_gaps() -> None:
    for weights, gaps in (((1, 1), (0.5, 0.5)), ((3, 1), (0.25, 0.75))):
        report = tip_to(chain(4), (1, 0, 2), (2, 0, 2), weights=weights, rest=1e-9)[2]
        np.testing.assert_allclose(report.gaps, gaps, atol=1e-6)


def test_a_figure_keeps_its_balance_whoever_pulls() -> None:
    figure, rng, leaning = Figure(), np.random.default_rng(11), 0
    skeleton = figure.skeleton()
    lengths = np.linalg.norm(np.subtract(figure.tails, figure.heads), axis=1)
    middles = np.add(figure.tails, figure.heads) / 2
    middle, half = np.array((0, -0.05)), 0.1
    support = [(x, y, 0) for x in (-half, half) for y in (middle[1] - half, middle[1] + half)]
    bones, points = figure.targets()
    for _ in range(20):
        pull = rng.uniform(-0.5, 0.5, 3)
        loose = figure.pulled(skeleton, pull)[2]
        turns, moves, report = figure.pulled(skeleton, pull, support=support)
        assert report.overhang <= 0
        poses = skeleton.poses(turns, moves)  # which the report is about
        missed = carried(poses[bones], points) - points - np.outer([0, 0, 0, 0, 1], pull)
        gaps = np.linalg.norm(missed, axis=1)
        np.testing.assert_allclose(report.gaps, gaps, atol=1e-9)
        centre = np.average(carried(poses, middles), axis=0, weights=lengths)
        np.testing.assert_allclose(report.centre, centre, atol=1e-12)
        beside = np.abs(report.centre[:2] - middle).max()
        assert beside <= half
        leaning += beside > 0.999 * half
        assert report.energy >= loose.energy * (1 - 1e-3), "what balance costs, the targets pay"
    assert leaning > 3, "it was asked to lean, and went to the border"


def test_a_balance_out_of_reach_is_approached_and_reported() -> None:
    support = [(50 + x, y, 0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    report = tip_to(chain(4), (1, 0, 3), support=support, **TO_THE_END)[2]
    assert report.overhang == pytest.approx(49.9 - 2, abs=0.05)  # stretched, the centre is 2 from the base
    assert not report.converged


def test_a_straight_chain_bends_through_its_pole_and_a_knee_one_way_alone() -> None:
    goal = (0, 0, 2.5)  # on the chain's own line
    heads = np.outer(np.arange(4), UP)
    plain = sn.Skeleton(heads, heads + UP, np.arange(4) - 1)
    turns, _moves, report = tip_to(plain, goal)
    assert report.gaps[0] < 5e-3
    assert np.linalg.norm(turns, axis=1).max() > 0.5
    # Nearly all of it in one plane: that of its pole, which bends it a tenth as much aside.
    assert np.abs(turns[:, 1:]).max() < 0.15
    assert tip_to(plain, goal, pole=0.0)[2].gaps[0] > 1.0, "without one it cannot"
    turns = tip_to(chain(4, angles=dict.fromkeys(range(4), ((-2.5, 0, 0), (0, 0, 0), "XYZ"))), goal)[0]
    assert turns[:, 0].max() < 1e-12
    assert turns[:, 0].min() < -0.5


def test_a_rigid_motion_of_all_targets_is_one_of_all_bones() -> None:
    figure = Figure()
    skeleton, (bones, points) = figure.limited(), figure.targets()
    motion = turn((0.3, 1, -0.4), 170, (1, 2, 3), (0.5, -0.7, 2))
    words = {"weights": [1e3, 1e3, 1e3, 1e3, 1], "moving_roots": figure.roots()}
    turns, moves, report = skeleton.solve(bones, points, moved(motion, points), **words)
    assert report.converged
    np.testing.assert_allclose(skeleton.poses(turns, moves) - motion, 0, atol=1e-9)
    assert report.gaps.max() < 1e-10


def test_targets_that_are_met_or_none_change_nothing() -> None:
    figure = Figure()
    skeleton, (bones, points) = figure.skeleton(), figure.targets()
    base = np.random.default_rng(2).uniform(-0.4, 0.4, (len(figure.parents), 3))
    goals = carried(skeleton.poses(base)[bones], points)
    turns, moves, report = skeleton.solve(bones, points, goals, turns=base, moving_roots=figure.roots())
    np.testing.assert_array_equal(turns, base)
    assert not moves.any()
    assert report.iterations == 0
    turns, _moves, report = skeleton.solve([], np.zeros((0, 3)), np.zeros((0, 3)))
    assert report.converged
    assert not turns.any()
    np.testing.assert_allclose(skeleton.poses(turns) - np.eye(3, 4), 0, atol=1e-14)


def test_the_path_of_a_drag_closes_to_the_bit() -> None:
    figure = Figure()
    skeleton = figure.limited()

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        return figure.pulled(skeleton, (0.3 * np.sin(t), 0.2 * np.sin(2 * t), 0.3 - 0.3 * np.cos(t)))[:2]

    way = [at(t) for t in (1.0, *np.arange(0, 7, 0.7), 1.0)]
    np.testing.assert_array_equal(way[-1], way[0])


def test_locked_joints_stay_and_stiff_ones_hardly_turn() -> None:
    base = np.outer((0, 1, 0, 0), (0.1, 0.2, 0.3))
    turns, _moves, report = tip_to(chain(4), GOAL, turns=base, locked=[False, True, False, False])
    np.testing.assert_array_equal(turns[1], base[1])
    assert report.gaps[0] < 3e-3
    stiff, plain = (np.linalg.norm(tip_to(chain(4, stiffness=k), GOAL)[0][0]) for k in ([100, 1, 1, 1], 1))
    assert stiff < 0.1 * plain


def along_z(count: int, beside: float) -> Body:
    """Bones, each joint a little beside the line if asked for, so that those in between have hinges."""
    ways = beside * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    joints = np.outer(np.arange(count + 1), UP) + ways[np.arange(count + 1) % 3]
    body = Body(joints[0])
    body.add(-1, *np.diff(joints, axis=0))
    return body


def longest_step(body: Body, goals) -> float:
    """The longest way of a joint between two goals of the tip, each solved on its own."""
    skeleton, places = body.skeleton(), []
    for goal in goals:
        turns, moves, report = skeleton.solve([len(body.parents) - 1], body.tails[-1:], [goal])
        assert report.converged, goal
        places.append(body.places(skeleton.poses(turns, moves)))
    return max(np.linalg.norm(b - a, axis=1).max() for a, b in itertools.pairwise(places))


def test_the_joints_of_an_arm_move_smoothly_with_its_hand_on_a_circle() -> None:
    arm = Body((0, 0, 0))
    arm.add(-1, (1, 0.1, 0), (1, -0.1, 0))
    angles = np.radians(np.arange(361))
    circle = np.column_stack([1.2 + 0.5 * np.cos(angles), 0.5 * np.sin(angles), np.full(361, 0.3)])
    assert longest_step(arm, circle) < 0.02


@pytest.mark.parametrize("body", [along_z(4, 0.0), along_z(4, 0.1)], ids=["straight", "zigzag"])
def test_a_small_step_of_the_tip_is_one_of_all_joints(body: Body) -> None:
    rng = np.random.default_rng(2)  # of a thousand goals, a few near the line move a joint farther
    for goal, way in zip(rng.uniform(-3.5, 3.5, (200, 3)), rng.normal(size=(200, 3)), strict=True):
        assert longest_step(body, [goal, goal + 0.005 * way / np.linalg.norm(way)]) < 0.02


@pytest.mark.parametrize("knee", [0.02, 0.08])
@pytest.mark.parametrize("dragged", [0, 8], ids=["hip", "chest"])
def test_both_legs_of_a_figure_bend_alike_and_forward(knee: float, dragged: int) -> None:
    """A hip with two legs that mirror each other, knees ahead, and a spine; the feet are bones 3 and 6."""
    body = Body(UP)
    body.add(-1, (0, 0, 0.2))
    for side in (1, -1):
        joints = [(0.1, 0, 1), (0.12, -knee, 0.55), (0.12, 0, 0.1), (0.12, -0.2, 0)] * np.array((side, 1, 1))
        body.heads += list(joints[:-1])
        body.tails += list(joints[1:])
        body.parents += [0, len(body.parents), len(body.parents) + 1]
    body.add(0, (0, 0.02, 0.2), (0, -0.02, 0.2))
    skeleton = body.skeleton()
    bones = np.repeat([dragged, 3, 6], 4)  # as whole bones
    aside = np.array((0.1, 0, 0))
    points = []
    for head, tail in ((body.heads[b], body.tails[b]) for b in (dragged, 3, 6)):
        points += [head, tail, head + aside, head - aside]
    way = np.array((0, -0.8, -0.8) if dragged else (0, 0, -1.0))
    last = None
    for k in range(41):
        goals = np.array(points) + 0.01 * k * np.outer(bones == dragged, way)
        weights = np.where(bones == dragged, 1.0, 1e3)
        words = {"weights": weights, "moving_roots": body.roots()}
        turns, moves, report = skeleton.solve(bones, points, goals, **words)
        assert report.converged
        tails = body.places(skeleton.poses(turns, moves))
        np.testing.assert_allclose(tails[1:4], tails[4:7] * (-1, 1, 1), atol=1e-6)
        assert tails[1, 1] < -knee + 1e-9, "ahead"
        assert tails[1, 0] > 0.1, "and on its own side"
        # The first centimetres from an almost straight leg move a knee far, whoever bends it.
        assert k <= 4 or np.linalg.norm(tails - last, axis=1).max() < 0.03
        last = tails


def test_limbs_are_held_joints_are_free_and_a_bone_outside_holds_nothing() -> None:
    points, faces = closed_bar(24, 3)
    mesh, x = sn.SurfaceMesh(points, faces), points[:, 0]
    skeleton = sn.Skeleton([(0, 0, 0), (12, 0, 0)], [(12, 0, 0), (24, 0, 0)], [-1, 0])
    # A root has no joint at its head, and the last bone none at its tail: these ends are held.
    for margin, free in ((None, 3), (0.24, 3), (0.26, 4), (0.4, 5)):  # 12 vertices along a bone
        first, second = skeleton.regions(mesh, **({} if margin is None else {"margin": margin}))
        np.testing.assert_array_equal(first, np.flatnonzero(x <= 12 - free))
        np.testing.assert_array_equal(second, np.flatnonzero(x >= 12 + free))
    beside = sn.Skeleton([(0, 0, 0), (0, 5, 0)], [(24, 0, 0), (24, 5, 0)], [-1, -1])
    assert [len(region) for region in beside.regions(mesh)] == [len(points), 0]


def test_regions_are_by_distances_along_the_surface() -> None:
    """The bone in the first of two bars is nearer to the inner side of the other than that one's own bone."""
    points, (counts, one) = closed_bar(12, 2)
    n = len(points)
    both = np.concatenate([points, points + (0, 2.2, 0)])
    skeleton = sn.Skeleton([(0, 0.6, 0), (0, 2.9, 0)], [(12, 0.6, 0), (12, 2.9, 0)], [-1, -1])
    for order in (1, -1):  # and where all faces look inward
        corners = np.concatenate([one, n + one])[::order]
        first, second = skeleton.regions(sn.SurfaceMesh(both, (np.tile(counts, 2)[::order], corners)))
        assert (second >= n).sum() == n
        assert (first < n).all()
