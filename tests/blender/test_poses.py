# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose means: closed forms for translations, rigid and affine motions, in any space."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from registry import WITH_HANDLES
from rig import (
    Rig,
    add_group,
    apply_matrix,
    close,
    grid_object,
    make_active,
    move_world,
    new_armature,
    new_empty,
    some_affine,
    some_motion,
    update,
)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_handle_follows_its_control_and_fixed_stays(plate: Rig, method: str):
    plate.bind(method).lift(0.5)
    points, rest = plate.points(), plate.rest()
    assert close(points[plate.top], rest[plate.top] + (0.0, 0.0, 0.5))
    assert close(points[plate.base], rest[plate.base])
    middle = points[np.abs(rest[:, 1]) < 0.1, 2]
    assert (middle > 0.05).all()
    assert (middle < 0.45).all()


def test_one_rigid_motion_of_all_handles_moves_the_mesh_rigidly(plate: Rig):
    plate.bind("arap", fixed=False)
    move_world(plate.control, some_motion())
    assert close(plate.points(), apply_matrix(some_motion(), plate.rest()), 2e-5)


def test_one_affine_motion_of_all_handles_is_reproduced_by_thin_shell():
    """Linear precision: on a plane, affine data at the boundary has the affine map as its answer."""
    plate = Rig(grid_object())
    add_group(plate.obj, "Rim", lambda point: max(abs(point[0]), abs(point[1])) > 0.75)
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Rim")
    move_world(plate.control, some_affine())
    assert close(plate.points(), apply_matrix(plate.control.matrix_world, plate.rest()), 3e-5)


@pytest.mark.parametrize("parented", [False, True])
def test_any_space_of_the_target_gives_the_world_motion_of_the_control(plate: Rig, parented: bool):
    """Rotated, unequally scaled, moved, parented: the region moves in the world as its control does."""
    obj = plate.obj
    obj.matrix_world = some_motion() @ Matrix.Diagonal((2.0, 0.5, 1.5, 1.0))
    if parented:
        parent = new_empty("Parent")
        parent.matrix_world = Matrix.Rotation(0.7, 4, "X") @ Matrix.Diagonal((1.0, 3.0, 0.7, 1.0))
        obj.parent = parent
    update()
    plate.bind()
    world = obj.matrix_world.copy()
    motion = Matrix.Translation((0.1, 0.2, 0.3)) @ Matrix.Rotation(0.4, 4, "Y")
    move_world(plate.control, motion)
    points, rest = plate.points(), plate.rest()
    expected = apply_matrix(motion @ world, rest[plate.top])
    assert close(apply_matrix(world, points[plate.top]), expected, 2e-5)
    assert close(points[plate.base], rest[plate.base])


def test_everything_rides_along_when_the_target_moves(plate: Rig):
    plate.bind().lift()
    before = plate.points()
    plate.obj.matrix_world = some_motion() @ Matrix.Diagonal((1.0, 2.0, 0.5, 1.0))
    assert close(plate.points(), before, 1e-5)


def test_parented_and_scaled_control(plate: Rig):
    parent, control = new_empty("Parent"), new_empty("Control")
    parent.scale = (1.0, 2.0, 3.0)
    control.parent, control.rotation_euler, control.scale = parent, (0.3, 0.2, 0.1), (0.5, 1.0, 2.0)
    plate.bind(control_object="Control")
    assert close(plate.points(), plate.rest(), 1e-6)
    at_rest = control.matrix_world.copy()
    parent.rotation_euler = (0.0, 0.0, math.radians(30.0))
    control.location = (0.1, 0.0, 0.2)
    update()
    moved = control.matrix_world @ at_rest.inverted()
    assert close(plate.points()[plate.top], apply_matrix(moved, plate.rest()[plate.top]), 2e-5)


def test_bone_moves_a_handle(plate: Rig):
    armature = new_armature(lift=((0.0, 0.9, 0.0), (0.0, 0.9, 1.0)))
    plate.bind(control_object="Rig", bone="lift")
    armature.hide_viewport = True  # hidden controls are evaluated all the same
    armature.pose.bones["lift"].location = (0.0, 0.4, 0.0)  # along the bone, which is the world's z
    points = plate.points()
    assert close(points[plate.top], plate.rest()[plate.top] + (0.0, 0.0, 0.4))


def test_several_handles_each_follow_their_own_control(plate: Rig):
    plate.bind(fixed=False)
    obj = plate.obj
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Base")
    first, second = (handle.control for handle in obj.sinew.active.handles)
    move_world(first, Matrix.Translation((0.0, 0.0, 0.3)))
    move_world(second, Matrix.Rotation(0.5, 4, "X"))
    points, rest = plate.points(), plate.rest()
    assert close(points[plate.top], rest[plate.top] + (0.0, 0.0, 0.3))
    assert close(points[plate.base], apply_matrix(Matrix.Rotation(0.5, 4, "X"), rest[plate.base]))


def test_adding_a_handle_to_a_posed_mesh_moves_nothing(plate: Rig):
    plate.bind().lift(0.5)
    add_group(plate.obj, "Side", lambda point: abs(point[1]) < 0.1 and point[0] > 0.7)
    before = plate.points()
    make_active(plate.obj)
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Side")
    members = plate.deformer.handles[-1]
    after = plate.points()
    side = [v.index for v in plate.obj.data.vertices if any(g.group == 2 and g.weight > 0 for g in v.groups)]
    assert members.control.matrix_world.translation.z == pytest.approx(before[side, 2].mean(), abs=1e-4)
    assert (
        np.abs(after - before).max() < 0.05
    )  # the region becomes rigid, so a little may change, not the pose


def test_support_holds_all_else(plate: Rig):
    plate.bind(fixed=False)
    inside = add_group(plate.obj, "Soft", lambda point: point[1] > 0.0)
    bpy.ops.sinew.handle_add(kind="SUPPORT", vertex_group="Soft")
    plate.lift(0.5)
    outside = np.setdiff1d(np.arange(len(plate.rest())), inside)
    points, rest = plate.points(), plate.rest()
    assert close(points[outside], rest[outside])
    assert close(points[plate.top], rest[plate.top] + (0.0, 0.0, 0.5))
    assert points[inside, 2].max() > 0.1


def test_soft_handle_gives_way(plate: Rig):
    """A bent strip pulls at its end: a hard handle holds it, a soft one lets it go some way."""
    plate.bind()
    move_world(plate.control, Matrix.Translation((0.0, 0.0, 0.5)) @ Matrix.Rotation(0.5, 4, "X"))
    goal = plate.points()[plate.top]
    plate.deformer.handles[0].weight = 0.2
    softer = plate.points()[plate.top]
    assert 1e-4 < np.abs(softer - goal).max() < 0.5
