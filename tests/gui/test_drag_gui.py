# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag Surface in a real window: the tool of the toolbar, by mouse, Esc and undo. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 200.0
PIXEL = 1.0
FLOAT32 = 4e-6  # of a head 4 units wide
NOTHING = [[], [], 0, []]
ONE_HANDLE = [
    [["SUPPORT", "Support"], ["HANDLE", "Handle"]],
    ["Support", "Handle"],
    1,
    ["Head Handle"],
]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_drag.py`` observed."""
    return drive("drive_drag.py", tmp_path_factory.mktemp("drag"), TIMEOUT)


def test_a_drag_makes_a_handle_that_follows_the_mouse(seen: dict):
    assert seen["before"] == NOTHING
    assert seen["kept"] == ONE_HANDLE
    assert seen["region"] > 3
    assert seen["off the mouse"] < PIXEL
    assert 0.01 < seen["share that moved"] < 0.5
    assert not seen["other side moved"]
    assert seen["active"] == "Head Handle"


def test_the_next_drag_there_takes_the_same_handle(seen: dict):
    assert seen["dragged again"] == ONE_HANDLE
    assert seen["off the mouse again"] < PIXEL


def test_escape_puts_everything_back(seen: dict):
    (rows, moved), (same_rows, moved_again) = seen["while held"]
    assert (rows, same_rows) == (4, 2)
    assert min(moved, moved_again) > 0.01
    for left, off in seen["given up"]:
        assert left == ONE_HANDLE
        assert off < FLOAT32


def test_one_step_of_undo_per_drag(seen: dict):
    assert seen["undone"][0] == seen["redone"][0] == ONE_HANDLE
    assert seen["all undone"][0] == NOTHING
    for name in ("undone", "all undone", "redone"):
        assert seen[name][1] < FLOAT32


def test_adjust_last_operation_repeats_it(seen: dict):
    assert seen["last"] == "SINEW_OT_drag"
    assert seen["repeated"][0] == ONE_HANDLE
    assert seen["repeated"][1] < FLOAT32
