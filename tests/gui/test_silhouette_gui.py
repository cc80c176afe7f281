# SPDX-License-Identifier: GPL-3.0-or-later
"""Silhouette Sketch in a real window: a stroke by the mouse, wheel, Esc and undo. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 400.0
FLOAT32 = 4e-6  # of a head 4 units wide
ONE_KEY = ["Basis", "Silhouette"]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_silhouette.py`` observed."""
    return drive("drive_silhouette.py", tmp_path_factory.mktemp("silhouette"), TIMEOUT)


def test_the_surface_follows_when_the_button_is_released(seen: dict):
    keys, moved = seen["drawn"]
    assert keys == ONE_KEY
    assert moved > 0.3


def test_the_wheel_changes_how_much_follows(seen: dict):
    narrow, wide = seen["wider"]
    assert wide > narrow


def test_confirming_keeps_what_is_shown(seen: dict):
    keys, off = seen["kept"]
    assert keys == ONE_KEY
    assert off < FLOAT32
    before, after = seen["tip"]
    assert before < 2.2 < after < 2.75
    assert not seen["other side moved"]
    assert seen["last"] == "SINEW_OT_silhouette_sketch"


def test_one_step_of_undo(seen: dict):
    for name, keys in (("undone", []), ("redone", ONE_KEY), ("undone again", [])):
        assert seen[name][0] == keys
        assert seen[name][1] < FLOAT32


def test_adjust_last_operation_repeats_it(seen: dict):
    keys, off = seen["repeated"]
    assert keys == ONE_KEY
    assert off < 1e-4  # points and reach went through float32


def test_a_stroke_elsewhere_changes_nothing_and_escape_puts_everything_back(seen: dict):
    assert seen["elsewhere"] == []
    assert seen["before escape"] == ONE_KEY
    assert seen["given up"][0] == []
    assert seen["given up"][1] < FLOAT32
