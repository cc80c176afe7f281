# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies, deletions, new names, new orders, orphans, shared meshes."""

import bpy
import events
import numpy as np
import pytest
from expected import Expected
from inside import catch_up, evaluated_by, inner, settle
from mathutils import Matrix
from rigs import rig as scenes
from rigs.kinds import HandleRig
from test_event_scene import moves_though_hidden

EVENTS = events.Table()
EDITS = events.Table()  # each once with Automatic Rebind and once without


# --- copies


@EVENTS.on(events.REGIONS)
def duplicated_alone_and_given_a_control(rig: HandleRig) -> None:
    """In a window the copy is known as one until the pause. It takes its shape along to the other control."""
    scenes.make_active(rig.obj)
    with evaluated_by(None):
        bpy.ops.object.duplicate()
        copy = bpy.context.object
        assert inner.owners.has_copies()
        assert catch_up() is False
        assert not inner.owners.has_copies()
    assert copy.sinew.deformers[0].proxy != rig.deformer.proxy
    rig.set_control(copy, rig.another_control(copy))
    assert rig.shows(rig.at(0.5), copy)
    rig.lift_of(copy, 0.25)
    assert np.abs(scenes.evaluated_points(copy)[rig.top, 2] - 0.75).max() < scenes.MATRIX


@EVENTS.on(events.ALL, then=events.is_over)
def copied_by_a_script_and_deleted_before_the_copy_has_shapes(rig: HandleRig) -> None:
    copy = rig.obj.copy()
    bpy.context.scene.collection.objects.link(copy)
    bpy.data.objects.remove(rig.obj)  # the parent of the control, which jumps
    settle()
    for _ in range(2):
        assert rig.shows(rig.now(copy), copy)
        rig.lift_of(copy, 0.25)


@EVENTS.on(events.ALL)
def a_copy_deleted(rig: HandleRig) -> None:
    events.duplicate(rig, control=False)
    bpy.ops.object.delete()
    bpy.ops.outliner.orphans_purge(do_recursive=True)


# --- deletions


@EVENTS.on(events.ALL, then=events.is_over)
def the_target_deleted(rig: HandleRig) -> None:
    """It leaves only orphans, which a purge takes."""
    name = rig.name
    scenes.make_active(rig.obj, rig.control)
    bpy.ops.object.delete()
    scenes.update()
    assert name not in bpy.data.objects
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    for kind in ("objects", "meshes", "curves", "node_groups"):
        assert not getattr(bpy.data, kind), kind


@EVENTS.on(events.ALL, then=events.keeps_its_shape)
def the_control_deleted(rig: HandleRig) -> None:
    copy = events.duplicate(rig)
    bpy.data.objects.remove(rig.control_of(copy))
    scenes.make_active(rig.control)
    bpy.ops.object.delete()
    scenes.make_active(rig.obj)
    for frame in (1, 4):
        bpy.context.scene.frame_set(frame)
        for obj in (rig.obj, copy):
            assert rig.shows(rig.at(0.5), obj)
            assert rig.control_is_missing(obj)


@EVENTS.on(events.REGIONS, then=events.is_over)
def the_control_deleted_saved_and_replaced(rig: HandleRig) -> None:
    """The region stays where it was, and the new control moves it from there."""
    scenes.move_world(rig.control, Matrix.Translation((0.1, 0.0, 0.0)) @ Matrix.Rotation(0.3, 4, "X"))
    before = rig.points()
    bpy.data.objects.remove(rig.control)
    assert rig.shows(before)
    scenes.reopen(rig.folder / "rig.blend")
    assert rig.shows(before, tolerance=scenes.MATRIX)
    assert rig.control_is_missing(rig.obj)
    control = rig.another_control(rig.obj)
    control.location = (3.0, 2.0, 1.0)
    scenes.update()
    rig.set_control(rig.obj, control)
    assert rig.shows(before, tolerance=scenes.MATRIX)
    assert not rig.control_is_missing(rig.obj)
    control.location.z += 0.5
    assert scenes.close(rig.points()[rig.top], before[rig.top] + (0.0, 0.0, 0.5), scenes.MATRIX)


@pytest.mark.parametrize("factor", [1.0, 0.0])
def test_the_pose_of_a_soft_region_without_control_is_saved(posed_plate: HandleRig, factor: float):
    """The saved shape does not tell it: soft vertices give way, and Factor 0 shows rest."""
    plate = posed_plate
    plate.deformer.handles[0].weight = 0.5
    before = plate.points()
    bpy.data.objects.remove(plate.control)
    assert scenes.close(plate.points(), before, 1e-6)
    plate.deformer.factor = factor
    scenes.update()
    scenes.reopen(plate.folder / "lost.blend")
    plate.deformer.factor = 1.0
    assert scenes.close(plate.points(), before, 1e-6)


