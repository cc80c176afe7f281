# SPDX-License-Identifier: GPL-3.0-or-later
"""Make Handle, Remove and Select in the modes a rigger works in, from a selection in Edit Mode on."""

import bmesh
import bpy
import numpy as np
import pytest
from editing import edit, select
from inside import notes_of
from rigs import rig as scenes

# --- from a selection


def test_from_selection_to_pose():
    obj = scenes.grid_object()
    top = edit(obj, lambda point: point.y > 0.75)
    assert bpy.ops.sinew.handle_add(kind="HANDLE") == {"FINISHED"}
    assert obj.mode == "EDIT"
    base = select(obj, lambda point: point.y < -0.75)
    assert bpy.ops.sinew.handle_add(kind="FIXED") == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    deformer = obj.sinew.active
    assert [handle.vertex_group for handle in deformer.handles] == ["Handle", "Still"]
    assert len(obj.modifiers) == 1
    control = deformer.handles[0].control
    assert (control.select_get(), obj.select_get()) == (True, False)
    assert np.allclose(control.matrix_world.translation, (0.0, 0.9, 0.0), atol=1e-6)
    assert np.allclose(np.array(control.matrix_world)[:3, 2], (0.0, 0.0, 1.0), atol=1e-6)  # the mean normal
    rig = scenes.Rig.called(obj.name)
    rig.lift(0.5)
    assert np.abs(rig.points()[top, 2] - 0.5).max() < 4e-6
    assert np.array_equal(rig.points()[base], rig.rest()[base])
    soft = edit(obj, lambda point: point.y > -0.1)
    bpy.ops.sinew.handle_add(kind="SUPPORT")
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = np.abs(rig.points() - rig.rest()).max(axis=1) > 1e-6
    assert set(np.flatnonzero(moved)) <= set(soft)
    assert scenes.close(rig.points()[top], rig.rest()[top] + (0.0, 0.0, 0.5))


def test_the_panel_says_where_nothing_will_bend(plate: scenes.Rig):
    def told() -> str:
        scenes.update()
        return " ".join(text for text in notes_of(plate.deformer) if text.startswith("Nothing will bend"))

    plate.bind("arap", fixed=False)
    assert "follows Top" in told()
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Base")
    assert not told()
    scenes.add_group(plate.obj, "Middle", lambda point: abs(point[1]) < 0.75)
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Middle")
    assert "all vertices" in told()
    plate.deformer.handles[0].enabled = False
    assert "no handle" in told()


def test_control_of_a_selected_bone_or_object():
    obj = scenes.grid_object()
    upright = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    armature = scenes.new_armature(other=upright, wanted=upright)
    armature.data.bones.active = armature.data.bones["wanted"]
    edit(obj, lambda point: point.y > 0.75)
    armature.select_set(True)
    bpy.ops.sinew.handle_add(kind="HANDLE", control="SELECTED")
    bpy.ops.object.mode_set(mode="OBJECT")
    handle = obj.sinew.active.handles[0]
    assert (handle.control, handle.bone) == (armature, "wanted")


def test_select_shows_free_parts(plate: scenes.Rig):
    scenes.on_all(plate.obj, bpy.ops.mesh.primitive_cube_add, size=0.2, location=(0.0, 0.0, 2.0))
    plate.bind()
    plate.deformer.loose_parts = "STAY"
    scenes.update()
    assert "1 loose part stays at rest" in notes_of(plate.deformer)
    scenes.press(plate.obj, "select_problems")
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = [vertex.co.z for vertex in plate.obj.data.vertices if vertex.select]
    assert len(chosen) == 8
    assert min(chosen) > 1.5


def test_removing_a_handle_frees_its_region(plate: scenes.Rig):
    plate.bind().lift(0.5)
    scenes.press(plate.obj, "handle_remove", index=1)
    assert len(plate.deformer.handles) == 1
    assert scenes.close(plate.points(), plate.rest() + (0.0, 0.0, 0.5))
    bpy.ops.sinew.handle_remove(index=0)
    assert np.array_equal(plate.points(), plate.rest())


# --- of groups and bones


def activate(obj: bpy.types.Object, group: str) -> None:
    obj.vertex_groups.active = obj.vertex_groups[group]


def is_selected(armature: bpy.types.Object, bone: str) -> bool:
    posed = armature.pose.bones[bone]
    return (posed if hasattr(posed, "select") else posed.bone).select


@pytest.mark.parametrize("mode", ["OBJECT", "WEIGHT_PAINT"])
def test_the_active_group_becomes_the_region(plate: scenes.Rig, mode: str):
    activate(plate.obj, "Top")
    with scenes.in_mode(plate.obj, mode):
        assert bpy.ops.sinew.handle_add(kind="HANDLE") == {"FINISHED"}
        assert plate.obj.mode == mode
        (handle,) = plate.deformer.handles
        assert (handle.vertex_group, handle.owns_group, handle.control.type) == ("Top", False, "EMPTY")
        scenes.refused("'Top' is a region of this deformer already", "handle_add", kind="FIXED")
    bpy.ops.sinew.handle_remove(index=0)
    assert "Top" in plate.obj.vertex_groups  # it was the user's


def test_name_and_weight(plate: scenes.Rig):
    scenes.press(plate.obj, "deformer_add", method="thin_shell")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Top", handle_name="Lip", weight=0.25)
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Base")
    lip = plate.deformer.handles[0]
    assert (lip.name, lip.weight) == ("Lip", 0.25)
    plate.lift(0.5)
    soft = plate.points()[plate.top, 2]
    assert 1e-3 < np.abs(soft - 0.5).max() < 0.1  # it gives way
    lip.weight = 1.0
    assert np.abs(plate.points()[plate.top, 2] - 0.5).max() < scenes.FLOAT32


