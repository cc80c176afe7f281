# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys that edit an animation: added, moved and removed, and what each frame shows in every place."""

import math
import struct
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import assert_same, bake, played, stretch_time
from expected import faces_of
from inside import catch_up, dragging, inner, native
from mathutils import Matrix, Vector
from probe import render_points
from rigs import rig as scenes
from rigs.sheet import WIDE, draw_panel
from second_blender import another_blender

FRAMES = range(1, 21)
SINGLE = 2e-5  # an edit and its map, both stored in single precision, at coordinates near 1
ITERATED = 1e-3  # where an edit differs in its last digit, the method may stop a step earlier


@pytest.fixture
def swaying(plate: scenes.Rig) -> scenes.Rig:
    """A plate that a shape key bends over the frames 1 to 20, with the method that has keys."""
    sway(plate.obj)
    return plate.bind("mesh_sequence")


def sway(obj: bpy.types.Object) -> None:
    obj.shape_key_add(name="Basis")
    block = obj.shape_key_add(name="Sway")
    for point in block.data:
        x, y, _z = point.co
        point.co = (x + 0.1 * y, y * 0.9 + 0.1 * x, 0.4 * y * y + 0.3 * y + 0.05 * math.sin(5.0 * x))
    scenes.key(block, {1: {"value": 0.0}, 20: {"value": 1.0}})
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FRAMES[0], FRAMES[-1]
    go(1)


def go(frame: int) -> None:
    bpy.context.scene.frame_set(frame)


def entering(rig: scenes.Rig, frames=FRAMES) -> dict[int, np.ndarray]:
    """What enters the modifier, by frame."""
    modifier = rig.obj.modifiers[-1]
    modifier.show_viewport = False
    found = played(rig.obj, frames)
    modifier.show_viewport = True
    return found


