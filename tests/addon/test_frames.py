# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames, poses, and how a piece of a surface has moved as a whole, against closed forms."""

import numpy as np
import pytest
import rows

from sinew.core.errors import ConstraintError
from sinew.core.geometry import frames, rigid_motion

RANDOM = np.random.default_rng(7)


def rotation(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = rows.rotation(axis, angle)
    return matrix


def translation(*by: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


SQUARE = np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 2.0, 0.0), (0.0, 2.0, 0.0)])
ONE_QUAD = (np.array([4]), np.array([0, 1, 2, 3]))


def test_vector_area_of_a_polygon():
    assert np.allclose(frames.newell_normals(SQUARE, *ONE_QUAD), [(0.0, 0.0, 8.0)])


def test_region_frame_sits_at_the_centre_and_looks_along_the_normal():
    world = rotation((1.0, 2.0, 3.0), 0.8)
    frame = frames.region_frame(frames.transformed(world, SQUARE), *ONE_QUAD, np.arange(4))
    assert np.allclose(frame[:3, 3], world[:3, :3] @ (1.0, 1.0, 0.0))
    assert np.allclose(frame[:3, 2], world[:3, 2])
    assert np.allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3))
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)


def test_region_frame_looks_at_the_faces_of_the_region_alone():
    """Beside a triangle that stands upright and a quad of which half belongs to the region."""
    points = np.vstack((SQUARE, (4.0, 0.0, 0.0), (4.0, 2.0, 3.0), (0.0, 0.0, 5.0)))
    counts, corners = np.array([3, 4, 4]), np.array([0, 1, 6, *ONE_QUAD[1], 1, 4, 5, 2])
    alone = frames.region_frame(SQUARE, *ONE_QUAD, np.arange(4))
    assert np.allclose(frames.region_frame(points, counts, corners, np.arange(4)), alone)


def test_region_without_whole_faces_keeps_the_axes():
    frame = frames.region_frame(SQUARE, *ONE_QUAD, np.array([0, 1]))
    assert np.allclose(frame[:3, :3], np.eye(3))
    none = np.zeros(0, dtype=int)
    assert np.allclose(frames.region_frame(SQUARE, none, none, np.array([2])), translation(2.0, 2.0, 0.0))


def test_placed_keeps_the_normal_under_unequal_scale():
    """Normals go by the inverse transpose: a slope of 45 degrees, stretched along x, gets steeper normals."""
    tilted = rotation((0.0, 1.0, 0.0), np.pi / 4.0)
    world = np.diag((3.0, 1.0, 1.0, 1.0))
    placed = frames.in_world(world, tilted)
    expected = np.array((1.0 / 3.0, 0.0, 1.0))
    assert np.allclose(placed[:3, 2], expected / np.linalg.norm(expected))
    assert np.allclose(placed[:3, :3].T @ placed[:3, :3], np.eye(3))


def test_pose_is_the_identity_at_rest_and_the_motion_after():
    target = translation(1.0, 2.0, 3.0) @ rotation((0.0, 1.0, 1.0), 0.5) @ np.diag((2.0, 0.5, 1.0, 1.0))
    control = translation(-1.0, 0.5, 0.0) @ rotation((1.0, 0.0, 1.0), 1.1)
    rest = np.linalg.inv(target) @ control
    assert np.allclose(frames.pose(target, control, rest), np.eye(4)[:3])
    motion = translation(0.1, 0.2, 0.3) @ rotation((1.0, 1.0, 0.0), 0.4)
    moved = frames.pose(target, motion @ control, rest)
    whole = translation(3.0, 1.0, 2.0) @ rotation((1.0, 2.0, 0.5), 2.0)
    assert np.allclose(frames.pose(whole @ target, whole @ motion @ control, rest), moved)
    points = RANDOM.normal(size=(5, 3))
    in_world = frames.transformed(target, points @ moved[:, :3].T + moved[:, 3])
    assert np.allclose(in_world, frames.transformed(motion @ target, points))


@pytest.mark.parametrize(
    "flat", [np.diag((1.0, 1.0, 0.0, 1.0)), np.full((4, 4), np.nan), np.diag((0.0, 0.0, 0.0, 1.0))]
)
def test_flat_or_broken_matrices_are_refused_by_name(flat: np.ndarray):
    with pytest.raises(ConstraintError, match="Statue"):
        frames.inverse(flat, "Statue")


def test_tiny_and_huge_scales_are_fine():
    for scale in (1e-4, 1e4):
        matrix = np.diag((scale, scale, scale, 1.0))
        assert np.allclose(frames.inverse(matrix, "Statue") @ matrix, np.eye(4))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 20])
