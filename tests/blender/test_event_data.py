# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies, deletions, new names, new orders, orphans, instances, shared meshes."""

import bmesh
import bpy
import numpy as np
import pytest
from expected import Expected
from inside import settle
from mathutils import Matrix
from probe import render_points
from rig import (
    MATRIX,
    Rig,
    add_group,
    base_points,
    close,
    evaluated_points,
    grid_object,
    make_active,
    move_world,
    update,
)
from rigs import HandleRig


def lift(control: bpy.types.Object, height: float) -> None:
    move_world(control, Matrix.Translation((0.0, 0.0, height)))


# --- copies


def select_rig(rig: HandleRig) -> None:
    """The mesh, which is active, and its control."""
    make_active(rig.obj)
    rig.control.select_set(True)


@pytest.mark.parametrize("linked", [False, True])
def test_duplicating_mesh_and_control_makes_a_rig_of_its_own(posed, linked: bool):
    rig, expected = posed
    select_rig(rig)
    bpy.ops.object.duplicate(linked=linked)
    copy = bpy.context.object
    settle()
    control = rig.control_of(copy)
    assert control not in (None, rig.control)
    for mover, heights in ((control, (0.5, 0.75)), (rig.control, (0.25, 0.75))):
        lift(mover, heights[1] - 0.5 if mover == control else heights[0] - 0.5)
    assert rig.shows(expected.lifted(0.75), copy)
    assert rig.shows(expected.lifted(0.25))
    bpy.context.scene.frame_set(4)
    assert rig.shows(expected.lifted(0.75), copy)
    assert rig.shows(expected.lifted(0.25))


def test_a_copy_of_a_copy_and_ten_more(posed):
    rig, expected = posed
    rigs = [rig.obj]
    for _ in range(10):
        make_active(rigs[-1])
        rig.control_of(rigs[-1]).select_set(True)
        bpy.ops.object.duplicate()
        rigs.append(bpy.context.object)
    settle()
    for number, obj in enumerate(rigs):
        lift(rig.control_of(obj), 0.01 * number)
    for number, obj in enumerate(rigs):
        assert rig.shows(expected.lifted(0.5 + 0.01 * number), obj)
    proxies = {obj.sinew.deformers[0].proxy for obj in rigs}
    assert len(proxies) == len(rigs)


def test_a_copy_by_a_script_and_the_original_deleted_before_the_copy_has_shapes(
    posed,
):
    rig, expected = posed
    copy, control = rig.obj.copy(), rig.control
    bpy.context.scene.collection.objects.link(copy)
    bpy.data.objects.remove(rig.obj)  # the parent of the control, which jumps
    settle()
    assert rig.shows(expected.now(copy, control), copy)
    lift(control, 0.25)
    assert rig.shows(expected.now(copy, control), copy)


def test_copy_and_paste(posed):
    """Through a file of Blender's own."""
    rig, expected = posed
    select_rig(rig)
    bpy.ops.view3d.copybuffer()
    bpy.ops.view3d.pastebuffer(autoselect=True)
    settle()
    copy = next(obj for obj in bpy.data.objects if obj.sinew.deformers and obj != rig.obj)
    lift(rig.control_of(copy), 0.25)
    assert rig.shows(expected.lifted(0.75), copy)
    assert rig.shows(expected.lifted(0.5))


def test_deleting_a_copy_leaves_the_original_alone(posed):
    rig, expected = posed
    make_active(rig.obj)
    bpy.ops.object.duplicate()
    settle()
    bpy.ops.object.delete()
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    rig.lift(0.25)
    assert rig.shows(expected.lifted(0.75))


# --- deletions


def test_deleting_the_target_leaves_only_orphans_that_a_purge_takes(posed):
    rig, _expected = posed
    select_rig(rig)
    bpy.ops.object.delete()
    update()
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    for kind in ("objects", "meshes", "curves", "node_groups"):
        assert not getattr(bpy.data, kind), kind


@pytest.mark.parametrize("by_user", [False, True])
def test_deleting_the_control_leaves_the_last_shape(posed, by_user: bool):
    rig, expected = posed
    if by_user:
        make_active(rig.control)
        bpy.ops.object.delete()
        make_active(rig.obj)
    else:
        bpy.data.objects.remove(rig.control)
    assert rig.shows(expected.lifted(0.5))
    assert rig.control_is_missing(rig.obj)
    bpy.context.scene.frame_set(7)
    assert rig.shows(expected.lifted(0.5))


