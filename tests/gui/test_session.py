# SPDX-License-Identifier: GPL-3.0-or-later
"""From a blank file to a rendered pose in a real window, and back. Needs a display, such as Xvfb's."""

import pytest
from blender_window import drive

TIMEOUT = 420.0  # a minute and a half on a quiet machine
REGIONS = [["HANDLE", "Handle"], ["FIXED", "Fixed"]]
FLOAT32 = 2e-6  # of a model 2 units long


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive.py`` observed."""
    found = drive("drive.py", tmp_path_factory.mktemp("session"), TIMEOUT)
    assert "Dependency cycle" not in found["said"], found["said"]
    return found


def test_the_menu_makes_a_handle_of_the_selection(seen: dict):
    assert seen["blank"] == []
    assert seen["after_menu"] == REGIONS[:1]


def test_the_pie_menu_adds_what_stays(seen: dict):
    assert seen["after_pie"] == REGIONS


def test_back_in_object_mode_the_control_alone_is_selected(seen: dict):
    assert seen["mode"] == "OBJECT"
    assert seen["selected"] == ["spot Handle"]
    assert "2,930 vertices, 1 handle, 1 fixed, " in seen["status"]
    assert "bound in" in seen["status"]


def test_the_surface_follows_the_drag(seen: dict):
    assert seen["during"] > 0.2
    assert seen["moved"] > 0.2
    assert seen["hooves_moved"] == 0.0


def test_the_final_answer_follows_the_preview(seen: dict):
    assert seen["settled"]


def test_turn_and_scale_follow_too(seen: dict):
    assert seen["turned"] > 0.05
    assert seen["scaled"] > 0.05
    assert seen["control_scale"] == pytest.approx([1.25] * 3, rel=1e-6)


def test_undo_takes_turn_and_drag_back_and_redo_brings_them(seen: dict):
    assert seen["first_undo"] < FLOAT32
    assert seen["second_undo"] < FLOAT32
    assert seen["redone"] < FLOAT32


def test_the_picture_changed_and_came_back(seen: dict):
    assert seen["pixels_moved"] > 0.03
    assert seen["pixels_not_undone"] < 0.002


def test_another_method_from_the_menu_keeps_the_regions_and_shows_at_once(seen: dict):
    assert seen["method"] == "thin_shell"
    assert seen["method_keeps"] == REGIONS
    assert seen["method_changed"] > 0.01


def test_the_slider_blends_between_rest_and_pose(seen: dict):
    assert 0.0 < seen["factor"] < 1.0
    assert seen["factor_error"] < FLOAT32


def test_undo_takes_the_settings_back(seen: dict):
    method, factor, difference = seen["settings_undone"]
    assert (method, factor) == ("arap", 1.0)
    assert difference < FLOAT32


def test_clearing_the_transform_of_a_control_brings_the_mesh_to_rest(seen: dict):
    assert seen["home"] < FLOAT32


def test_keyed_controls_animate_the_surface(seen: dict):
    assert seen["keyed"] == ["location", "rotation_euler", "scale"]
    for name, frame in (("first_frame", 1), ("last_frame", 12)):
        assert seen[name][0] == frame
        assert seen[name][1] < FLOAT32
    assert seen["between"] > 0.05
    assert seen["scrubbed"] == 0.0


def test_renders_show_what_the_window_shows(seen: dict):
    """The silhouette ends where the camera sees the outermost vertices, to a pixel and its filter."""
    assert len(seen["rendered"]) == 3
    for silhouette, outline, disturbed in seen["rendered"]:
        assert silhouette == pytest.approx(outline, abs=1.5)
        assert disturbed == 0.0
    heights = [outline[3] for _silhouette, outline, _disturbed in seen["rendered"]]
    assert heights[0] + 10.0 < heights[1] < heights[2] - 10.0


def test_undo_leads_back_to_the_bare_mesh(seen: dict):
    left = seen["all_undone"]
    assert left.pop("moved") == 0.0
    assert set(left.values()) == {0}, left


def test_grab_region_starts_by_its_key_and_the_surface_follows(seen: dict):
    assert seen["grab_dragged"] > 0.1
    assert seen["grab_followed"] > 500


def test_axis_number_and_enter_move_the_selection_by_just_that(seen: dict):
    assert seen["grab_typed"] < 1e-6
    assert seen["grab_last"] == ["SINEW_OT_grab_region", "TRANSLATE", [0.5, 0.0, 0.0]]


def test_one_undo_takes_a_grab_back_and_esc_restores_every_bit(seen: dict):
    assert seen["grab_undone"] == 0.0
    assert seen["grab_restored"]


def test_a_heavy_mesh_binds_in_a_thread_and_esc_cancels(seen: dict):
    assert seen["heavy_in_thread"]
    assert "160,801 vertices, 1 handle, 1 fixed, " in seen["heavy_status"]
    assert "cancelled" in seen["cancelled"]
    assert "bound in" in seen["bound_again"]


def test_esc_in_the_middle_of_a_transfer_leaves_all_as_it_was(seen: dict):
    assert seen["transfer_files"] == 1
    assert 3 < seen["transfer_frame"] < 5000
    assert seen["transfer_left"] == []
    assert seen["transfer_frame_after"] == 3