def test_fit_finds_a_rigid_motion_from_any_number_of_points(count: int):
    before = RANDOM.normal(size=(count, 3))
    motion = translation(0.3, -1.0, 2.0) @ rotation((0.2, 1.0, 0.4), 2.5)
    after = frames.transformed(motion, before)
    for rigid in (False, True):
        found = frames.fit(before, after, rigid)
        assert np.allclose(before @ found[:, :3].T + found[:, 3], after)
        assert np.linalg.det(found[:, :3]) > 0.1
    if count >= 3:
        assert np.allclose(found, motion[:3], atol=1e-6)


def test_fit_finds_an_affine_motion_and_a_rigid_fit_of_a_mirrored_cloud_is_a_rotation():
    before = RANDOM.normal(size=(20, 3))
    affine = np.column_stack((RANDOM.normal(size=(3, 3)) + 2.0 * np.eye(3), (1.0, 2.0, 3.0)))
    after = before @ affine[:, :3].T + affine[:, 3]
    assert np.allclose(frames.fit(before, after), affine)
    found = frames.fit(before, before * (-1.0, 1.0, 1.0), rigid=True)
    assert np.linalg.det(found[:, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("corners", "turned"),
    [
        ([0, 1, 2, 3, 2, 1, 4], [False, False]),
        ([2, 3, 0, 1, 1, 4, 2], [False, False]),
        ([0, 3, 2, 1, 2, 1, 4], [True, False]),
        ([3, 2, 1, 0, 4, 1, 2], [True, True]),
        ([0, 2, 1, 3, 2, 1, 4], None),
        ([0, 1, 2, 3, 3, 1, 4], None),
        ([2, 1, 4, 0, 1, 2, 3], None),
    ],
    ids=["the same", "begun elsewhere", "one turned", "both turned", "crossed", "another vertex", "swapped"],
)
def test_faces_that_are_turned_are_told_from_other_faces(corners: list[int], turned: list[bool] | None):
    counts = np.array([3, 4] if corners[:3] == [2, 1, 4] else [4, 3])
    one = np.array([4, 3]), np.array([0, 1, 2, 3, 2, 1, 4])
    found = frames.turned_faces(one, (counts, np.array(corners)))
    assert (None if found is None else found.tolist()) == turned


SHEET = np.array([(x, y, 0.1 * x * y) for y in range(4) for x in range(4)], dtype=float)
COUNTS = np.full(9, 4)
CORNERS = np.array([(r + c, r + c + 1, r + c + 5, r + c + 4) for r in (0, 4, 8) for c in range(3)]).ravel()


def turn(degrees: float) -> np.ndarray:
    return rows.rotation((0.0, 1.0, 0.0), np.radians(degrees))


@pytest.mark.parametrize("members", [[5], [5, 6], [5, 6, 7], [0, 1, 4, 5], list(range(16))])
@pytest.mark.parametrize("degrees", [0.0, 40.0, 100.0, 179.0])
def test_a_rigid_motion_is_found_however_small_the_region_is(members: list[int], degrees: float):
    moved = SHEET @ turn(degrees).T + (1.0, -2.0, 0.5)
    piece = rigid_motion.piece(SHEET, COUNTS, CORNERS, np.array(members))
    found = rigid_motion.motion(SHEET[piece], moved[piece].astype(np.float32), np.eye(3))
    assert np.abs(found[:3, :3] - turn(degrees)).max() < 1e-6
    assert np.abs(found[:3, 3] - (1.0, -2.0, 0.5)).max() < 2e-6  # float32 at coordinates near 4


def test_it_is_rigid_in_the_world_where_the_object_is_stretched():
    linear = np.diag((1.0, 3.0, 0.5))
    world = SHEET @ linear.T @ turn(70.0).T
    found = rigid_motion.motion(SHEET, world @ np.linalg.inv(linear).T, linear)
    assert np.allclose(linear @ found[:3, :3] @ np.linalg.inv(linear), turn(70.0))


def test_points_on_a_line_or_alone_move_and_do_not_turn():
    line = SHEET[:3] * (1.0, 0.0, 0.0)
    moved = line @ turn(30.0).T + (0.0, 1.0, 0.0)
    found = rigid_motion.motion(line, moved, np.eye(3))
    assert np.array_equal(found[:3, :3], np.eye(3))
    assert np.allclose(found[:3, 3], (moved - line).mean(axis=0))
    assert np.array_equal(rigid_motion.motion(line[:0], line[:0], np.eye(3)), np.eye(4))


def test_lost_points_move_nothing():
    lost = SHEET.copy()
    lost[3] = np.nan
    assert np.array_equal(rigid_motion.motion(SHEET, lost, np.eye(3)), np.eye(4))
