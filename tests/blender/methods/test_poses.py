# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose means: closed forms for translations, rigid and affine motions, in any space."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from rigs.rig import (
    Rig,
    add_group,
    apply_matrix,
    close,
    move_world,
    new_empty,
    press,
    some_motion,
    update,
)


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
    press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Side")
    members = plate.deformer.handles[-1]
    after = plate.points()
    side = [v.index for v in plate.obj.data.vertices if any(g.group == 2 and g.weight > 0 for g in v.groups)]
    assert members.control.matrix_world.translation.z == pytest.approx(before[side, 2].mean(), abs=1e-4)
    # The region becomes rigid, so a little may change, not the pose.
    assert np.abs(after - before).max() < 0.05
