# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of several deformers, and through renames, copies, undo, saves and overrides."""

from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest
from baking import CACHES, FRAMES, TARGETS, animate, assert_same, bake, played
from inside import settle
from libraries import overridden, override, put_into_a_library
from rigs.rig import (
    Rig,
    add_group,
    add_regions,
    duplicated,
    grid_object,
    load,
    make_active,
    reopen,
    save,
    update,
)
from rigs.sheet import WIDE, draw, draw_panel

# Several


def two_deformers(plate: Rig) -> Rig:
    obj = plate.obj
    add_group(obj, "Corner", lambda point: point[0] > 0.75 and point[1] > 0.75)
    add_group(obj, "Rest", lambda point: point[0] < 0.3 or point[1] < 0.3)
    add_regions(obj, "thin_shell", {"Corner": "HANDLE", "Rest": "FIXED"})
    animate(obj.sinew.deformers[1].handles[0].control, angle=20.0)
    return plate


@pytest.mark.parametrize("baked", [0, 1])
def test_deformers_of_one_stack_are_baked_one_by_one(moving: Rig, tmp_path: Path, baked: int):
    obj = two_deformers(moving).obj
    live = played(obj)
    obj.sinew.active_deformer = baked
    bake(moving, "PC2", tmp_path / "one")
    assert [deformer.bake.is_baked for deformer in obj.sinew.deformers] == [baked == 0, baked == 1]
    assert_same(played(obj), live)
    obj.sinew.active_deformer = 1 - baked
    bake(moving, "MDD", tmp_path / "other")
    assert_same(played(obj), live)
    bpy.ops.sinew.unbake()
    assert_same(played(obj), live)
    bpy.ops.sinew.unbake(all_deformers=True)
    assert_same(played(obj), live)
    assert [modifier.type for modifier in obj.modifiers] == ["NODES", "NODES"]


@pytest.mark.parametrize("target", TARGETS)
def test_all_deformers_of_all_selected_meshes_are_baked_at_once(saved: Rig, target: str):
    rigs = (two_deformers(saved), Rig(grid_object("Second")).bind("arap"))
    animate(rigs[1].control, angle=40.0)
    live = [played(rig.obj) for rig in rigs]
    make_active(*(rig.obj for rig in rigs))
    assert bpy.ops.sinew.bake(target=target, all_deformers=True) == {"FINISHED"}
    for rig, shapes in zip(rigs, live, strict=True):
        assert all(deformer.bake.is_baked for deformer in rig.obj.sinew.deformers)
        now = played(rig.obj)
        error = max(np.abs(now[frame] - shapes[frame]).max() for frame in FRAMES)
        # keys of two deformers are summed in float32
        assert error <= (5e-7 if target == "SHAPE_KEYS" and rig is saved else 0.0)
    assert bpy.ops.sinew.unbake(all_deformers=True) == {"FINISHED"}
    for rig, shapes in zip(rigs, live, strict=True):
        assert_same(played(rig.obj), shapes)


# Renames, copies, files


def test_unbake_finds_its_modifier_after_renames_and_leaves_others(saved: Rig):
    obj = saved.obj
    live = played(obj)
    bake(saved, "PC2")
    mine = obj.modifiers.new("Mine", "MESH_CACHE")
    mine.cache_format, mine.filepath, mine.show_viewport = "PC2", "//other.pc2", False
    for modifier, name in zip(obj.modifiers, ("Ours", "Played", "Sheet Cache"), strict=True):
        modifier.name = name
    saved.deformer.name = "Renamed"
    make_active(obj)
    bpy.ops.sinew.unbake()
    assert [modifier.name for modifier in obj.modifiers] == ["Ours", "Sheet Cache"]
    assert_same(played(obj), live)


def test_shape_keys_that_the_user_renamed_stay(moving: Rig):
    bake(moving, "SHAPE_KEYS")
    keys = moving.obj.data.shape_keys.key_blocks
    keys["Sheet 3"].name = "Smile"
    bpy.ops.sinew.unbake()
    assert [key.name for key in moving.obj.data.shape_keys.key_blocks] == ["Basis", "Smile"]


def test_a_copy_plays_and_unbakes_by_itself(saved: Rig):
    live = played(saved.obj)
    bake(saved, "PC2")
    copy = duplicated(saved.obj)
    settle()
    assert_same(played(copy), live)
    make_active(copy)
    bpy.ops.sinew.unbake(delete_file=True)  # the original still plays it
    assert not copy.sinew.deformers[0].bake.is_baked
    assert saved.deformer.bake.is_baked
    assert_same(played(saved.obj), live)


