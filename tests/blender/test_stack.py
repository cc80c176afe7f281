# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier stack: what comes before is followed, what comes after works on the result."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from registry import WITH_HANDLES
from rig import (
    FLOAT32,
    Rig,
    add_armature,
    add_group,
    apply_matrix,
    evaluated_points,
    make_active,
    move_world,
    update,
)


def copy_without_sinew(obj: bpy.types.Object) -> bpy.types.Object:
    """The same object with the other modifiers only: Blender's own answer."""
    copy = obj.copy()
    copy.data = obj.data.copy()
    copy.sinew.deformers.clear()
    for modifier in list(copy.modifiers):
        if modifier.type == "NODES":
            copy.modifiers.remove(modifier)
    bpy.context.scene.collection.objects.link(copy)
    return copy


def without_sinew(obj: bpy.types.Object) -> np.ndarray:
    copy = copy_without_sinew(obj)
    points = evaluated_points(copy)
    bpy.data.objects.remove(copy)
    return points


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_armature_above_is_followed_and_corrected(plate: Rig, method: str):
    armature = add_armature(plate.obj)
    plate.bind(method)
    armature.pose.bones["high"].rotation_mode = "XYZ"
    armature.pose.bones["high"].rotation_euler = (0.0, 0.0, 0.6)
    posed = without_sinew(plate.obj)
    assert np.abs(posed - plate.rest()).max() > 0.3
    # unmoved handles change nothing: exactly for displacements, within its tolerance for arap
    assert np.abs(plate.points() - posed).max() < (1e-2 if method == "arap" else FLOAT32)
    plate.lift(0.4)
    assert np.abs(plate.points()[plate.top] - posed[plate.top] - (0.0, 0.0, 0.4)).max() < FLOAT32


def test_handle_from_rest_on_the_bone_that_moved_the_mesh(plate: Rig):
    armature = add_armature(plate.obj)
    plate.bind(control_object="Rig", bone="high")
    bone = armature.pose.bones["high"]
    bone.location = (0.1, 0.2, 0.3)
    posed = without_sinew(plate.obj)
    twice = plate.points()[plate.top]
    assert np.abs(twice - posed[plate.top]).max() > 0.1
    plate.deformer.handles[0].from_rest = True
    assert np.abs(plate.points()[plate.top] - posed[plate.top]).max() < FLOAT32


def test_subdivision_below_deforms_the_subdivided_mesh(plate: Rig):
    obj = plate.obj
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    obj.modifiers["Subdivision"].render_levels = 1
    plate.bind()
    fine = without_sinew(obj)
    assert np.abs(plate.points() - fine).max() < FLOAT32
    plate.lift(0.5)
    points = plate.points()
    assert len(points) == len(fine) > 4 * len(plate.rest()) * 0.8
    assert np.abs(points[plate.top, 2] - 0.5).max() < FLOAT32


def test_a_later_modifier_that_reorders_vertices_gets_displacements(plate: Rig):
    armature = add_armature(plate.obj)
    plate.bind()
    obj = plate.obj
    decimate = obj.modifiers.new("Remesh", "REMESH")
    decimate.voxel_size = 0.1
    plate.lift(0.5)
    armature.pose.bones["high"].location = (0.0, 0.0, 0.2)
    update()
    assert plate.points()[:, 2].max() > 0.3
    obj.modifiers.remove(decimate)
    update()


def test_vertices_in_another_order_keep_their_own_displacement(plate: Rig, room):
    """Build can shuffle the vertices of a complete mesh: the set of points must stay what it was."""
    plate.bind().lift(0.5)
    ordered = plate.points()
    build = plate.obj.modifiers.new("Build", "BUILD")
    build.frame_start, build.frame_duration = -100.0, 1.0
    build.use_random_order, build.seed = True, 3
    plate.lift(0.0)
    shuffled = plate.points()
    assert not np.array_equal(shuffled, ordered)
    same_order = [points[np.lexsort(np.round(points, 4).T)] for points in (ordered, shuffled)]
    assert np.abs(same_order[0] - same_order[1]).max() < FLOAT32
    notes = [line.text for line in room("core.status").notes(plate.deformer.uid)]
    assert any("displacement" in text for text in notes)


def second_deformer(plate: Rig, method: str = "thin_shell"):
    obj = plate.obj
    add_group(obj, "Corner", lambda point: point[0] > 0.75 and point[1] > 0.75)
    add_group(obj, "Rest", lambda point: point[0] < 0.3 or point[1] < 0.3)
    make_active(obj)
    bpy.ops.sinew.deformer_add(method=method)
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Corner")
    make_active(obj)
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Rest")
    return obj.sinew.deformers[1]