def there(rig: scenes.Rig, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """What a frame shows, and what enters in it."""
    below = entering(rig, [frame])[frame]
    go(frame)
    return rig.points(), below


def key(rig: scenes.Rig, frame: int, motion: Matrix | None = None, **keywords) -> np.ndarray:
    """Edit a frame and key that; what it shows then."""
    go(frame)
    if motion is not None:
        scenes.move_world(rig.control, motion)
    scenes.press(rig.obj, "key_add", **keywords)
    return rig.points()


def rise(height: float, degrees: float = 0.0) -> Matrix:
    return Matrix.Translation((0.1 * height, 0.0, height)) @ Matrix.Rotation(math.radians(degrees), 4, "X")


def keyed(rig: scenes.Rig) -> scenes.Rig:
    """An edit at frame 10 that fades to both ends."""
    key(rig, 1, blank=True)
    key(rig, 10, rise(0.5, 20.0))
    key(rig, 20, blank=True)
    return rig


def key_panel() -> str:
    """All words in the panel, after a pause."""
    catch_up()
    return draw_panel(WIDE).texts()


def alike(rig: scenes.Rig, seen: np.ndarray, expected: np.ndarray) -> bool:
    """The same shape for edits that differ in their last digits; the handle is where it belongs."""
    return scenes.close(seen, expected, ITERATED) and scenes.close(seen[rig.top], expected[rig.top], SINGLE)


def frames_of(rig: scenes.Rig) -> list[int]:
    return [each.frame for each in rig.deformer.keys]


def test_a_key_keeps_the_edit_and_the_control_rests(swaying: scenes.Rig):
    go(10)
    before = entering(swaying, [10])[10]
    scenes.move_world(swaying.control, rise(0.5, 20.0))
    edited, place = swaying.points(), swaying.control.matrix_world.copy()
    assert np.abs(edited - before)[swaying.top].max() > 0.3
    assert "Top: moved in all frames" in key_panel()
    assert alike(swaying, key(swaying, 10), edited)
    assert swaying.control.matrix_world == place
    assert "moved in all frames" not in key_panel()
    go(15)  # one key is held in all frames
    assert np.abs(swaying.points() - entering(swaying, [15])[15])[swaying.top].max() > 0.3
    # From here the control edits further.
    go(10)
    scenes.move_world(swaying.control, Matrix.Translation((0.0, 0.0, 0.25)))
    more = swaying.points()
    assert scenes.close(more[swaying.top], edited[swaying.top] + (0.0, 0.0, 0.25), SINGLE)
    assert alike(swaying, key(swaying, 10), more)
    assert frames_of(swaying) == [10]


def test_frames_between_keys_are_those_of_the_library(swaying: scenes.Rig):
    """On Blender's own mesh and groups."""
    keyed(swaying)
    shapes, found = entering(swaying), played(swaying.obj, FRAMES)
    rows = np.array([(each.frame, 0, *each.edits[0].edit) for each in swaying.deformer.keys])
    method = native().MeshSequence(native().SurfaceMesh(swaying.rest(), faces_of(swaying.obj.data)))
    method.set_handles([swaying.top, swaying.base])
    expected, _reports = method.solve_frames(list(shapes), np.array(list(shapes.values())), keys=rows)
    for frame, points in zip(shapes, expected, strict=True):
        assert alike(swaying, found[frame], points), frame
    for frame in (1, 20):
        assert scenes.close(found[frame], shapes[frame])
    edits = [found[frame] - shapes[frame] for frame in FRAMES]
    assert np.abs(edits[9]).max() > 0.3
    assert np.abs(np.diff(edits, axis=0)).max() < 0.2  # smooth: no frame jumps


def test_without_an_animation_keys_play_by_themselves(plate: scenes.Rig):
    """Nothing that Blender evaluates changes from frame to frame then, but the edit does."""
    plate.bind("mesh_sequence")
    keyed(plate)
    found = played(plate.obj, (1, 4, 7, 10))
    heights = [found[frame][plate.top, 2].max() for frame in (1, 4, 7, 10)]
    assert heights == sorted(heights)
    assert abs(heights[0]) < SINGLE
    assert heights[3] > 0.4
    bpy.context.scene.frame_set(4, subframe=0.5)
    assert heights[1] < plate.points()[plate.top, 2].max() < heights[2]


def test_keys_move_and_go_like_keyframes(swaying: scenes.Rig):
    """Without edits the animation is reproduced."""
    keyed(swaying)
    before = played(swaying.obj, FRAMES)
    scenes.press(swaying.obj, "key_move", index=1, frame=14)
    assert (frames_of(swaying), swaying.deformer.active_key) == ([1, 14, 20], 1)
    assert not scenes.close(*there(swaying, 14), 0.3)
    bpy.ops.sinew.key_move(index=1, frame=30)
    assert (frames_of(swaying), swaying.deformer.active_key) == ([1, 20, 30], 2)
    bpy.ops.sinew.key_move(index=2, frame=1)  # on another one, which it replaces
    assert frames_of(swaying) == [1, 20]
    bpy.ops.sinew.key_move(index=0, frame=10)
    key(swaying, 1, blank=True)
    assert_same(played(swaying.obj, FRAMES), before)
    swaying.deformer.active_key = 1
    bpy.ops.sinew.key_remove()
    assert frames_of(swaying) == [1, 20]
    for frame in FRAMES:
        assert scenes.close(*there(swaying, frame)), frame
    swaying.deformer.method = "arap"  # which has no keys
    scenes.update()
    assert not bpy.ops.sinew.key_add.poll()


def test_the_list_jumps_from_key_to_key_also_in_stretched_time(swaying: scenes.Rig):
    keyed(swaying)
    scenes.make_active(swaying.obj)
    scene = bpy.context.scene
    go(12)
    for to, frame, index in (("NEXT", 20, 2), ("PREVIOUS", 10, 1), ("PREVIOUS", 1, 0)):
        bpy.ops.sinew.key_jump(to=to)
        assert (scene.frame_current, swaying.deformer.active_key) == (frame, index)
    scenes.refused("no key before this frame", "key_jump", to="PREVIOUS")
    bpy.ops.sinew.key_jump(index=1)
    assert scene.frame_current == 10
    stretch_time(100, 50)
    go(6)
    for to, frame, played_frame in (("NEXT", 10, 20), ("PREVIOUS", 5, 10)):
        bpy.ops.sinew.key_jump(to=to)
        assert (scene.frame_current, scene.frame_current_final) == (frame, played_frame)


def test_a_frame_changed_in_the_list_moves_the_key(swaying: scenes.Rig):
    """Two keys may meet on the way: the lower one counts, and the panel says so."""
    keyed(swaying)
    swaying.deformer.keys[1].frame = 20
    go(20)
    assert "Two keys are at frame 20: the lower one counts" in key_panel()
    assert scenes.close(*there(swaying, 20))
    swaying.deformer.keys[1].frame = 5
    assert not scenes.close(*there(swaying, 5), 0.3)


def test_keys_are_saved_and_a_farm_sees_the_same_bits(swaying: scenes.Rig, addon_name: str, tmp_path: Path):
    """In any order of the frames, and in renders."""
    keyed(swaying)
    before = played(swaying.obj, FRAMES)
    scenes.reopen(tmp_path / "shot.blend")
    assert_same(played(swaying.obj, FRAMES), before)
    for frame in (10, 6):
        go(frame)
        assert np.array_equal(render_points(swaying.obj), before[frame])
    script = """
    bpy.ops.wm.open_mainfile(filepath={path!r})
    for frame in {frames!r}:
        bpy.context.scene.frame_set(frame)
        seen[str(frame)] = evaluated_points(bpy.data.objects["Plate"]).tolist()
    """.format(path=str(tmp_path / "shot.blend"), frames=[14, 10, 6])
    seen = another_blender(script, tmp_path, addon_name)
    for frame in (14, 10, 6):
        assert np.array_equal(np.array(seen[str(frame)]), before[frame])


def test_a_copy_has_keys_of_its_own(swaying: scenes.Rig):
    keyed(swaying)
    before = played(swaying.obj, FRAMES)
    copy = scenes.duplicated(swaying.obj)
    scenes.update()
    assert [each.frame for each in copy.sinew.active.keys] == [1, 10, 20]
    scenes.press(copy, "key_remove", index=1)
    assert_same(played(swaying.obj, FRAMES), before)
    go(10)
    assert scenes.close(scenes.evaluated_points(copy), there(swaying, 10)[1])


@pytest.mark.parametrize("target", ["PC2", "SHAPE_KEYS"])
def test_a_bake_of_some_frames_has_the_same_bits(plate: scenes.Rig, tmp_path: Path, target: str):
    if target == "PC2":
        sway(plate.obj)
    plate.bind("mesh_sequence")
    keyed(plate)
    live = played(plate.obj, FRAMES)
    bake(plate, target, tmp_path / "part", frame_start=8, frame_end=12)
    assert_same(played(plate.obj, range(8, 13)), {frame: live[frame] for frame in range(8, 13)})
    bpy.ops.sinew.unbake()
    assert_same(played(plate.obj, FRAMES), live)


def test_a_bone_that_moves_the_mesh_edits_by_what_it_does_beyond(plate: scenes.Rig):
    """From Rest: the control follows the animation, and only its own move counts; it turns along."""
    armature = scenes.add_armature(plate.obj)
    bone = armature.pose.bones["high"]
    scenes.key(bone, {frame: {"rotation_euler": (turn, 0.0, 0.0)} for frame, turn in ((1, 0.0), (20, 1.0))})
    go(1)
    follower = scenes.new_empty("Follower")
    follower.parent, follower.parent_type, follower.parent_bone = armature, "BONE", "high"
    scenes.update()
    plate.bind("mesh_sequence", control_object="Follower")
    plate.deformer.handles[0].from_rest = True
    for frame in (1, 20, 12):
        shown, below = there(plate, frame)
        assert alike(plate, shown, below)
    go(12)
    scenes.move_world(follower, Matrix.Translation((0.0, 0.0, 0.3)))
    edited = plate.points()
    assert scenes.close(edited[plate.top], below[plate.top] + (0.0, 0.0, 0.3), SINGLE)
    assert alike(plate, key(plate, 12), edited)
    before = bone.matrix.to_3x3()
    shown, below = there(plate, 20)
    moved = bone.matrix.to_3x3() @ before.inverted() @ Vector((0.0, 0.0, 0.3))
    assert scenes.close(shown[plate.top], below[plate.top] + np.array(moved), SINGLE)


def test_applied_transforms_take_the_keys_along(plate: scenes.Rig):
    plate.bind("mesh_sequence")
    keyed(plate)
    plate.obj.rotation_euler, plate.obj.scale = (0.3, 0.2, 0.9), (2.0, 2.0, 2.0)
    scenes.update()
    turned = {
        f: scenes.apply_matrix(plate.obj.matrix_world, p) for f, p in played(plate.obj, (5, 10)).items()
    }
    scenes.make_active(plate.obj)
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=True)
    for frame, points in played(plate.obj, (5, 10)).items():
        assert scenes.close(points, turned[frame], 1e-3), frame


