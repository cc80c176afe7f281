# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage in a real window: made, posed in Edit Mode by keys, undone, its weights drawn. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 300.0  # a software renderer draws about two windows a second
FLOAT32 = 4e-6


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_cage.py`` observed."""
    return drive("drive_cage.py", tmp_path_factory.mktemp("cage"), TIMEOUT)


def test_the_cage_is_made_and_waits_to_be_edited(seen: dict):
    cage = seen["cage"]
    assert 150 <= cage["faces"] <= 250
    assert cage["active"]
    assert cage["drawn as"] == "WIRE"
    assert cage["level"] == "INFO", cage["status"]


def test_faces_are_changed_in_a_thread_that_esc_cancels_and_one_undo_takes_back(seen: dict):
    found = seen["faces"]
    assert found["cancelled in a thread"]
    assert found["changed in a thread"]
    assert found["cancelled"] == found["undone"] == found["before"]
    assert 118 <= found["changed"] <= 121
    assert found["cancelled is well"]
    assert found["changed is well"]


def test_the_mesh_follows_edits_of_the_cage_while_they_happen(seen: dict):
    assert seen["while moving"] == pytest.approx(0.5, abs=0.2)
    assert seen["posed"] == pytest.approx(seen["while moving"], abs=FLOAT32)
    assert seen["far side"] < 0.25 * seen["posed"]


def test_undo_and_redo_in_edit_mode_take_the_mesh_along(seen: dict):
    assert seen["undone"] < FLOAT32
    assert seen["redone"] < FLOAT32
    assert seen["left edit mode"] < FLOAT32


@pytest.mark.parametrize("method", ["positive_mean_value", "harmonic", "green"])
def test_other_coordinates_keep_the_pose_of_the_cage(seen: dict, method: str):
    level, moved, _ = seen[method]
    assert level == "INFO"
    assert moved == pytest.approx(0.5, abs=0.2)


def test_weights_are_drawn_over_the_mesh(seen: dict):
    assert seen["coloured"] > 0.05


def test_set_rest_puts_the_mesh_at_rest_and_a_deleted_cage_leaves_it_there(seen: dict):
    assert seen["rest again"] < FLOAT32
    status, moved = seen["cage deleted"]
    assert "cage" in status.lower()
    assert moved < FLOAT32