def test_two_deformers_in_one_stack_add_up(plate: Rig):
    plate.bind()
    control = plate.control
    second = second_deformer(plate)
    move_world(control, Matrix.Translation((0.0, 0.0, 0.5)))
    first_only = plate.points()
    move_world(second.handles[0].control, Matrix.Translation((0.2, 0.0, 0.0)))
    corner = [i for i, p in enumerate(plate.rest()) if p[0] > 0.75 and p[1] > 0.75]
    points = plate.points()
    assert np.abs(points[corner] - first_only[corner] - (0.2, 0.0, 0.0)).max() < FLOAT32
    plate.obj.sinew.deformers[0].factor = 0.5
    assert np.abs(plate.points()[corner] - plate.rest()[corner] - (0.2, 0.0, 0.25)).max() < FLOAT32


def test_the_second_of_two_deformers_is_right_at_once_in_a_jump(plate: Rig):
    """No frame of delay: the answer after one jump is the answer after many evaluations."""
    plate.bind()
    control = plate.control
    second = second_deformer(plate, "arap")
    for frame, height in ((1, 0.0), (10, 0.8)):
        control.location.z = height
        control.keyframe_insert("location", frame=frame)
    second.handles[0].control.rotation_euler.x = 0.4
    bpy.context.scene.frame_set(1)
    bpy.context.scene.frame_set(10)
    once = plate.points()
    for _ in range(3):
        plate.obj.update_tag()
        update()
    assert np.array_equal(once, plate.points())


@pytest.mark.parametrize("posed", [True, False])
def test_the_second_follows_at_once_where_the_first_lets_go(plate: Rig, posed: bool):
    """What enters it in that evaluation is still what the first one showed before."""
    plate.bind()
    control = plate.control
    bpy.ops.sinew.deformer_add(method="arap")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Top")
    if posed:
        move_world(control, Matrix.Translation((0.0, 0.0, 0.5)))
    assert (np.abs(plate.points() - plate.rest()).max() > 0.4) == posed
    handles = plate.obj.sinew.deformers[0].handles
    for name in ("Nowhere", "Base"):  # refused, and back again
        handles[1].vertex_group = name
        if name == "Nowhere":
            assert np.abs(plate.points() - plate.rest()).max() < FLOAT32
    assert (np.abs(plate.points() - plate.rest()).max() > 0.4) == posed


def test_modifier_rename_and_reorder_keep_the_tie(plate: Rig):
    armature = add_armature(plate.obj)
    plate.bind()
    obj = plate.obj
    obj.modifiers[1].name = "Something else"
    obj.name = plate.name = "Renamed"
    obj.sinew.deformers[0].name = "Posed"
    plate.control.name = "Moved"
    plate.lift(0.5)
    assert np.abs(plate.points()[plate.top, 2] - 0.5).max() < FLOAT32
    make_active(obj)
    bpy.ops.object.modifier_move_to_index(modifier="Something else", index=0)
    assert obj.modifiers[0].type == "NODES"
    armature.pose.bones["high"].location = (0.0, 0.0, 0.2)
    points = plate.points()
    expected = apply_matrix(
        armature.pose.bones["high"].matrix @ armature.data.bones["high"].matrix_local.inverted(),
        plate.rest()[plate.top] + (0.0, 0.0, 0.5),
    )
    assert np.abs(points[plate.top] - expected).max() < 1e-5


def test_factor_and_mask(plate: Rig):
    plate.bind().lift(1.0)
    whole = plate.points()
    plate.deformer.factor = 0.25
    assert np.abs(plate.points() - (plate.rest() * 0.75 + whole * 0.25)).max() < FLOAT32
    plate.deformer.factor = 1.0
    plate.deformer.mask_group = "Top"
    masked = plate.points()
    assert np.abs(masked[plate.top] - whole[plate.top]).max() == 0.0
    others = np.setdiff1d(np.arange(len(whole)), plate.top)
    assert np.abs(masked[others] - plate.rest()[others]).max() == 0.0
    plate.deformer.mask_group = ""
    assert np.array_equal(plate.points(), whole)
    plate.deformer.mask_group = "Base"
    plate.points()
    plate.obj.vertex_groups.remove(plate.obj.vertex_groups["Base"])
    plate.obj.update_tag()
    assert np.array_equal(plate.points(), whole)  # as any modifier whose group is gone


def test_live_off_keeps_the_last_shape(plate: Rig):
    plate.bind().lift(0.5)
    before = plate.points()
    plate.deformer.live = False
    plate.lift(0.5)
    assert np.array_equal(plate.points(), before)
    plate.deformer.live = True
    assert plate.points()[plate.top, 2] == pytest.approx(1.0, abs=FLOAT32)
