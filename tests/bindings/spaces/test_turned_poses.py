# SPDX-License-Identifier: GPL-3.0-or-later
"""How points turn that are only known to move, next to NumPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import moved, nearest_rotations, turn

POINTS = np.random.default_rng(3).uniform(-1.0, 1.0, (12, 3))
CHAIN = np.array([(k, k + 1) for k in range(11)])
NO_EDGES = np.zeros((0, 2), dtype=int)
LITTLE = 1e-3  # how much the turn of all points counts beside that of the edges at a point
LEAST = 1e-9  # how much no turn at all counts, so that points on a line turn as little as they can


def by_numpy(rest: np.ndarray, posed: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """The motions, with NumPy's singular values."""
    local, there = rest - rest.mean(axis=0), posed - posed.mean(axis=0)
    size = max(float((local**2).sum()), 1e-300)
    everything = nearest_rotations(there.T @ local / size + LEAST * np.eye(3))
    before, after = (points[edges[:, 1]] - points[edges[:, 0]] for points in (rest, posed))
    squares = (before**2).sum(axis=1)
    shares = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0.0)
    products = after[:, :, None] * (shares[:, None] * before)[:, None, :]
    together = np.tile(LITTLE * everything, (len(rest), 1, 1))
    for end in (0, 1):
        np.add.at(together, edges[:, end], products)
    turns = nearest_rotations(together)
    moves = posed - np.einsum("nij,nj->ni", turns, rest)
    return np.concatenate((turns, moves[:, :, None]), axis=2)


@pytest.mark.parametrize("edges", [NO_EDGES, CHAIN, CHAIN[3:7]], ids=["cloud", "chain", "in part"])
def test_the_poses_are_numpys(edges: np.ndarray) -> None:
    random = np.random.default_rng(5)
    for scale in (1e-3, 0.3, 3.0):  # at the largest, edges turn by any angle
        posed = POINTS + scale * random.uniform(-1.0, 1.0, POINTS.shape)
        found = sn.turned_poses(POINTS, posed, edges)
        # A single edge leaves a turn open, which a thousandth of the common turn decides.
        assert np.abs(found - by_numpy(POINTS, posed, edges)).max() < 1e-11


@pytest.mark.parametrize("edges", [NO_EDGES, CHAIN], ids=["cloud", "chain"])
@pytest.mark.parametrize("degrees", [0.0, 40.0, 172.0])
def test_points_that_move_rigidly_turn_with_all(edges: np.ndarray, degrees: float) -> None:
    pose = turn((0.3, 0.9, -0.2), degrees, move=(0.4, -0.2, 0.7))
    # A billionth of no turn is in the fit.
    assert np.abs(sn.turned_poses(POINTS, moved(pose, POINTS), edges) - pose).max() < 1e-7


def test_a_point_turns_as_its_edges_do_and_always_goes_where_it_is() -> None:
    """The far half of a chain turns: so do its points, and no others but the one between."""
    places = np.column_stack((np.arange(12.0), np.sin(np.arange(12.0)), np.cos(2.0 * np.arange(12.0))))
    pose = turn((0.0, 1.0, 0.0), 69.0, places[5])
    posed = np.where(np.arange(12)[:, None] > 5, moved(pose, places), places)
    poses = sn.turned_poses(places, posed, CHAIN)
    assert np.abs(np.einsum("nij,nj->ni", poses[:, :, :3], places) + poses[:, :, 3] - posed).max() < 1e-12
    two_edges = np.arange(12) > 5
    assert np.abs(poses[6:11, :, :3] - pose[:, :3]).max() < 2e-2  # the turn of the whole counts a thousandth
    assert np.abs(poses[1:5, :, :3] - np.eye(3)).max() < 2e-2
    assert np.abs(poses[two_edges][0, :, :3] - np.eye(3)).max() > 0.5


def test_points_on_a_line_turn_as_little_as_they_can() -> None:
    line = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    pose = turn((0.0, 1.0, 0.0), 46.0)
    poses = sn.turned_poses(line, moved(pose, line), np.array([(0, 1)]))
    assert np.abs(poses - pose).max() < 1e-6
    (pose,) = sn.turned_poses(line[:1], line[:1] + 2.0, NO_EDGES)
    assert np.abs(pose - np.column_stack((np.eye(3), (2.0, 2.0, 2.0)))).max() < 1e-12


def test_coincident_points_and_edges_without_length_give_numbers() -> None:
    points = np.zeros((3, 3))
    assert np.isfinite(sn.turned_poses(points, np.eye(3), np.array([(0, 1), (1, 2)]))).all()


def test_refusals() -> None:
    assert sn.turned_poses(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3, 4)
    with pytest.raises(sn.InvalidConstraint, match="posed: 2 points given for 12"):
        sn.turned_poses(POINTS, POINTS[:2])
    with pytest.raises(sn.InvalidConstraint, match="finite"):
        sn.turned_poses(POINTS, np.full_like(POINTS, np.inf))
    for point in (-1, 12):
        with pytest.raises(sn.InvalidConstraint, match=f"no point {point}"):
            sn.turned_poses(POINTS, POINTS, [(0, point)])
