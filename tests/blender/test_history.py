# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, redo, save, load, duplicate, delete, apply: properties stay the truth."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import OWNERS, catch_up
from mathutils import Matrix
from rig import FLOAT32, Rig, add_armature, add_group, evaluated_points, make_active, move_world, update


def push(message: str) -> None:
    update()
    bpy.ops.ed.undo_push(message=message)


def test_undo_of_a_bind_and_of_a_handle(plate: Rig):
    make_active(plate.obj)
    push("start")
    plate.bind()
    push("bound")
    plate.lift(0.5)
    push("moved")
    moved = plate.points()
    bpy.ops.ed.undo()
    bpy.ops.ed.undo()
    assert len(plate.obj.sinew.deformers) == 0
    assert len(plate.obj.modifiers) == 0
    assert np.array_equal(plate.points(), plate.rest())
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert np.abs(plate.points() - moved).max() < FLOAT32


def test_undo_to_a_step_that_was_saved_before_it_was_solved(plate: Rig, room):
    """Blender then brings back a shape mesh that is older than the pose."""
    plate.bind()
    push("bound")
    handlers, handler = (
        bpy.app.handlers.depsgraph_update_post,
        room("handlers.evaluation").on_depsgraph_update,
    )
    handlers.remove(handler)
    plate.lift(0.5)
    push("moved, not solved")
    handlers.append(handler)
    plate.obj.update_tag()
    moved = plate.points()
    assert moved[plate.top, 2] == pytest.approx(0.5, abs=FLOAT32)
    plate.obj.location.x += 1.0
    push("later")
    bpy.ops.ed.undo()
    assert np.array_equal(plate.points(), moved)


