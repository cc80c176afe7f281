# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a bake writes, and what goes wrong; bakes of several deformers, through renames, copies and saves."""

import os
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest
from baking import CACHES, FRAMES, TARGETS, animate, assert_same, bake, footprint, played
from inside import inner, settle
from libraries import overridden, override, put_into_a_library
from rigs import rig as scenes
from rigs.sheet import WIDE, draw, draw_panel

# Paths


def test_the_default_path_is_beside_the_file_under_safe_names(saved: scenes.Rig, tmp_path: Path):
    saved.obj.name = saved.name = "../../../evil:\\*?"
    saved.deformer.name = "..\\..\\x/y"
    bake(saved, "PC2")
    home = tmp_path / "shot"
    (file,) = [path for path in tmp_path.rglob("*") if path.suffix == ".pc2"]
    assert file.parent == home / "sinew_cache" / "scene"
    assert saved.obj.modifiers[1].filepath.startswith("//sinew_cache/scene/")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["shot"]
    assert file.stat().st_mode & 0o777 == 0o666 & ~current_umask()  # a farm reads it under another name


def current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_path_that_a_file_brings_along_is_used_only_beside_it(saved: scenes.Rig, tmp_path: Path):
    for hostile in ("//../victim.pc2", str(tmp_path / "victim.pc2"), "//sub/../../victim.pc2"):
        saved.deformer.bake.filepath = hostile
        scenes.fails("outside", bake, saved, "PC2")
    assert not list(tmp_path.rglob("*.pc2"))
    bake(saved, "PC2", tmp_path / "victim.pc2")  # the user's own word
    assert (tmp_path / "victim.pc2").is_file()


def test_a_link_does_not_lead_a_bake_away_from_the_file(saved: scenes.Rig, tmp_path: Path):
    link = tmp_path / "shot" / "sinew_cache"
    (tmp_path / "elsewhere").mkdir()
    link.symlink_to(tmp_path / "elsewhere")
    if not link.is_symlink():
        pytest.skip("Wine shows its links to nobody")
    scenes.fails("outside", bake, saved, "PC2")
    assert not list(tmp_path.rglob("*.pc2"))


def test_a_bake_never_replaces_a_file_of_another_kind(saved: scenes.Rig, tmp_path: Path):
    bake(saved, "PC2", tmp_path / "shot" / "scene.blend")
    assert (tmp_path / "shot" / "scene.blend").read_bytes()[:3] != b"POI"
    assert (tmp_path / "shot" / "scene.blend.pc2").is_file()


@pytest.mark.parametrize("at_once", [False, True])
@pytest.mark.parametrize("names", [("a:b", "a*b"), ("漢" * 84 + "a", "漢" * 84 + "b")], ids=["alike", "long"])
def test_objects_whose_names_look_alike_get_files_of_their_own(
    saved: scenes.Rig, names: tuple, at_once: bool
):
    rigs = (saved, scenes.Rig(scenes.grid_object("Other")).bind())
    animate(rigs[1].control, angle=20.0)
    for rig, name in zip(rigs, names):  # Blender before 5.0 keeps 63 bytes of a name
        obj = rig.obj
        obj.name = name
        rig.name = obj.name
    live = [played(rig.obj) for rig in rigs]
    if at_once:
        scenes.make_active(*(rig.obj for rig in rigs))
        assert bpy.ops.sinew.bake(target="PC2", all_deformers=True) == {"FINISHED"}
    else:
        for rig in rigs:
            bake(rig, "PC2")
    for rig, shapes in zip(rigs, live, strict=True):
        assert rig.deformer.bake.is_baked
        assert_same(played(rig.obj), shapes)


def test_unbake_deletes_only_its_own_file_and_only_when_told(saved: scenes.Rig, tmp_path: Path):
    bake(saved, "PC2")
    (file,) = tmp_path.rglob("*.pc2")
    bpy.ops.sinew.unbake()
    assert file.is_file()
    bake(saved, "PC2")
    bpy.ops.sinew.unbake(delete_file=True)
    assert not file.exists()
    victim = tmp_path / "victim.pc2"
    victim.write_text("mine")
    bake(saved, "PC2")
    saved.deformer.bake.filepath = str(victim)
    bpy.ops.sinew.unbake(delete_file=True)
    assert victim.read_text() == "mine"


