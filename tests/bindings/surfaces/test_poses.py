# SPDX-License-Identifier: GPL-3.0-or-later
"""Postures of chains, a figure and legs for targets, as they are known; and the regions of bones."""

import itertools

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import carried, closed_bar, moved, turn
from .test_mesh_puppetry import UP, chain

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


@pytest.mark.parametrize("goal", [(6, 1, 2), (0, 3, -5), (0, 0, 9)])
def test_a_chain_points_at_a_target_out_of_reach(goal) -> None:
    assert tip_to(chain(4), goal, rest=1e-9)[2].gaps[0] == pytest.approx(np.linalg.norm(goal) - 4, abs=1e-6)


def test_joints_that_hardly_turn_make_an_arc_towards_a_target_out_of_reach() -> None:
    turns, _moves, report = tip_to(chain(4, most=np.pi / 18), (100, 0, 0), rest=1e-9)
    angles = np.arange(1, 5) * np.pi / 18
    tip = np.array([np.sin(angles).sum(), 0, np.cos(angles).sum()])
    assert report.gaps[0] == pytest.approx(np.linalg.norm(tip - (100, 0, 0)), abs=1e-6)
    assert np.linalg.norm(turns, axis=1).max() <= np.pi / 18


@pytest.mark.parametrize(("weights", "gaps"), [((1, 1), (0.5, 0.5)), ((3, 1), (0.25, 0.75))])
def test_targets_that_contradict_each_other_share_their_gaps(weights, gaps) -> None:
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
    turns, moves, report = skeleton.solve(
        bones, points, moved(motion, points), weights=[1e3, 1e3, 1e3, 1e3, 1], moving_roots=figure.roots()
    )
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

    before = at(1.0)
    for k in range(10):
        at(0.7 * k)
    np.testing.assert_array_equal(at(1.0), before)


def test_locked_joints_stay_and_stiff_ones_hardly_turn() -> None:
    base = np.zeros((4, 3))
    base[1] = 0.1, 0.2, 0.3
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
    points = [
        p for b in (dragged, 3, 6) for h in [body.heads[b]] for p in (h, body.tails[b], h + aside, h - aside)
    ]
    way = np.array((0, -0.8, -0.8) if dragged else (0, 0, -1.0))
    last = None
    for k in range(41):
        goals = np.array(points) + 0.01 * k * np.outer(bones == dragged, way)
        weights = np.where(bones == dragged, 1.0, 1e3)
        turns, moves, report = skeleton.solve(
            bones, points, goals, weights=weights, moving_roots=body.roots()
        )
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