def test_deleting_one_of_two_targets_of_one_control(posed):
    rig, expected = posed
    make_active(rig.obj)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    settle()
    bpy.data.objects.remove(rig.obj)
    update()
    control = rig.control_of(copy)
    assert rig.shows(expected.now(copy, control), copy, MATRIX)
    lift(control, 0.25)
    assert rig.shows(expected.now(copy, control), copy, MATRIX)


@pytest.mark.parametrize("which", ["proxy", "proxy_render"])
@pytest.mark.parametrize("what", ["object", "mesh"])
def test_deleting_a_hidden_shape_shows_rest_at_worst_and_bind_restores_it(posed, which: str, what: str):
    """By hand in the outliner's Blender File view. Removing the mesh of an object removes the object."""
    rig, expected = posed
    shape = getattr(rig.deformer, which)
    if what == "object":
        bpy.data.objects.remove(shape)
    else:
        bpy.data.meshes.remove(shape.data)
    rig.obj.update_tag()
    shown = rig.points()
    assert close(shown, expected.lifted(0.5), rig.tolerance) or close(shown, rig.rest(), rig.tolerance)
    if close(shown, rig.rest(), rig.tolerance):
        assert rig.deformer.status_level == "ERROR"
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    assert len(rig.obj.modifiers) == 1
    assert rig.shows(expected.lifted(0.5))
    rig.lift(0.25)
    assert rig.shows(expected.lifted(0.75))
    assert close(render_points(rig.obj), expected.lifted(0.75), rig.tolerance)


def test_deleting_the_rest_mesh_unbinds_and_bind_restores_it(posed):
    rig, expected = posed
    bpy.data.meshes.remove(rig.deformer.rest)
    rig.obj.update_tag()
    assert rig.shows(rig.rest())
    assert rig.deformer.status_level in ("ERROR", "WARNING")
    assert "Bind" in rig.deformer.status or "bind" in rig.deformer.status
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    assert rig.shows(expected.lifted(0.5))


def test_deleting_the_node_group_shows_rest_and_bind_restores_it(posed):
    rig, expected = posed
    bpy.data.node_groups.remove(rig.obj.modifiers[0].node_group)
    rig.obj.update_tag()
    assert rig.shows(rig.rest())
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    assert len([modifier for modifier in rig.obj.modifiers if modifier.node_group]) == 1
    assert rig.shows(expected.lifted(0.5))


def test_deleting_a_vertex_group_keeps_the_bound_shape_and_says_so_at_bind(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    plate.obj.vertex_groups.remove(plate.obj.vertex_groups["Base"])
    assert close(plate.points(), expected.lifted(0.5))
    make_active(plate.obj)
    with pytest.raises(RuntimeError, match="'Base' is not on the mesh"):
        bpy.ops.sinew.bind()
    assert close(plate.points(), plate.rest())
    add_group(plate.obj, "Base", lambda point: point[1] < -0.75)
    bpy.ops.sinew.bind()
    assert close(plate.points(), expected.lifted(0.5))


def test_clearing_the_animation_of_the_target_loses_no_hidden_control(posed):
    """The driver that keeps controls evaluated lives there; it comes back."""
    rig, expected = posed
    rig.obj.animation_data_clear()
    settle()
    control = rig.control
    for frame, height in ((1, 0.0), (11, 1.0)):
        control.location.z = height
        control.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)
    settle()
    control.hide_viewport = True
    bpy.context.scene.frame_set(11)
    settle()
    bpy.context.scene.frame_set(1)
    bpy.context.scene.frame_set(11)
    assert rig.shows(expected.lifted(1.0))


# --- new names, new orders


