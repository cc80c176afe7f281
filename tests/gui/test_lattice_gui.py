# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice in a real window, and the surface dragged by an inverse lattice. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 300.0  # a software renderer draws about two windows a second
FLOAT32 = 4e-6


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_lattice.py`` observed."""
    return drive("drive_lattice.py", tmp_path_factory.mktemp("lattice"), TIMEOUT)


def test_the_lattice_fits_and_waits_to_be_edited(seen: dict):
    lattice = seen["lattice"]
    assert lattice["points"] == 64
    assert lattice["active"]
    assert lattice["level"] == "INFO", lattice["status"]
    assert lattice["moved"] < FLOAT32


def test_the_mesh_follows_edits_of_the_lattice_while_they_happen(seen: dict):
    assert 0.05 < seen["while moving"] < 0.9
    assert seen["posed"] == pytest.approx(seen["while moving"], abs=FLOAT32)
    assert seen["far side"] < 0.25 * seen["posed"]


def test_undo_and_redo_in_edit_mode_take_the_mesh_along(seen: dict):
    assert seen["undone"] < FLOAT32
    assert seen["redone"] < FLOAT32
    assert seen["left edit mode"] < FLOAT32


def test_the_surface_is_dragged_at_the_very_place(seen: dict):
    nose = seen["nose"]
    assert nose["handles"] == ["Point"]
    assert nose["groups"] == 0
    assert nose["level"] == "INFO"
    assert nose["off the mouse"] < 2.0
    assert nose["moved"] > 0.2


def test_the_other_side_follows_also_a_typed_number(seen: dict):
    ears = seen["ears"]
    assert sorted(ears["handles"]) == ["Point", "Point.L", "Point.R"]
    assert ears["uneven"] < 1e-5
    assert ears["moved"] > 0.1


def test_esc_and_undo_leave_nothing_behind(seen: dict):
    assert sorted(seen["given up"][0]) == ["Point", "Point.L", "Point.R"]
    assert seen["given up"][1] < FLOAT32
    assert seen["undone drag"][0] == ["Point"]
    assert seen["undone drag"][1] < FLOAT32