def test_a_selected_bone_controls_its_own_group(plate: scenes.Rig):
    """The bone carries the mesh already, so the region does not move twice."""
    armature = scenes.add_armature(plate.obj)
    scenes.in_pose_mode(armature, "high", plate.obj)
    assert bpy.ops.sinew.handle_add(kind="HANDLE") == {"FINISHED"}
    assert bpy.context.mode == "POSE"
    (handle,) = plate.deformer.handles
    assert (handle.control, handle.bone, handle.vertex_group) == (armature, "high", "high")
    assert handle.from_rest
    assert is_selected(armature, "high")
    bpy.ops.object.mode_set(mode="OBJECT")
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Base")
    bone = armature.pose.bones["high"]
    bone.location = (0.1, 0.2, 0.3)
    scenes.update()
    high = plate.rest()[:, 1] > 0.0
    expected = scenes.apply_matrix(bone.matrix @ bone.bone.matrix_local.inverted(), plate.rest()[high])
    assert np.abs(expected - plate.rest()[high]).max() > 0.1
    assert np.abs(plate.points()[high] - expected).max() < 1e-5
    plate.deformer.handles[0].from_rest = False
    assert np.abs(plate.points()[high] - expected).max() > 0.1  # twice


def test_a_bone_without_a_group_takes_the_active_one_and_what_is_fixed_takes_no_bone(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    scenes.in_pose_mode(armature, "high")
    assert not bpy.ops.sinew.handle_add.poll()  # the mesh is not selected
    plate.obj.vertex_groups.remove(plate.obj.vertex_groups["high"])
    for bone, kind, group in (("high", "HANDLE", "Top"), ("low", "FIXED", "Base")):
        activate(plate.obj, group)
        scenes.in_pose_mode(armature, bone, plate.obj)
        bpy.ops.sinew.handle_add(kind=kind)
        bpy.ops.object.mode_set(mode="OBJECT")
    one, other = plate.deformer.handles
    assert (one.vertex_group, one.bone, one.from_rest) == ("Top", "high", False)
    assert other.control is None


def test_weight_painting_with_an_armature_in_pose_mode(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    scenes.in_pose_mode(armature, "high")
    bpy.context.view_layer.objects.active = plate.obj
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Top")
    (handle,) = plate.deformer.handles
    assert (handle.control, handle.bone) == (armature, "high")
    assert plate.obj.mode == "WEIGHT_PAINT"


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_select_and_extend(plate: scenes.Rig, mode: str):
    plate.bind(fixed=False)
    scenes.press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Base")
    scenes.make_active(plate.obj)
    first, second = ({handle.control} for handle in plate.deformer.handles)
    if mode == "EDIT":
        first, second = set(plate.top), set(plate.base)
    bpy.ops.object.mode_set(mode=mode)
    for index, extend, wanted in ((0, False, first), (1, True, first | second), (1, False, second)):
        bpy.ops.sinew.select_handle(index=index, extend=extend)
        found = set(bpy.context.selected_objects)
        if mode == "EDIT":
            found = {vertex.index for vertex in bmesh.from_edit_mesh(plate.obj.data).verts if vertex.select}
        assert found == wanted
    assert plate.obj.vertex_groups.active.name == "Base"  # ready for Weight Paint


def test_select_of_a_bone_leads_to_pose_mode(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    plate.bind(control_object="Rig", bone="high")
    scenes.make_active(plate.obj)
    for bone in armature.pose.bones:
        scenes.select_bone(armature, bone.name)
    bpy.ops.sinew.select_handle(index=0)
    assert bpy.context.mode == "POSE"
    assert bpy.context.object == armature
    assert armature.data.bones.active.name == "high"
    assert is_selected(armature, "high")
    assert not is_selected(armature, "low")


def test_the_same_group_by_name_may_be_used_twice(plate: scenes.Rig):
    """A script that names the group means it: one soft, one hard region of the same vertices."""
    plate.bind()
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Top", weight=0.5)
    assert [handle.name for handle in plate.deformer.handles] == ["Top", "Base", "Top.001"]
    assert plate.deformer.status_level == "INFO"


@pytest.mark.parametrize("target", ["SHAPE_KEYS", "PC2"])
def test_a_baked_deformer_is_unbaked_before_it_is_removed(plate: scenes.Rig, tmp_path, target: str):
    """And stays where it is in the stack while it is baked."""
    plate.bind().lift(0.5)
    scenes.press(plate.obj, "deformer_add", method="thin_shell")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    plate.obj.sinew.active_deformer = 0
    bpy.ops.sinew.bake(target=target, frame_start=1, frame_end=2)
    assert plate.obj.sinew.deformers[0].bake.is_baked
    scenes.refused("Unbake it first", "deformer_move", direction="DOWN", index=0)
    bpy.ops.sinew.deformer_remove(index=0)
    assert [modifier.type for modifier in plate.obj.modifiers] == ["NODES"]
    assert len(plate.obj.sinew.deformers) == 1
    assert np.abs(plate.points() - plate.rest()).max() < scenes.FLOAT32


def test_a_control_outside_the_view_layer_moves_its_region_all_the_same(plate: scenes.Rig):
    away, control = bpy.data.collections.new("Away"), bpy.data.objects.new("Far", None)
    bpy.context.scene.collection.children.link(away)
    away.objects.link(control)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True
    scenes.press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Top", control_object="Far")
    control.location.z += 0.5
    assert np.abs(plate.points()[plate.top, 2] - 0.5).max() < 1e-5