# What goes wrong


def test_a_refused_frame_is_named_and_leaves_all_as_it_was(saved: scenes.Rig, tmp_path: Path):
    control = saved.control
    whole, gone = {"scale": (1.0, 1.0, 1.0)}, {"scale": (0.0, 0.0, 0.0)}
    scenes.key(control, {1: whole, 4: whole, 5: gone})
    control.parent.scale = (1.0, 1.0, 1.0)
    scenes.key(saved.obj, {4: whole, 5: gone})
    bpy.context.scene.frame_set(2)
    before = footprint(saved)
    for target in TARGETS:
        scenes.fails(r"Frame 5: .*scale", bake, saved, target)
        assert footprint(saved) == before
    assert sorted(path.name for path in (tmp_path / "shot").iterdir()) == ["scene.blend"]


@pytest.mark.parametrize("room_left", [0, 3000])
def test_a_full_disk_is_reported_and_keeps_the_older_file(saved: scenes.Rig, tmp_path: Path, room_left: int):
    resource = pytest.importorskip("resource", reason="limits the size of files as Unix does")
    path = tmp_path / "plate.pc2"
    path.write_text("older")
    before = footprint(saved)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room_left, limits[1]))
    try:
        scenes.fails(r"Cannot write .*free some disk space", bake, saved, "PC2", path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_text() == "older"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["plate.pc2", "shot"]
    assert footprint(saved) == before


@pytest.mark.parametrize("second", TARGETS)
@pytest.mark.parametrize("first", ["NONE", *TARGETS])
def test_baking_again_takes_the_new_motion_and_cancel_keeps_the_old(
    saved: scenes.Rig, first: str, second: str
):
    """So it does where nothing was baked before."""
    home = Path(bpy.data.filepath).parent
    saved.obj.modifiers.new("Subdivision", "SUBSURF")
    if first != "NONE":
        bake(saved, first)
        bpy.context.scene.frame_set(1)
        animate(saved.control, angle=30.0)
    old, files = played(saved.obj), sorted(home.rglob("*"))
    bpy.context.scene.frame_set(3)
    before = footprint(saved)
    request = inner.bake.Request(((saved.name, saved.deformer.uid),), second, FRAMES)
    baking = inner.bake.Baking(request, bpy.context.scene)
    assert baking.step()
    assert baking.step()
    assert list(home.rglob("*.part*")) or second == "SHAPE_KEYS"
    for _ in range(2):
        baking.cancel()
        assert footprint(saved) == before
    assert [path for path in sorted(home.rglob("*")) if path.is_file()] == [f for f in files if f.is_file()]
    assert_same(played(saved.obj), old)
    bake(saved, second)
    new = played(saved.obj)
    assert np.array_equal(new[8], old[8]) == (first == "NONE")
    bpy.ops.sinew.unbake()
    assert_same(played(saved.obj), new)
    assert [modifier.type for modifier in saved.obj.modifiers] == ["NODES", "SUBSURF"]
    assert saved.obj.data.shape_keys is None


# Several


def two_deformers(plate: scenes.Rig) -> scenes.Rig:
    obj = plate.obj
    scenes.add_group(obj, "Corner", lambda point: point[0] > 0.75 and point[1] > 0.75)
    scenes.add_group(obj, "Rest", lambda point: point[0] < 0.3 or point[1] < 0.3)
    scenes.add_regions(obj, "thin_shell", {"Corner": "HANDLE", "Rest": "FIXED"})
    animate(obj.sinew.deformers[1].handles[0].control, angle=20.0)
    return plate


@pytest.mark.parametrize("baked", [0, 1])
def test_deformers_of_one_stack_are_baked_one_by_one(moving: scenes.Rig, tmp_path: Path, baked: int):
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
def test_all_deformers_of_all_selected_meshes_are_baked_at_once(saved: scenes.Rig, target: str):
    rigs = (two_deformers(saved), scenes.Rig(scenes.grid_object("Second")).bind("arap"))
    animate(rigs[1].control, angle=40.0)
    live = [played(rig.obj) for rig in rigs]
    scenes.make_active(*(rig.obj for rig in rigs))
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


def test_unbake_finds_its_modifier_after_renames_and_leaves_others(saved: scenes.Rig):
    obj = saved.obj
    live = played(obj)
    bake(saved, "PC2")
    mine = obj.modifiers.new("Mine", "MESH_CACHE")
    mine.cache_format, mine.filepath, mine.show_viewport = "PC2", "//other.pc2", False
    for modifier, name in zip(obj.modifiers, ("Ours", "Played", "Sheet Cache"), strict=True):
        modifier.name = name
    saved.deformer.name = "Renamed"
    scenes.make_active(obj)
    bpy.ops.sinew.unbake()
    assert [modifier.name for modifier in obj.modifiers] == ["Ours", "Sheet Cache"]
    assert_same(played(obj), live)


def test_shape_keys_that_the_user_renamed_stay(moving: scenes.Rig):
    bake(moving, "SHAPE_KEYS")
    keys = moving.obj.data.shape_keys.key_blocks
    keys["Sheet 3"].name = "Smile"
    bpy.ops.sinew.unbake()
    assert [key.name for key in moving.obj.data.shape_keys.key_blocks] == ["Basis", "Smile"]


def test_a_copy_plays_and_unbakes_by_itself(saved: scenes.Rig):
    live = played(saved.obj)
    bake(saved, "PC2")
    copy = scenes.duplicated(saved.obj)
    settle()
    assert_same(played(copy), live)
    scenes.make_active(copy)
    bpy.ops.sinew.unbake(delete_file=True)  # the original still plays it
    assert not copy.sinew.deformers[0].bake.is_baked
    assert saved.deformer.bake.is_baked
    assert_same(played(saved.obj), live)


@pytest.mark.parametrize("target", TARGETS)
def test_a_baked_file_plays_moved_and_without_the_add_on(
    saved: scenes.Rig, tmp_path: Path, target: str, addon_name: str
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
    scenes.update()
    assert saved.deformer.status == "Baked frames 1-8"
    assert_same(played(saved.obj), live)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    scenes.update()
    assert saved.deformer.status == "Baked frames 1-8"
    scenes.make_active(saved.obj)
    bpy.ops.sinew.unbake()
    assert [modifier.type for modifier in saved.obj.modifiers] == ["NODES"]
    assert_same(played(saved.obj), live)


def press(name: str) -> set[str]:
    """The first button of the panel that calls this operator, with its properties."""
    settings = next(settings for shown, settings in draw_panel().operators() if shown == name)
    return getattr(bpy.ops.sinew, name.partition(".")[2])(**vars(settings))


@pytest.mark.parametrize("target", CACHES)
def test_a_missing_cache_file_is_said_with_a_button_for_each_remedy(
    saved: scenes.Rig, tmp_path: Path, target: str
):
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
    scenes.reopen(tmp_path / "shot" / "scene.blend")
    scenes.update()
    assert "is missing" in saved.deformer.status
    assert file.name in saved.deformer.status
    file.with_suffix(".kept").rename(file)
    scenes.load(bpy.data.filepath)
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
def test_while_baked_the_rows_are_greyed_out_and_the_panel_says_why(saved: scenes.Rig, target: str):
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


def test_an_override_is_baked(saved: scenes.Rig, tmp_path: Path):
    live = played(saved.obj)
    override(put_into_a_library(tmp_path / "shot" / "scene.blend", saved.obj, saved.control))
    scenes.save(tmp_path / "shot" / "over.blend")
    shown = played(overridden())
    assert max(np.abs(shown[frame] - live[frame]).max() for frame in FRAMES) < 1e-5
    scenes.make_active(overridden())
    assert bpy.ops.sinew.bake(target="PC2", frame_start=1, frame_end=8) == {"FINISHED"}
    assert_same(played(overridden()), shown)
    scenes.reopen(tmp_path / "shot" / "over.blend")
    assert_same(played(overridden()), shown)
    scenes.make_active(overridden())
    bpy.ops.sinew.unbake()
    assert_same(played(overridden()), shown)
