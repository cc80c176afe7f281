# SPDX-License-Identifier: GPL-3.0-or-later
"""Puppet Drag in a real window: the mouse, Auto Keying, undo, redo and Esc in Pose Mode. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 400.0
FLOAT32 = 1e-5  # of a figure 1.8 units high, through the matrices of a chain of bones
REACHED = 0.02  # of a drag of half a unit: a pixel is a two-hundredth, and joints resist a little
STANDS = 1e-3  # what pinned feet give way: they count a thousand times as much as what is dragged


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_puppet.py`` observed."""
    return drive("drive_puppet.py", tmp_path_factory.mktemp("puppet"), TIMEOUT)


def test_the_feet_are_pinned_by_a_command(seen: dict):
    assert seen["pinned"] == ["foot.L", "foot.R"]


@pytest.mark.parametrize("dragged", ["hand", "hip"])
def test_the_bone_follows_the_mouse_and_the_feet_stay(seen: dict, dragged: str):
    assert seen[dragged] < REACHED
    assert seen[f"{dragged} feet"] < STANDS
    assert seen[f"{dragged} lengths"] < FLOAT32


def test_the_skin_follows(seen: dict):
    assert seen["skin"] > 0.3


def test_auto_keying_keys_the_bones_that_follow(seen: dict):
    assert {"hand.L", "lower.L", "upper.L"} <= set(seen["keyed"])


def test_a_drag_is_one_step_of_undo(seen: dict):
    assert seen["undone"] < FLOAT32
    assert seen["redone"] < FLOAT32


def test_escape_puts_everything_back(seen: dict):
    assert seen["before escape"] > 0.1
    assert seen["given up"] < FLOAT32
    assert seen["mode"] == "POSE"