def test_everything_renamed(posed):
    rig, expected = posed
    deformer = rig.deformer
    for number, datablock in enumerate(
        (
            rig.obj,
            rig.obj.data,
            rig.control,
            deformer.proxy,
            deformer.proxy.data,
            deformer.proxy_render,
            deformer.rest,
            rig.obj.modifiers[0],
            rig.obj.modifiers[0].node_group,
            deformer,
            *deformer.handles,
            bpy.context.scene,
            bpy.context.view_layer,
        )
    ):
        datablock.name = f"Anything {number}"
    rig.name = "Anything 0"
    rig.lift(0.25)
    assert rig.shows(expected.lifted(0.75))
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    assert len(rig.obj.modifiers) == 1
    assert len([group for group in bpy.data.node_groups if group.users]) == 1
    rig.lift(0.25)
    assert rig.shows(expected.lifted(1.0))


def test_names_exchanged(posed):
    """Two rigs take each other's names: names tell nothing."""
    rig, expected = posed
    other = type(rig).new("Other")
    also_expected = other.start()
    other.lift(0.25)
    first, second, name = rig.obj, other.obj, rig.name
    for pair in ((first, second), (first.sinew.deformers[0].proxy, second.sinew.deformers[0].proxy)):
        one, two = (datablock.name for datablock in pair)
        pair[0].name = "Between"
        pair[1].name = one
        pair[0].name = two
    rig.lift_of(first, 0.25)
    assert (first.name, second.name) == ("Other", name)
    assert rig.shows(expected.lifted(0.75), first)
    assert rig.shows(also_expected.lifted(0.25), second)


def test_vertex_groups_renamed(posed_plate: tuple[Rig, Expected]):
    """The regions, the mask and a later bind follow."""
    plate, expected = posed_plate
    plate.deformer.mask_group = "Top"
    masked = plate.rest()
    masked[plate.top] = expected.lifted(0.5)[plate.top]
    assert close(plate.points(), masked)
    plate.obj.vertex_groups["Top"].name = "Head"
    plate.obj.vertex_groups["Base"].name = "Feet"
    plate.obj.update_tag()
    assert close(plate.points(), masked)
    plate.deformer.mask_group = ""
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    make_active(plate.obj)
    bpy.ops.sinew.bind()
    assert [handle.vertex_group for handle in plate.deformer.handles] == ["Head", "Feet"]
    assert close(plate.points(), expected.lifted(0.75))


