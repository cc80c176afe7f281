# SPDX-License-Identifier: GPL-3.0-or-later
"""The handle list, a weight brush, new vertices and a heavy drag in a real window. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 300.0  # a minute on a quiet machine
NAMES = ["ear", "Ear.R", "Muzzle", "Back"]
FLOAT32 = 2e-6  # of a head 4 units wide
LIFT = 0.45


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_handles.py`` observed."""
    return drive("drive_handles.py", tmp_path_factory.mktemp("handles"), TIMEOUT)


def test_the_eye_lets_a_region_go_and_takes_it_back(seen: dict):
    enabled, moved = seen["eye_off"]
    assert not enabled
    assert moved == pytest.approx(LIFT, abs=0.1)  # the ear falls back to where the rest of the head is
    assert seen["eye_on"][0]
    assert seen["eye_on"][1] < FLOAT32


def test_the_arrow_selects_the_control_alone(seen: dict):
    assert seen["arrow"] == ["Head Ear.R"]


def test_a_dragged_weight_gives_way_and_undo_brings_it_back(seen: dict):
    value, moved = seen["weight"]
    assert 0.0 < value < 1.0
    assert moved > 0.001
    assert seen["weight_undone"][0] == 1.0
    assert seen["weight_undone"][1] < FLOAT32


def test_a_region_is_renamed_in_place_and_its_group_stays(seen: dict):
    assert seen["renamed"] == [NAMES, "Ear.L"]


def test_regions_move_up_and_down_and_the_shape_stays(seen: dict):
    assert seen["active"] == 2
    assert seen["up"][0] == ["ear", "Muzzle", "Ear.R", "Back"]
    assert seen["down"][0] == NAMES
    assert max(seen["up"][1], seen["down"][1]) < FLOAT32


def test_a_deleted_control_leaves_the_region_and_another_is_picked_in_the_list(seen: dict):
    missing, moved = seen["missing"]
    assert missing
    assert moved < FLOAT32
    picked, jumped = seen["picked"]
    assert picked == "Other"
    assert jumped < FLOAT32
    assert seen["follows_picked"] == pytest.approx(0.25, abs=1e-5)


def test_a_brush_stroke_takes_effect_when_it_ends(seen: dict):
    assert seen["painting"] == "Ear.L"
    assert seen["painted_away"] > 1.0
    assert seen["paint_changed"] > 0.01
    assert seen["paint_as_bound_anew"] < FLOAT32


def test_new_vertices_show_rest_and_the_button_binds_again(seen: dict):
    level, status, moved = seen["topology"]
    assert (level, status) == ("ERROR", "Topology changed - Rebind")
    assert moved == 0.0
    level, vertices, status = seen["rebound"]
    assert level == "INFO"
    assert f"{vertices:,} vertices" in status
    assert seen["lifted_again"] == pytest.approx(LIFT + 0.25, abs=0.05)


def test_automatic_rebind_needs_no_button(seen: dict):
    level, vertices, status = seen["automatic"]
    assert level == "INFO"
    assert vertices > seen["rebound"][1]
    assert f"{vertices:,} vertices" in status
    assert seen["lifted_automatically"] == pytest.approx(seen["lifted_again"], abs=0.01)


def test_a_heavy_drag_is_answered_by_a_thread_and_settles(seen: dict):
    """The surface is on its way while the mouse still moves, and at the control in the end."""
    assert seen["in_thread"]
    assert seen["unsettled"]
    assert seen["lifts"][-1] > 0.0
    assert seen["heavy_settled"]
    control, surface = seen["heavy_lift"]
    assert control > 0.1
    assert surface == pytest.approx(control, abs=0.05)
