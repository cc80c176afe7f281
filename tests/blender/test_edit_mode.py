# SPDX-License-Identifier: GPL-3.0-or-later
"""What a rigger does in Edit Mode: select, Add Handle, Add Fixed, Set Support, undo."""

import bmesh
import bpy
import numpy as np
import pytest
from editing import edit, select
from mathutils import Matrix
from rig import Rig, grid_object, in_mode, linked, make_active, move_world, push


def test_from_selection_to_pose():
    obj = grid_object()
    top = edit(obj, lambda point: point.y > 0.75)
    assert bpy.ops.sinew.handle_add(kind="HANDLE") == {"FINISHED"}
    assert obj.mode == "EDIT"
    base = select(obj, lambda point: point.y < -0.75)
    assert bpy.ops.sinew.handle_add(kind="FIXED") == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")

    deformer = obj.sinew.active
    assert [handle.vertex_group for handle in deformer.handles] == ["Handle", "Fixed"]
    assert len(obj.modifiers) == 1
    control = deformer.handles[0].control
    assert control.select_get()
    assert not obj.select_get()
    assert np.allclose(control.matrix_world.translation, (0.0, 0.9, 0.0), atol=1e-6)
    assert np.allclose(np.array(control.matrix_world)[:3, 2], (0.0, 0.0, 1.0), atol=1e-6)  # the mean normal
    move_world(control, Matrix.Translation((0.0, 0.0, 0.5)))
    rig = Rig.called(obj.name)
    assert np.abs(rig.points()[top, 2] - 0.5).max() < 4e-6
    assert np.array_equal(rig.points()[base], rig.rest()[base])


def test_support_from_the_selection():
    obj = grid_object()
    top = edit(obj, lambda point: point.y > 0.75)
    bpy.ops.sinew.handle_add(kind="HANDLE")
    soft = select(obj, lambda point: point.y > -0.1)
    bpy.ops.sinew.handle_add(kind="SUPPORT")
    bpy.ops.object.mode_set(mode="OBJECT")
    move_world(obj.sinew.active.handles[0].control, Matrix.Translation((0.0, 0.0, 0.5)))
    rig = Rig.called(obj.name)
    moved = np.abs(rig.points() - rig.rest()).max(axis=1) > 1e-6
    assert set(np.flatnonzero(moved)) <= set(soft)
    assert set(top) <= set(np.flatnonzero(moved))


def test_nothing_selected_is_refused():
    obj = grid_object()
    edit(obj, lambda point: False)
    with pytest.raises(RuntimeError, match="Nothing is selected"):
        bpy.ops.sinew.handle_add(kind="HANDLE")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(obj.vertex_groups) == 0
    assert len(obj.sinew.deformers) == 0


def test_undo_in_edit_mode_takes_the_handle_back():
    obj = grid_object()
    edit(obj, lambda point: point.y > 0.75)
    push("selected")
    bpy.ops.sinew.handle_add(kind="HANDLE")
    push("handle")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Plate"]
    assert len(obj.sinew.deformers) == 0
    assert "Plate Handle" not in bpy.data.objects
    bpy.ops.ed.redo()
    obj = bpy.data.objects["Plate"]
    assert len(obj.sinew.deformers[0].handles) == 1
    assert obj.sinew.deformers[0].handles[0].control is not None
    if obj.mode == "EDIT":
        bpy.ops.object.mode_set(mode="OBJECT")


def test_control_of_a_selected_bone_or_object():
    obj = grid_object()
    armature = linked(bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
    with in_mode(armature):
        for name in ("other", "wanted"):
            bone = armature.data.edit_bones.new(name)
            bone.head, bone.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    armature.data.bones.active = armature.data.bones["wanted"]
    edit(obj, lambda point: point.y > 0.75)
    armature.select_set(True)
    bpy.ops.sinew.handle_add(kind="HANDLE", control="SELECTED")
    bpy.ops.object.mode_set(mode="OBJECT")
    handle = obj.sinew.active.handles[0]
    assert (handle.control, handle.bone) == (armature, "wanted")


def test_select_shows_free_parts(plate: Rig, room):
    with in_mode(plate.obj):
        bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0.0, 0.0, 2.0))
    plate.bind()
    lines = [line.text for line in room("core.status").notes(plate.deformer.uid)]
    assert "1 free part stays at rest" in lines
    make_active(plate.obj)
    bpy.ops.sinew.select_problems()
    mesh = bmesh.from_edit_mesh(plate.obj.data)
    chosen = [vertex.co.z for vertex in mesh.verts if vertex.select]
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(chosen) == 8
    assert min(chosen) > 1.5