def test_a_handle_that_comes_later_is_edited_by_its_own_keys(swaying: scenes.Rig):
    keyed(swaying)
    before = played(swaying.obj, FRAMES)
    go(1)
    scenes.add_group(swaying.obj, "Middle", lambda point: abs(point[0]) < 0.15 and abs(point[1]) < 0.15)
    scenes.press(swaying.obj, "handle_add", kind="HANDLE", vertex_group="Middle")
    for frame in (1, 20):
        go(frame)
        assert scenes.close(swaying.points(), before[frame], ITERATED)
    go(10)
    assert scenes.close(swaying.points()[swaying.top], before[10][swaying.top], SINGLE)
    scenes.press(swaying.obj, "handle_remove", index=2)
    for frame in (1, 10, 20):
        go(frame)
        # That bind took the shape of frame 10 as its rest shape, so the faces between have other weights.
        assert scenes.close(swaying.points(), before[frame], 0.02)
        assert scenes.close(swaying.points()[swaying.top], before[frame][swaying.top], SINGLE)


def test_a_key_that_is_no_number_is_named(swaying: scenes.Rig):
    keyed(swaying)
    go(10)
    for value, is_named in ((math.nan, True), (0.0, False)):
        swaying.deformer.keys[1].edits[0].edit[3] = value
        swaying.obj.update_tag()
        assert np.isfinite(swaying.points()).all()
        assert ("not finite" in swaying.deformer.status) is is_named


