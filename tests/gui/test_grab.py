# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Region in a real window, beside Blender's own Move, Rotate and Scale. Needs a display, as Xvfb's."""

import pytest
from blender_window import drive

TIMEOUT = 420.0  # a software renderer draws about two windows a second, fewer on a busy machine
SAME = (
    "free",
    "axis",
    "local",
    "plane",
    "sight",
    "typed",
    "turn",
    "turn x",
    "turn z",
    "size",
    "size plane",
    "switched",
    "slanted axis",
    "slanted plane",
    "slanted turn z",
    "perspective free",
    "perspective axis",
)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_grab.py`` observed."""
    return drive("drive_grab.py", tmp_path_factory.mktemp("grab"), TIMEOUT)


def test_the_key_starts_it_and_the_surface_follows(seen: dict):
    assert seen["dragged"] > 0.5
    assert seen["followed"] > 500


def test_axis_number_and_enter_move_the_selection_by_just_that(seen: dict):
    assert seen["typed along x"] < 1e-6
    assert seen["last"] == ["SINEW_OT_grab_region", "TRANSLATE", [0.5, 0.0, 0.0]]


def test_one_undo_takes_it_back(seen: dict):
    assert seen["undone"] == 0.0


def test_esc_restores_every_bit(seen: dict):
    assert seen["restored"]
    assert seen["selection kept"]
    assert "not restored" not in seen


@pytest.mark.parametrize("name", SAME)
def test_the_same_events_move_the_selection_as_blender_does(seen: dict, name: str):
    blender, ours = seen[name]
    difference = max(
        abs(a - b) for row, other in zip(blender, ours, strict=True) for a, b in zip(row, other, strict=True)
    )
    assert difference < 1e-4  # float32 vertices, and Blender's float32 view
