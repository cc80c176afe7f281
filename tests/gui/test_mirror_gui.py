# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing that takes others along, in a real window: mirrored by drags, numbers, Esc, Alt+G, undo by mouse and
keys; a rig that rides on another. Needs a display.
"""

import numpy as np
import pytest
from blender_window import drive

TIMEOUT = 300.0
FLIP = np.array((-1.0, 1.0, 1.0))
FLOAT32 = 4e-6  # of a head 4 units wide


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_mirror.py`` observed."""
    return drive("drive_mirror.py", tmp_path_factory.mktemp("mirror"), TIMEOUT)


def is_mirrored(left: list[float], right: list[float]) -> bool:
    return bool(np.abs(np.array(left) * FLIP - right).max() < FLOAT32)


def test_mirror_names_the_ears(seen: dict):
    assert seen["names"] == ["Ear.L", "Back", "Ear.R"]


def test_the_other_ear_follows_each_step_of_a_drag(seen: dict):
    heights = [left[1] for left, _right, _uneven in seen["steps"]]
    assert len(set(heights)) == len(heights)
    for left, right, uneven in (*seen["steps"], seen["dragged"]):
        assert np.abs(left).max() > 0.01
        assert is_mirrored(left, right)
        assert uneven < FLOAT32


def test_one_step_of_undo_takes_both_back_and_redo_brings_both(seen: dict):
    left, right, uneven = seen["undone"]
    assert np.abs([left, right]).max() < 1e-12
    assert uneven < FLOAT32
    assert np.allclose(seen["redone"][:2], seen["dragged"][:2], atol=1e-6)


def test_clearing_one_clears_both_at_every_step_of_undo(seen: dict):
    assert np.abs(seen["cleared"]).max() < 1e-12
    assert np.abs(seen["cleared again"]).max() < 1e-12
    assert np.allclose(seen["before it was cleared"], seen["redone"][:2], atol=1e-6)


def test_escape_gives_both_back(seen: dict):
    before, along = seen["taken along"]
    assert not is_mirrored(*before)
    assert is_mirrored(*along)
    before, after = seen["cancelled"]
    assert before == after


def test_typed_numbers_are_followed(seen: dict):
    left, right, uneven = seen["typed"]
    assert is_mirrored(left, right)
    assert uneven < FLOAT32


def test_the_key_i_keys_both_sides(seen: dict):
    heights = []
    for left, right in seen["keyed"]:
        assert left.keys() == right.keys() == {f"location {axis}" for axis in range(3)}
        for channel, sign in (("location 0", -1.0), ("location 1", 1.0), ("location 2", 1.0)):
            assert np.allclose(np.array(left[channel]) * (1.0, sign), right[channel], atol=FLOAT32)
        heights.append([frame for frame, _value in left["location 2"]])
    assert heights == [[1.0], [1.0, 11.0], [1.0, 11.0]]
    assert seen["keyed"][1] != seen["keyed"][2]


def test_a_rig_that_rides_on_a_vertex_is_right_at_each_step_of_a_drag(seen: dict):
    """Its control is at the vertex that is shown, and its shape at the control."""
    heights = [height for height, _control, _tip in seen["ridden"]]
    assert (np.diff(heights[:5]) < -0.01).all(), heights
    assert max(max(apart) for _height, *apart in seen["ridden"]) < FLOAT32, seen["ridden"]