@pytest.mark.parametrize("target", TARGETS)
def test_a_baked_file_plays_moved_and_without_the_add_on(
    saved: Rig, tmp_path: Path, target: str, addon_name: str
):
    live = played(saved.obj)
    bake(saved, target)
    bpy.ops.wm.save_mainfile()
    moved = (tmp_path / "shot").rename(tmp_path / "farm")
    addon_utils.disable(addon_name)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(moved / "scene.blend"))
        assert_same(played(bpy.data.objects["Plate"]), live)
    finally:
        addon_utils.enable(addon_name, default_set=True)
    bpy.ops.wm.open_mainfile(filepath=str(moved / "scene.blend"))
    update()
    assert saved.deformer.status == "Baked frames 1-8"
    assert_same(played(saved.obj), live)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    update()
    assert saved.deformer.status == "Baked frames 1-8"
    make_active(saved.obj)
    bpy.ops.sinew.unbake()
    assert [modifier.type for modifier in saved.obj.modifiers] == ["NODES"]
    assert_same(played(saved.obj), live)


def press(name: str) -> set[str]:
    """The first button of the panel that calls this operator, with its properties."""
    settings = next(settings for shown, settings in draw_panel().operators() if shown == name)
    return getattr(bpy.ops.sinew, name.partition(".")[2])(**vars(settings))


@pytest.mark.parametrize("target", CACHES)
def test_a_missing_cache_file_is_said_with_a_button_for_each_remedy(saved: Rig, tmp_path: Path, target: str):
    """So is a modifier that is gone."""
    chosen = range(2, 7, 2)
    live = played(saved.obj, chosen)

    def plays() -> None:
        assert_same(played(saved.obj, chosen), live)
        assert saved.deformer.status_level == "INFO", saved.deformer.status

    saved.deformer.bake.step = 2
    bake(saved, target, frame_start=2, frame_end=6, step=2)
    (file,) = tmp_path.rglob(f"*.{target.lower()}")
    file.rename(file.with_suffix(".kept"))
    reopen(tmp_path / "shot" / "scene.blend")
    update()
    assert "is missing" in saved.deformer.status
    assert file.name in saved.deformer.status
    file.with_suffix(".kept").rename(file)
    load(bpy.data.filepath)
    plays()
    saved.obj.modifiers.remove(saved.obj.modifiers[1])
    bpy.context.scene.frame_set(5)
    assert "Unbake" in saved.deformer.status
    assert press("sinew.unbake") == {"FINISHED"}
    plays()
    bake(saved, target, frame_start=2, frame_end=6, step=2)
    for remedy in ("sinew.bake", "sinew.unbake"):
        (file,) = tmp_path.rglob(f"*.{target.lower()}")
        file.unlink()
        bpy.context.scene.frame_set(4)
        assert saved.deformer.status_level == "ERROR"
        assert "missing" in saved.deformer.status
        assert press(remedy) == {"FINISHED"}
        plays()
        assert saved.deformer.bake.result == (target if remedy == "sinew.bake" else "NONE")


@pytest.mark.parametrize("target", TARGETS)
def test_while_baked_the_rows_are_greyed_out_and_the_panel_says_why(saved: Rig, target: str):
    shown = draw_panel()
    assert not shown.greyed
    bake(saved, target)
    sheet = draw_panel(WIDE)
    assert "Baked frames 1-8" in sheet.texts()
    assert {"handles", "factor", "sinew.choose_method", "sinew.handle_remove"} <= set(sheet.greyed)
    assert "sinew.unbake" not in sheet.greyed
    for operator in (bpy.ops.sinew.bind, bpy.ops.sinew.unbind):
        assert not operator.poll()
    assert {"kind", "weight"} <= set(draw(bpy.types.SINEW_PT_region).greyed)
    assert press("sinew.unbake") == {"FINISHED"}
    assert not draw_panel().greyed
    assert bpy.ops.sinew.bind.poll()


def test_an_override_is_baked(saved: Rig, tmp_path: Path):
    live = played(saved.obj)
    override(put_into_a_library(tmp_path / "shot" / "scene.blend", saved.obj, saved.control))
    save(tmp_path / "shot" / "over.blend")
    shown = played(overridden())
    assert max(np.abs(shown[frame] - live[frame]).max() for frame in FRAMES) < 1e-5
    make_active(overridden())
    assert bpy.ops.sinew.bake(target="PC2", frame_start=1, frame_end=8) == {"FINISHED"}
    assert_same(played(overridden()), shown)
    reopen(tmp_path / "shot" / "over.blend")
    assert_same(played(overridden()), shown)
    make_active(overridden())
    bpy.ops.sinew.unbake()
    assert_same(played(overridden()), shown)
