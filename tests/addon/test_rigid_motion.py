# SPDX-License-Identifier: GPL-3.0-or-later
"""How a piece of a surface has moved as a whole."""

import numpy as np
import pytest
from rows import rotation

from sinew.core.geometry import rigid_motion

SHEET = np.array([(x, y, 0.1 * x * y) for y in range(4) for x in range(4)], dtype=float)
COUNTS = np.full(9, 4)
CORNERS = np.array([(r + c, r + c + 1, r + c + 5, r + c + 4) for r in (0, 4, 8) for c in range(3)]).ravel()


def turn(degrees: float) -> np.ndarray:
    return rotation((0.0, 1.0, 0.0), np.radians(degrees))


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