@EVENTS.on(events.ALL, then=events.is_over)
def one_of_two_targets_of_a_control_deleted(rig: HandleRig) -> None:
    copy = events.duplicate(rig, control=False)
    bpy.data.objects.remove(rig.obj)
    for _ in range(2):
        assert rig.shows(rig.now(copy), copy, scenes.MATRIX)
        rig.lift_of(copy, 0.25)


@EVENTS.on(events.ALL)
def its_hidden_shapes_deleted(rig: HandleRig) -> None:
    """By hand in the outliner's Blender File view: rest and an error at worst, and Bind restores them."""
    for which in ("proxy", "proxy_render"):
        for its_mesh in (False, True):  # which removes the object, too
            shape = getattr(rig.deformer, which)
            bpy.data.meshes.remove(shape.data) if its_mesh else bpy.data.objects.remove(shape)
            rig.obj.update_tag()
            assert rig.is_right() or (rig.is_at_rest() and rig.deformer.status_level == "ERROR")
            rig.press("bind")
            assert len(rig.obj.modifiers) == 1
            events.lives_on(rig)


@EVENTS.on(events.ALL, then=events.is_over)
def its_deformer_removed(rig: HandleRig) -> None:
    """Nothing of ours is left behind, and what is the user's stays."""
    groups, objects = list(rig.obj.vertex_groups.keys()), set(bpy.data.objects.keys())
    rig.press("deformer_remove")
    assert not [mesh.name for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")]
    gone = {name for name in objects if name.startswith(".Sinew")}
    if rig.obj.vertex_groups and rig.goes_on:
        gone.add("Plate Top")  # an empty that was made for the handle
    assert set(bpy.data.objects.keys()) == objects - gone
    assert list(rig.obj.vertex_groups.keys()) == groups  # these were the user's
    assert len(rig.obj.modifiers) == 0
    assert rig.obj.animation_data is None or len(rig.obj.animation_data.drivers) == 0
    assert rig.is_at_rest()


@EVENTS.on(events.ALL, then=events.is_over)
def unbound_with_its_control_active(rig: HandleRig) -> None:
    """Operators find the target from there."""
    scenes.press(rig.control, "unbind")
    assert rig.is_at_rest()
    assert not rig.deformer.is_bound


@EVENTS.on(events.ALL, then=events.bind_restores)
def its_rest_mesh_deleted(rig: HandleRig) -> None:
    bpy.data.meshes.remove(rig.deformer.rest)
    rig.obj.update_tag()


@EVENTS.on(events.ALL)
def its_node_group_deleted(rig: HandleRig) -> None:
    bpy.data.node_groups.remove(rig.obj.modifiers[0].node_group)
    rig.obj.update_tag()
    assert rig.is_at_rest()
    rig.press("bind")
    assert len([modifier for modifier in rig.obj.modifiers if modifier.node_group]) == 1


@EVENTS.on(events.ALL)
def its_animation_cleared(rig: HandleRig) -> None:
    """The driver that keeps hidden controls evaluated lives there; it comes back."""
    rig.obj.animation_data_clear()
    settle()
    moves_though_hidden(rig, rig.control, rig.control, "hide_viewport")
    rig.height = 0.25


@EVENTS.on(events.REGIONS)
def its_control_exchanged(rig: HandleRig) -> None:
    """The new one is kept evaluated, too."""
    rig.lift_to(0.0)
    control = rig.another_control(rig.obj)
    rig.set_control(rig.obj, control)
    settle()
    moves_though_hidden(rig, control, control, "hide_viewport")
    rig.height = 0.25


# --- new names, new orders


@EVENTS.on(events.ALL)
def everything_renamed(rig: HandleRig) -> None:
    deformer, group = rig.deformer, rig.obj.modifiers[0].node_group
    renamed = [rig.obj, rig.obj.data, rig.control, deformer.proxy, deformer.proxy.data, deformer.proxy_render]
    renamed += [deformer.rest, rig.obj.modifiers[0], group, deformer, *deformer.handles]
    for number, datablock in enumerate((*renamed, bpy.context.scene, bpy.context.view_layer)):
        datablock.name = f"Anything {number}"
    rig.name = "Anything 0"
    rig.lift(0.25)
    assert rig.is_right()
    rig.press("bind")
    assert len(rig.obj.modifiers) == 1
    assert len([group for group in bpy.data.node_groups if group.users]) == 1


@EVENTS.on(events.ALL)
def names_exchanged_with_another_rig(rig: HandleRig) -> None:
    other = type(rig).new("Other").start()
    other.lift(0.25)
    first, second, name = rig.obj, other.obj, rig.name
    for one, two in ((first, second), (first.sinew.deformers[0].proxy, second.sinew.deformers[0].proxy)):
        names = one.name, two.name
        one.name = "Between"
        two.name, one.name = names
    assert (first.name, second.name) == ("Other", name)
    rig.name, other.name = "Other", name
    rig.lift(0.25)
    assert rig.is_right()
    events.lives_on(other)


def masks(rig: HandleRig, group: str) -> bool:
    """Where the mask is the group at the top, whatever it is called."""
    expected = rig.rest()
    expected[rig.top] = rig.at(rig.height)[rig.top]
    rig.deformer.mask_group = group
    seen = rig.shows(expected)
    rig.deformer.mask_group = ""
    return seen


@EVENTS.on(events.MESHES)
def vertex_groups_renamed(rig: HandleRig) -> None:
    """The mask follows, the regions of handles and painted parameters, and a later bind."""
    rig.deformer.mask_group = "Top"
    if rig.deformer.handles:
        rig.deformer.parameters.bending_group = "Base"
    before = rig.points()
    rig.obj.vertex_groups["Top"].name = "Head"
    rig.obj.vertex_groups["Base"].name = "Feet"
    for _ in range(2):
        rig.obj.update_tag()
        assert rig.shows(before)
        rig.press("bind")
    assert rig.deformer.mask_group == "Head"
    if rig.deformer.handles:
        assert [handle.vertex_group for handle in rig.deformer.handles] == ["Head", "Feet"]
        assert rig.deformer.parameters.bending_group == "Feet"
        rig.deformer.parameters.bending_group = ""
    assert masks(rig, "Head")


@EVENTS.on(events.MESHES)
def vertex_groups_in_another_order(rig: HandleRig) -> None:
    scenes.add_group(rig.obj, "A", lambda point: point[0] > 0.0)
    scenes.make_active(rig.obj)
    rig.obj.vertex_groups.active_index = 2
    bpy.ops.object.vertex_group_move(direction="UP")
    bpy.ops.object.vertex_group_sort(sort_type="NAME")
    assert rig.obj.vertex_groups.keys() == ["A", "Base", "Top"]
    for _ in range(2):
        rig.lift(0.25)
        assert rig.is_right()
        rig.press("bind")
    assert masks(rig, "Top")


def test_a_bone_renamed_exchanged_and_deleted(plate: scenes.Rig):
    """Blender renames it in constraints and drivers, too; another goes on from there."""
    armature = scenes.new_armature(
        **{name: ((0.0, y, 0.0), (0.0, y, 0.5)) for name, y in (("arm", 0.9), ("other", -0.9))}
    )
    plate.bind(control_object="Rig", bone="arm")
    expected = Expected(plate.obj, plate.obj)
    bones, handle = armature.pose.bones, plate.deformer.handles[0]
    bones["arm"].location.y = 0.5  # the bones point along z
    assert scenes.close(plate.points(), expected.lifted(0.5))
    armature.data.bones["arm"].name = "elbow"
    bones["elbow"].location.y = 0.75
    assert scenes.close(plate.points(), expected.lifted(0.75))
    assert not handle.control_missing
    handle.bone = "other"
    settle()
    assert scenes.close(plate.points(), expected.lifted(0.75))
    bones["other"].location.y = 0.25
    assert scenes.close(plate.points(), expected.lifted(1.0))
    with scenes.in_mode(armature):
        armature.data.edit_bones.remove(armature.data.edit_bones["other"])
    assert scenes.close(plate.points(), expected.lifted(1.0), scenes.MATRIX)
    assert plate.deformer.handles[0].control_missing


@EVENTS.on(events.REGIONS, then=events.is_over)
def handles_and_deformers_in_another_order(rig: HandleRig) -> None:
    """By the button, and by scripts."""
    deformers, control = rig.obj.sinew.deformers, rig.control
    rig.press("handle_move", direction="DOWN", index=0)
    assert deformers[0].active_handle == 0
    assert deformers[0].handles.keys() == ["Base", "Top"]
    assert rig.is_right()
    for height in (0.75, 1.0, 1.25):
        scenes.move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
        assert rig.shows(rig.at(height))
        if height == 0.75:
            deformers[0].handles.move(0, 1)
        elif height == 1.0:
            rig.press("deformer_add", method="thin_shell")
            deformers.move(0, 1)


# --- joined and separated


@EDITS.on(events.MESHES)
def another_mesh_joined_to_the_target(rig: HandleRig) -> None:
    count, other = len(rig.rest()), scenes.grid_object("Other", cells=2)
    other.location, other.scale = (0.0, 0.0, 0.1), (0.2, 0.2, 0.2)
    scenes.make_active(rig.obj, other)
    bpy.ops.object.join()
    assert len(rig.rest()) == count + 9


@EVENTS.on(events.MESHES, then=events.is_over)
def the_target_joined_to_another_mesh(rig: HandleRig) -> None:
    """It is gone, as anything joined; the other one lives on without a deformer."""
    count, other = len(rig.rest()), scenes.grid_object("Other", cells=2)
    scenes.make_active(other, rig.obj)
    bpy.ops.object.join()
    settle()
    assert rig.name not in bpy.data.objects
    assert len(scenes.evaluated_points(other)) == count + 9
    assert inner.owners.owners() == []


@EVENTS.on(events.MESHES, then=events.is_over)
def a_part_separated_from_the_target(rig: HandleRig) -> None:
    """Blender gives the part the modifiers and our settings as well: two rigs on two meshes."""

    def separate(edit) -> None:
        for face in edit.faces:
            face.select_set(face.calc_center_median().x > 0.4)
        bpy.ops.mesh.separate(type="SELECTED")

    scenes.change_in_edit_mode(rig.obj, separate)
    settle()
    control = rig.control
    part = next(obj for obj in bpy.data.objects if obj.sinew.deformers and obj != rig.obj)
    for obj in (rig.obj, part):
        assert rig.shows(rig.unmoved(obj), obj)
        assert obj.sinew.deformers[0].status == events.REBIND
        scenes.press(obj, "bind")
    assert rig.deformer.proxy != part.sinew.deformers[0].proxy
    rig.lift(0.25)
    for obj in (rig.obj, part):
        rig.poses.rebind(obj)
        assert rig.shows(rig.now(obj), obj)
        assert rig.control_of(obj) == control


# --- orphans


@EVENTS.on(events.ALL)
def orphans_purged(rig: HandleRig) -> None:
    """Nothing of a living rig goes, nor does a file lack it."""
    for _ in range(2):
        bpy.ops.outliner.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
        rig.lift(0.1)
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        assert rig.is_right()
    scenes.reopen(rig.folder / "rig.blend")


@EVENTS.on(events.ALL)
def orphans_purged_after_a_rebind_of_another_size(rig: HandleRig) -> None:
    rig.change_topology()
    settle()
    events.says_rebind(rig)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    assert len([mesh for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")]) == rig.hidden_meshes


# --- shared meshes


def raise_one_vertex(mesh: bpy.types.Mesh) -> None:
    mesh.vertices[len(mesh.vertices) // 2].co.z += 0.1
    mesh.update()


@EVENTS.on(events.MESHES, then=events.is_over)
def its_mesh_shared_with_an_object_without_deformer(rig: HandleRig) -> None:
    """An edit of the mesh reaches both, on top of the pose."""
    twin = scenes.linked(bpy.data.objects.new("Twin", rig.obj.data))
    rig.lift(0.25)
    assert rig.is_right()
    assert scenes.close(scenes.evaluated_points(twin), rig.rest())
    before = rig.rest()
    raise_one_vertex(twin.data)
    assert np.abs(rig.rest() - before).max() > 0.09
    assert rig.shows(rig.at(0.75) + rig.rest() - before)
    assert scenes.close(scenes.evaluated_points(twin), rig.rest())


@EVENTS.on(events.ALL)
def made_single_user(rig: HandleRig) -> None:
    """Two rigs on one mesh; then each has its own, and the topology of one changes."""
    copy = events.duplicate(rig, linked=True)
    rig.lift_of(copy, 0.25)
    scenes.make_active(copy)
    bpy.ops.object.make_single_user(type="SELECTED_OBJECTS", object=True, obdata=True)
    assert copy.data != rig.obj.data
    assert rig.shows(rig.at(0.75), copy)
    type(rig).called(copy.name).change_topology()
    assert rig.shows(rig.unmoved(copy), copy)


@EVENTS.on(events.MESHES)
def another_mesh_put_in(rig: HandleRig) -> None:
    """Of the same size: its own shape is followed. Of another size: rest, until it is bound or gone again."""
    before, old, same = rig.rest(), rig.obj.data, rig.obj.data.copy()
    raise_one_vertex(same)
    rig.obj.data = same
    assert rig.shows(rig.at(0.5) + rig.rest() - before)
    rig.obj.data = scenes.grid_object("Other", cells=5).data
    assert rig.is_at_rest()
    assert rig.deformer.status == events.REBIND
    rig.obj.data = old
    assert rig.is_right()


# --- each of them


@events.every(EVENTS)
def test_a_rig_lives_through(posed: HandleRig, event: events.Event):
    event.run(posed)


@pytest.mark.parametrize("automatic", [False, True])
@events.every(EDITS)
def test_other_vertices_are_noticed(posed: HandleRig, event: events.Event, automatic: bool):
    event.edit(posed, automatic)