def test_vertex_groups_in_another_order(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    add_group(plate.obj, "A", lambda point: point[0] > 0.0)
    make_active(plate.obj)
    plate.obj.vertex_groups.active_index = 2
    bpy.ops.object.vertex_group_move(direction="UP")
    bpy.ops.object.vertex_group_sort(sort_type="NAME")
    assert [group.name for group in plate.obj.vertex_groups] == ["A", "Base", "Top"]
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    bpy.ops.sinew.bind()
    assert close(plate.points(), expected.lifted(0.75))
    plate.deformer.mask_group = "Top"
    shown = plate.rest()
    shown[plate.top] = expected.lifted(0.75)[plate.top]
    assert close(plate.points(), shown)


def bone_rig(plate: Rig) -> tuple[bpy.types.Object, Expected]:
    """The handle on the bone ``arm``, which stands in the middle of the region."""
    data = bpy.data.armatures.new("Rig")
    armature = bpy.data.objects.new("Rig", data)
    bpy.context.scene.collection.objects.link(armature)
    make_active(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, y in (("arm", 0.9), ("other", -0.9)):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = (0.0, y, 0.0), (0.0, y, 0.5)
    bpy.ops.object.mode_set(mode="OBJECT")
    plate.bind(control_object="Rig", bone="arm")
    return armature, Expected(plate.obj, plate.obj)


def test_a_bone_renamed_is_still_the_control(plate: Rig):
    """Blender renames the bone in constraints and drivers, too."""
    armature, expected = bone_rig(plate)
    armature.pose.bones["arm"].location = (0.0, 0.5, 0.0)  # the bone points along z
    assert close(plate.points(), expected.lifted(0.5))
    armature.data.bones["arm"].name = "elbow"
    armature.pose.bones["elbow"].location = (0.0, 0.75, 0.0)
    assert close(plate.points(), expected.lifted(0.75))
    assert not plate.deformer.handles[0].control_missing


def test_a_bone_picked_again_goes_on_from_where_the_region_was(plate: Rig):
    armature, expected = bone_rig(plate)
    armature.pose.bones["arm"].location = (0.0, 0.5, 0.0)
    assert close(plate.points(), expected.lifted(0.5))
    plate.deformer.handles[0].bone = "other"
    assert close(plate.points(), expected.lifted(0.5))
    armature.pose.bones["other"].location = (0.0, 0.25, 0.0)
    assert close(plate.points(), expected.lifted(0.75))


def test_deleting_the_bone_leaves_the_region_where_it_was(plate: Rig):
    armature, expected = bone_rig(plate)
    armature.pose.bones["arm"].location = (0.0, 0.5, 0.0)
    assert close(plate.points(), expected.lifted(0.5))
    make_active(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    armature.data.edit_bones.remove(armature.data.edit_bones["arm"])
    bpy.ops.object.mode_set(mode="OBJECT")
    assert close(plate.points(), expected.lifted(0.5), MATRIX)
    assert plate.deformer.handles[0].control_missing


def test_handles_and_deformers_in_another_order(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    plate.deformer.handles.move(0, 1)
    assert [handle.name for handle in plate.deformer.handles] == ["Base", "Top"]
    assert close(plate.points(), expected.lifted(0.5))
    lift(plate.deformer.handles[1].control, 0.25)
    assert close(plate.points(), expected.lifted(0.75))
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    plate.obj.sinew.deformers.move(0, 1)
    lift(plate.obj.sinew.deformers[1].handles[1].control, 0.25)
    assert close(plate.points(), expected.lifted(1.0))


# --- joined and separated


@pytest.mark.parametrize("automatic", [False, True])
def test_another_mesh_joined_to_the_target(posed_plate: tuple[Rig, Expected], automatic: bool):
    plate, expected = posed_plate
    plate.deformer.auto_rebind = automatic
    other = grid_object("Other", cells=2)
    other.location.z = 3.0
    update()
    make_active(plate.obj)
    other.select_set(True)
    bpy.ops.object.join()
    settle()
    assert len(plate.rest()) == 121 + 9
    if not automatic:
        assert close(plate.points(), plate.rest())
        assert plate.deformer.status == "Topology changed - Rebind"
        bpy.ops.sinew.bind()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5))


def test_the_target_joined_to_another_mesh(posed_plate: tuple[Rig, Expected], room):
    """It is gone, as anything joined; the other one lives on without a deformer."""
    plate, _expected = posed_plate
    other = grid_object("Other", cells=2)
    plate.obj.select_set(True)
    bpy.ops.object.join()
    settle()
    assert plate.name not in bpy.data.objects
    assert len(evaluated_points(other)) == 121 + 9
    assert room("session").owners() == []


def test_a_part_separated_from_the_target(posed_plate: tuple[Rig, Expected]):
    """Blender gives the part the modifiers and our settings as well: two rigs on two meshes."""
    plate, expected = posed_plate
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(plate.obj.data)
    for face in edit.faces:
        face.select_set(face.calc_center_median().x > 0.5)
    bmesh.update_edit_mesh(plate.obj.data)
    bpy.ops.mesh.separate(type="SELECTED")
    bpy.ops.object.mode_set(mode="OBJECT")
    settle()
    part = next(obj for obj in bpy.data.objects if obj.sinew.deformers and obj != plate.obj)
    control = plate.control
    for obj in (plate.obj, part):
        assert close(evaluated_points(obj), base_points(obj))
        assert obj.sinew.deformers[0].status == "Topology changed - Rebind"
        make_active(obj)
        bpy.ops.sinew.bind()
    assert plate.deformer.proxy != part.sinew.deformers[0].proxy
    lift(control, 0.25)
    for obj in (plate.obj, part):
        expected.rebind(obj)
        assert close(evaluated_points(obj), expected.now(obj, control))
        assert obj.sinew.deformers[0].handles[0].control == control


# --- orphans


def test_a_purge_takes_nothing_of_a_living_rig(posed, tmp_path):
    rig, expected = posed
    for _ in range(2):
        bpy.ops.outliner.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
        rig.lift(0.1)
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
    assert rig.shows(expected.lifted(0.7))
    assert close(render_points(rig.obj), expected.lifted(0.7), rig.tolerance)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    assert rig.shows(expected.lifted(0.7))


def test_a_purge_after_a_rebind_of_another_size_leaves_no_old_shape(posed):
    rig, _expected = posed
    rig.change_topology()
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    assert len([mesh for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")]) == rig.hidden_meshes


# --- instances and shared meshes


def instanced(name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """World matrix and points (object space) of each instance of the object."""
    update()
    found = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.is_instance and instance.object.name == name:
            mesh = instance.object.to_mesh()
            points = np.array([vertex.co[:] for vertex in mesh.vertices])
            instance.object.to_mesh_clear()
            found.append((np.array(instance.matrix_world), points))
    return found


def test_instances_of_a_collection_show_the_pose(posed):
    rig, expected = posed
    collection = bpy.data.collections.new("Asset")
    collection.objects.link(rig.obj)
    for x in (3.0, 6.0):
        instance = bpy.data.objects.new("Instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", collection
        instance.location.x = x
        bpy.context.scene.collection.objects.link(instance)
    rig.lift(0.25)
    found = instanced(rig.name)
    assert sorted(matrix[0, 3] for matrix, _ in found) == [3.0, 6.0]
    for _matrix, points in found:
        assert close(points, expected.lifted(0.75), rig.tolerance)


def test_instances_on_vertices_show_the_pose(posed):
    rig, expected = posed
    parent = grid_object("Field", cells=1)
    parent.instance_type = "VERTS"
    rig.obj.parent = parent
    update()
    rig.lift(0.25)
    found = instanced(rig.name)
    assert len(found) == 4
    for _matrix, points in found:
        assert close(points, expected.lifted(0.75), rig.tolerance)


def test_a_rig_that_only_an_instance_shows(posed_plate: tuple[Rig, Expected]):
    """Target and control are in no scene but the one that the instance gives them."""
    plate, expected = posed_plate
    collection = bpy.data.collections.new("Asset")
    control = plate.control
    for obj in (plate.obj, control):
        collection.objects.link(obj)
        bpy.context.scene.collection.objects.unlink(obj)
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    bpy.context.scene.collection.objects.link(instance)
    update()
    control.matrix_basis = Matrix.Translation((0.0, 0.0, 0.75))
    ((_matrix, points),) = instanced(plate.name)
    assert close(points, expected.lifted(0.75))


def test_objects_that_share_a_mesh(posed_plate: tuple[Rig, Expected]):
    """One is deformed, one is not; and an edit of the mesh reaches both."""
    plate, expected = posed_plate
    twin = bpy.data.objects.new("Twin", plate.obj.data)
    bpy.context.scene.collection.objects.link(twin)
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    assert close(evaluated_points(twin), base_points(twin))
    vertex = 60
    assert vertex not in plate.top
    twin.data.vertices[vertex].co.z += 0.1
    twin.data.update()
    shown = expected.lifted(0.75)
    shown[vertex, 2] += 0.1
    assert close(plate.points(), shown)
    assert evaluated_points(twin)[vertex, 2] == pytest.approx(0.1)


def test_make_single_user(posed):
    """Two rigs on one mesh; then each has its own, and the topology of one changes."""
    rig, expected = posed
    select_rig(rig)
    bpy.ops.object.duplicate(linked=True)
    copy = bpy.context.object
    settle()
    assert copy.data == rig.obj.data
    lift(rig.control_of(copy), 0.25)
    make_active(copy)
    bpy.ops.object.make_single_user(type="SELECTED_OBJECTS", object=True, obdata=True)
    assert copy.data != rig.obj.data
    assert rig.shows(expected.lifted(0.75), copy)
    type(rig).called(copy.name).change_topology()
    assert rig.shows(rig.unmoved(copy), copy)
    assert rig.shows(expected.lifted(0.5))


def test_another_mesh_put_into_the_target(posed_plate: tuple[Rig, Expected]):
    """Of the same size: its own shape is followed. Of another size: rest, until it is bound again."""
    plate, expected = posed_plate
    same = plate.obj.data.copy()
    same.vertices[60].co.z += 0.1
    old, plate.obj.data = plate.obj.data, same
    shown = expected.lifted(0.5)
    shown[60, 2] += 0.1
    assert close(plate.points(), shown)
    other = grid_object("Other", cells=5)
    plate.obj.data = other.data
    assert close(plate.points(), plate.rest())
    assert plate.deformer.status == "Topology changed - Rebind"
    plate.obj.data = old
    assert close(plate.points(), expected.lifted(0.5))
    assert plate.deformer.status_level == "INFO"