def test_an_animation_from_a_file_is_edited_and_missing_frames_are_named(plate: scenes.Rig, tmp_path: Path):
    rest = plate.rest()
    shapes = [rest + (0.0, 0.0, 0.1 * k) + 0.1 * k * rest[:, [1, 0, 2]] for k in range(10)]
    head = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(rest), 0.0, 1.0, len(shapes))
    (tmp_path / "run.pc2").write_bytes(head + np.array(shapes, dtype="<f4").tobytes())
    cache = plate.obj.modifiers.new("Take 1", "MESH_CACHE")
    cache.cache_format, cache.filepath, cache.frame_start = "PC2", str(tmp_path / "run.pc2"), 1.0
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 10
    go(1)
    plate.bind("mesh_sequence")
    key(plate, 1, blank=True)
    key(plate, 5, rise(0.4))
    go(5)
    assert scenes.close(plate.points()[plate.top], (shapes[4] + (0.04, 0.0, 0.4))[plate.top], SINGLE)
    assert scenes.close(plate.points()[plate.base], shapes[4][plate.base], SINGLE)
    assert "run.pc2" not in key_panel()
    scene.frame_end = 14
    assert "Take 1: run.pc2 has no frames 11 to 14 - its nearest frame is edited there" in key_panel()
    stretch_time(100, 50)
    assert "run.pc2 has no frames 6 to 14" in key_panel()
    stretch_time(100, 100)
    scenes.press(
        plate.obj, "bake", target="PC2", filepath=str(tmp_path / "out.pc2"), frame_start=9, frame_end=12
    )
    bpy.ops.sinew.unbake()
    (tmp_path / "torn.pc2").write_bytes(b"POINT")
    for name, said in (("gone", "the file gone.pc2 is missing"), ("torn", "torn.pc2 is no PC2 or MDD file")):
        cache.filepath = str(tmp_path / f"{name}.pc2")
        scenes.update()
        assert said in key_panel()


@pytest.fixture
def bent(plate: scenes.Rig, monkeypatch) -> Iterator[scenes.Rig]:
    """Plays by Playback: Draft: the plate bends by 110 degrees in the frames 1 to 20."""
    plate.bind("arap")
    plate.control.rotation_mode = "XYZ"
    flat = {"location": (0.0, 0.875, 0.0), "rotation_euler": (0.0, 0.0, 0.0)}
    over = {"location": (0.0, -0.025, 0.8), "rotation_euler": (math.radians(110.0), 0.0, 0.0)}
    scenes.key(plate.control, {1: flat, 20: over})
    plate.deformer.playback = "DRAFT"
    monkeypatch.setattr(inner.deferred, "is_playing", lambda: True)
    with dragging():  # what a window does when Blender evaluates what was written
        yield plate


def test_frames_are_drafts_until_playback_rests(bent: scenes.Rig, monkeypatch):
    """After few iterations, and the same for each frame. A method without iterations has none."""
    drafts = played(bent.obj, (1, 8, 15, 20))
    assert inner.sessions.is_draft(bent.deformer.uid)
    assert "Draft - the full shape follows when playback rests" in draw_panel().texts()
    assert inner.refining.marks() == ["Draft of Plate"]
    assert_same(played(bent.obj, (15, 1, 20, 8)), drafts)  # whatever was shown before
    with monkeypatch.context() as patch:
        patch.setattr(inner.deferred, "is_playing", lambda: False)
        assert inner.evaluate.settle()
        scenes.update()
        assert not inner.sessions.is_draft(bent.deformer.uid)
        assert not inner.sessions.unsettled()
        full = bent.points()
        assert not np.array_equal(full, drafts[8])
        assert np.abs(full - drafts[8]).max() < 0.05
        assert_same(played(bent.obj, (1, 8)), {8: full})
    bent.deformer.method = "thin_shell"
    go(5)
    assert not inner.sessions.unsettled()


def test_full_playback_renders_and_bakes_are_never_drafts(bent: scenes.Rig, tmp_path: Path, monkeypatch):
    (draft,) = played(bent.obj, [7]).values()
    rendered = render_points(bent.obj)
    assert not np.array_equal(rendered, draft)
    bent.deformer.playback = "FULL"
    full = played(bent.obj, range(5, 9))
    assert not inner.sessions.unsettled()
    assert np.array_equal(full[7], rendered)
    bent.deformer.playback = "DRAFT"
    bake(bent, "PC2", tmp_path / "plate", frame_start=5, frame_end=8)
    monkeypatch.undo()
    assert_same(played(bent.obj, range(5, 9)), full)
