# SPDX-License-Identifier: GPL-3.0-or-later
"""Overlays, the handle list, a weight brush, new vertices, a heavy drag in a real window. Needs a display."""

import numpy as np
import pytest
from blender_window import drive

TIMEOUT = 300.0  # a minute on a quiet machine
NAMES = ["ear", "Ear.R", "Muzzle", "Back"]
FLOAT32 = 2e-6  # of a head 4 units wide
LIFT = 0.45
SLACK = 0.04  # the viewport mixes in linear light and rounds to 8 bits; the oracle here does neither
HEAVY_SHAPE = 0.04  # 1 % of the grid
STEADY = 0.002  # of the pixels: anti-aliasing is never twice the same


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_handles.py`` observed."""
    return drive("drive_handles.py", tmp_path_factory.mktemp("handles"), TIMEOUT)


def colour(seen: dict, picture: str, spot: str) -> np.ndarray:
    return np.array(seen["pixels"][picture][spot])


def redness(rgb: np.ndarray) -> float:
    return float(rgb[0] - rgb[2])


@pytest.mark.parametrize("spot", ["ear", "back"])
def test_regions_have_the_colours_of_their_swatches(seen: dict, spot: str):
    """Over what the viewport shows without overlays; in Edit Mode, too, beside the wires."""
    share = seen["opacity"]
    expected = (1.0 - share) * colour(seen, "off", spot) + share * np.array(seen["colours"][spot])
    assert np.abs(colour(seen, "regions", spot) - expected).max() < SLACK
    if spot == "ear":
        assert np.abs(colour(seen, "edit", spot) - colour(seen, "regions", spot)).max() < SLACK


def test_free_parts_keep_their_shading(seen: dict):
    assert np.abs(colour(seen, "regions", "free") - colour(seen, "off", "free")).max() < 0.01


def test_what_is_stretched_is_red_and_what_is_rigid_grey(seen: dict):
    assert redness(colour(seen, "area", "stretched")) > 0.2
    assert abs(redness(colour(seen, "area", "ear"))) < 0.03
    assert redness(colour(seen, "off", "stretched")) < 0.02


def test_overlays_show_while_they_are_on(seen: dict):
    for name in ("regions", "area"):
        assert seen["changed"][name] > 0.05
    assert not seen["drawing_when_off"]
    assert seen["changed"]["off-again"] < STEADY


def test_redraws_without_a_change_paint_nothing(seen: dict):
    assert seen["painted_while_idle"] == 0


def test_x_ray_shows_each_place_once(seen: dict):
    """The far side of the ear does not add to the near side."""
    plain, through = colour(seen, "regions", "ear"), colour(seen, "x-ray", "ear")
    assert np.abs(redness(plain) - redness(through)) < 0.08


def test_disabling_the_add_on_clears_the_picture(seen: dict):
    drawing, changed = seen["disabled"]
    assert seen["before_disabled"] > 10.0 * STEADY
    assert not drawing
    assert changed < STEADY


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


def test_a_preview_is_marked_until_it_is_final(seen: dict):
    assert seen["marked"]


def test_undo_of_a_heavy_drag_binds_nothing_and_shows_no_preview(seen: dict):
    assert seen["undo_binds"] == 0
    assert seen["undo_keeps_factor"]
    assert seen["undo_off"] < HEAVY_SHAPE