def save_and_load(plate: Rig, folder: Path) -> None:
    path = str(folder / "rig.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)


def test_load_on_a_posed_frame_rebuilds_the_same_session(plate: Rig, tmp_path: Path):
    """Rest is what entered at bind, not what enters when the file is opened."""
    armature = add_armature(plate.obj)
    plate.bind("arap")
    bone = armature.pose.bones["high"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (20, 0.9)):
        bone.rotation_euler.x = angle
        bone.keyframe_insert("rotation_euler", frame=frame)
        plate.control.location.z = angle
        plate.control.keyframe_insert("location", frame=frame)
    frames = {}
    for frame in (1, 12, 20):
        bpy.context.scene.frame_set(frame)
        frames[frame] = plate.points()
    save_and_load(plate, tmp_path)
    for frame in (20, 1, 12):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(plate.points(), frames[frame])


def test_without_the_add_on_a_file_shows_the_last_solution(plate: Rig, tmp_path: Path, addon, capfd):
    plate.bind().lift(0.5)
    plate.deformer.factor = 0.5
    before = plate.points()
    path = str(tmp_path / "rig.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon.unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects[plate.name]
        assert np.array_equal(evaluated_points(obj), before)
        bpy.context.scene.frame_set(5)
        assert np.array_equal(evaluated_points(obj), before)
        assert "Error" not in "".join(capfd.readouterr())
    finally:
        addon.register()


@pytest.mark.parametrize("linked", [False, True])
def test_a_copy_gets_shapes_of_its_own(plate: Rig, room, linked: bool):
    """``linked``: both objects show one mesh datablock, each in its own pose."""
    plate.bind().lift(0.5)
    make_active(plate.obj)
    bpy.ops.object.duplicate(linked=linked)
    copy = bpy.context.object
    assert copy != plate.obj
    assert room(OWNERS).has_copies()
    assert catch_up() is False
    assert not room(OWNERS).has_copies()
    assert copy.sinew.deformers[0].proxy != plate.deformer.proxy
    assert copy.sinew.deformers[0].uid != plate.deformer.uid
    before = evaluated_points(copy)
    copy.sinew.deformers[0].handles[0].control = copy_of(plate.control)
    update()
    assert (
        np.abs(evaluated_points(copy) - before).max() < FLOAT32
    )  # a new control takes over where the old one was
    move_world(copy.sinew.deformers[0].handles[0].control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert evaluated_points(copy)[plate.top, 2] == pytest.approx(0.75, abs=1e-5)
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=FLOAT32)


def test_an_exchanged_control_is_kept_evaluated_too(plate: Rig):
    plate.bind()
    new = bpy.data.objects.new("New", None)
    bpy.context.scene.collection.objects.link(new)
    plate.deformer.handles[0].control = new
    update()
    catch_up()
    for frame, height in ((1, 0.0), (11, 1.0)):
        new.location.z = height
        new.keyframe_insert("location", frame=frame)
    new.hide_viewport = True
    bpy.context.scene.frame_set(11)
    assert plate.points()[plate.top, 2] == pytest.approx(1.0, abs=1e-5)


def copy_of(obj: bpy.types.Object) -> bpy.types.Object:
    copy = obj.copy()
    bpy.context.scene.collection.objects.link(copy)
    return copy


def test_rendering_separates_copies_in_background(plate: Rig):
    plate.bind()
    make_active(plate.obj)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    bpy.ops.wm.save_as_mainfile(filepath=bpy.app.tempdir + "copy.blend")
    assert copy.sinew.deformers[0].proxy != plate.deformer.proxy


def test_removing_a_deformer_leaves_nothing_behind(plate: Rig):
    before = {kind: len(getattr(bpy.data, kind)) for kind in ("objects", "meshes")}
    groups = len(plate.obj.vertex_groups)
    plate.bind().lift(0.5)
    make_active(plate.obj)
    bpy.ops.sinew.deformer_remove()
    assert {kind: len(getattr(bpy.data, kind)) for kind in before} == before
    assert len(plate.obj.modifiers) == 0
    assert len(plate.obj.vertex_groups) == groups  # these were the user's
    assert plate.obj.animation_data is None or len(plate.obj.animation_data.drivers) == 0
    assert np.array_equal(plate.points(), plate.rest())


def test_removing_a_handle_frees_its_region(plate: Rig):
    plate.bind().lift(0.5)
    make_active(plate.obj)
    with pytest.raises(RuntimeError, match="there is no number 7"):
        bpy.ops.sinew.handle_remove(index=7)
    assert len(plate.deformer.handles) == 2
    bpy.ops.sinew.handle_remove(index=1)
    assert len(plate.deformer.handles) == 1
    assert np.abs(plate.points() - plate.rest() - (0.0, 0.0, 0.5)).max() < FLOAT32
    bpy.ops.sinew.handle_remove(index=0)
    assert np.array_equal(plate.points(), plate.rest())


def test_deleted_control_leaves_its_region_where_it_was(plate: Rig, tmp_path: Path):
    plate.bind()
    move_world(plate.control, Matrix.Translation((0.1, 0.0, 0.5)) @ Matrix.Rotation(0.3, 4, "X"))
    before = plate.points()
    bpy.data.objects.remove(plate.control)
    assert np.abs(plate.points() - before).max() < FLOAT32
    assert plate.deformer.handles[0].control_missing
    save_and_load(plate, tmp_path)
    assert np.abs(plate.points() - before).max() < 1e-5
    new = bpy.data.objects.new("New", None)
    bpy.context.scene.collection.objects.link(new)
    new.location = (3.0, 2.0, 1.0)
    update()
    plate.deformer.handles[0].control = new
    assert np.abs(plate.points() - before).max() < 1e-5
    assert not plate.deformer.handles[0].control_missing
    new.location.z += 0.5
    assert np.abs(plate.points()[plate.top] - before[plate.top] - (0.0, 0.0, 0.5)).max() < 1e-5


@pytest.mark.parametrize("factor", [1.0, 0.0])
def test_the_pose_of_a_soft_region_without_control_is_saved(plate: Rig, tmp_path: Path, factor: float):
    """The saved shape does not tell it: soft vertices give way, and Factor 0 shows rest."""
    plate.bind("thin_shell")
    plate.deformer.handles[0].weight = 0.5
    plate.lift(0.5)
    before = plate.points()
    bpy.data.objects.remove(plate.control)
    assert np.abs(plate.points() - before).max() < 1e-6
    plate.deformer.factor = factor
    update()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lost.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "lost.blend"))
    plate.deformer.factor = 1.0
    assert np.abs(plate.points() - before).max() < 1e-6


def test_what_a_deformer_without_regions_lets_through_reaches_the_next_at_once(plate: Rig):
    plate.bind("thin_shell")
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.deformer_add(method="thin_shell")
    add_group(plate.obj, "Corner", lambda point: point[0] < -0.75 and point[1] < 0.5)
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Corner")
    first = plate.obj.sinew.deformers[0].handles[0].control
    move_world(first, Matrix.Translation((0.0, 0.0, 0.4)))
    once = plate.points()
    plate.obj.update_tag()
    assert np.array_equal(plate.points(), once)


def test_operators_find_the_mesh_from_its_control(plate: Rig):
    plate.bind().lift(0.5)
    make_active(plate.control)
    assert bpy.ops.sinew.unbind() == {"FINISHED"}
    assert np.array_equal(plate.points(), plate.rest())


def test_deleting_the_mesh_leaves_no_ghost(plate: Rig):
    plate.bind()
    make_active(plate.obj)
    bpy.ops.object.delete()
    update()
    assert plate.name not in bpy.data.objects
