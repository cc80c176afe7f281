# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a bake writes, and that whatever goes wrong leaves everything as it was."""

import os
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import FRAMES, TARGETS, animate, assert_same, bake, footprint, played
from inside import inner
from rigs.rig import Rig, fails, grid_object, key, make_active

# Paths


def test_the_default_path_is_beside_the_file_under_safe_names(saved: Rig, tmp_path: Path):
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


def test_a_path_that_a_file_brings_along_is_used_only_beside_it(saved: Rig, tmp_path: Path):
    for hostile in ("//../victim.pc2", str(tmp_path / "victim.pc2"), "//sub/../../victim.pc2"):
        saved.deformer.bake.filepath = hostile
        fails("outside", bake, saved, "PC2")
    assert not list(tmp_path.rglob("*.pc2"))
    bake(saved, "PC2", tmp_path / "victim.pc2")  # the user's own word
    assert (tmp_path / "victim.pc2").is_file()


def test_a_link_does_not_lead_a_bake_away_from_the_file(saved: Rig, tmp_path: Path):
    link = tmp_path / "shot" / "sinew_cache"
    (tmp_path / "elsewhere").mkdir()
    link.symlink_to(tmp_path / "elsewhere")
    if not link.is_symlink():
        pytest.skip("Wine shows its links to nobody")
    fails("outside", bake, saved, "PC2")
    assert not list(tmp_path.rglob("*.pc2"))


def test_a_bake_never_replaces_a_file_of_another_kind(saved: Rig, tmp_path: Path):
    bake(saved, "PC2", tmp_path / "shot" / "scene.blend")
    assert (tmp_path / "shot" / "scene.blend").read_bytes()[:3] != b"POI"
    assert (tmp_path / "shot" / "scene.blend.pc2").is_file()


@pytest.mark.parametrize("at_once", [False, True])
@pytest.mark.parametrize("names", [("a:b", "a*b"), ("漢" * 84 + "a", "漢" * 84 + "b")], ids=["alike", "long"])
def test_objects_whose_names_look_alike_get_files_of_their_own(saved: Rig, names: tuple, at_once: bool):
    rigs = (saved, Rig(grid_object("Other")).bind())
    animate(rigs[1].control, angle=20.0)
    for rig, name in zip(rigs, names):  # Blender before 5.0 keeps 63 bytes of a name
        obj = rig.obj
        obj.name = name
        rig.name = obj.name
    live = [played(rig.obj) for rig in rigs]
    if at_once:
        make_active(*(rig.obj for rig in rigs))
        assert bpy.ops.sinew.bake(target="PC2", all_deformers=True) == {"FINISHED"}
    else:
        for rig in rigs:
            bake(rig, "PC2")
    for rig, shapes in zip(rigs, live, strict=True):
        assert rig.deformer.bake.is_baked
        assert_same(played(rig.obj), shapes)


def test_unbake_deletes_only_its_own_file_and_only_when_told(saved: Rig, tmp_path: Path):
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


def test_a_refused_frame_is_named_and_leaves_all_as_it_was(saved: Rig, tmp_path: Path):
    control = saved.control
    whole, gone = {"scale": (1.0, 1.0, 1.0)}, {"scale": (0.0, 0.0, 0.0)}
    key(control, {1: whole, 4: whole, 5: gone})
    control.parent.scale = (1.0, 1.0, 1.0)
    key(saved.obj, {4: whole, 5: gone})
    bpy.context.scene.frame_set(2)
    before = footprint(saved)
    for target in TARGETS:
        fails(r"Frame 5: .*scale", bake, saved, target)
        assert footprint(saved) == before
    assert sorted(path.name for path in (tmp_path / "shot").iterdir()) == ["scene.blend"]


@pytest.mark.parametrize("room_left", [0, 3000])
def test_a_full_disk_is_reported_and_keeps_the_older_file(saved: Rig, tmp_path: Path, room_left: int):
    resource = pytest.importorskip("resource", reason="limits the size of files as Unix does")
    path = tmp_path / "plate.pc2"
    path.write_text("older")
    before = footprint(saved)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room_left, limits[1]))
    try:
        fails(r"Cannot write .*free some disk space", bake, saved, "PC2", path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_text() == "older"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["plate.pc2", "shot"]
    assert footprint(saved) == before


@pytest.mark.parametrize("second", TARGETS)
@pytest.mark.parametrize("first", ["NONE", *TARGETS])
def test_baking_again_takes_the_new_motion_and_cancel_keeps_the_old(saved: Rig, first: str, second: str):
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


def test_settings_that_no_panel_could_make_do_no_harm(saved: Rig, tmp_path: Path):
    stored = saved.obj.sinew.deformers[0].bake
    try:
        group = saved.obj["sinew"]["deformers"][0]["bake"]
    except (KeyError, TypeError):  # Blender 5.0 keeps them out of reach
        return
    for name, value in (("result", 77), ("target", -3), ("step", 0), ("frame_end", 2**31 - 1)):
        group[name] = value
    group["filepath"] = "x" * 5000
    assert not stored.is_baked
    assert stored.wanted == "PC2"
    live = played(saved.obj)
    bake(saved, "PC2", tmp_path / "plate")
    assert_same(played(saved.obj), live)
