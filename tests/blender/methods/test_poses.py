# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose means: closed forms for translations, rigid and affine motions, in any space."""

import numpy as np
import pytest
from mathutils import Matrix
from rigs.rig import Rig, add_group, apply_matrix, close, move_world, new_empty, press, some_motion, update


@pytest.mark.parametrize("parented", [False, True])
def test_any_space_of_the_target_gives_the_world_motion_of_the_control(plate: Rig, parented: bool):
    """Rotated, unequally scaled, moved, parented: as the control in the world, and later with the target."""
    obj = plate.obj
    obj.matrix_world = some_motion() @ Matrix.Diagonal((2.0, 0.5, 1.5, 1.0))
    if parented:
        obj.parent = new_empty("Parent")
        obj.parent.matrix_world = Matrix.Rotation(0.7, 4, "X") @ Matrix.Diagonal((1.0, 3.0, 0.7, 1.0))
    update()
    plate.bind()
    world, motion = (
        obj.matrix_world.copy(),
        Matrix.Translation((0.1, 0.2, 0.3)) @ Matrix.Rotation(0.4, 4, "Y"),
    )
    move_world(plate.control, motion)
    points, rest = plate.points(), plate.rest()
    expected = apply_matrix(motion @ world, rest[plate.top])
    assert close(apply_matrix(world, points[plate.top]), expected, 2e-5)
    assert close(points[plate.base], rest[plate.base])
    obj.matrix_world = some_motion() @ Matrix.Diagonal((1.0, 2.0, 0.5, 1.0))
    assert close(plate.points(), points, 1e-5)


def test_parented_and_scaled_control(plate: Rig):
    parent, control = new_empty("Parent"), new_empty("Control")
    parent.scale = (1.0, 2.0, 3.0)
    control.parent, control.rotation_euler, control.scale = parent, (0.3, 0.2, 0.1), (0.5, 1.0, 2.0)
    plate.bind(control_object="Control")
    assert close(plate.points(), plate.rest(), 1e-6)
    at_rest = control.matrix_world.copy()
    parent.rotation_euler.z, control.location = 0.5, (0.1, 0.0, 0.2)
    update()
    moved = control.matrix_world @ at_rest.inverted()
    assert close(plate.points()[plate.top], apply_matrix(moved, plate.rest()[plate.top]), 2e-5)


def test_several_handles_each_follow_their_own_control_and_one_that_is_added_moves_nothing(plate: Rig):
    plate.bind(fixed=False)
    press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Base")
    motions = Matrix.Translation((0.0, 0.0, 0.3)), Matrix.Rotation(0.5, 4, "X")
    for handle, motion in zip(plate.deformer.handles, motions, strict=True):
        move_world(handle.control, motion)
    before, rest = plate.points(), plate.rest()
    for region, motion in zip((plate.top, plate.base), motions, strict=True):
        assert close(before[region], apply_matrix(motion, rest[region]))
    side = add_group(plate.obj, "Side", lambda point: abs(point[1]) < 0.1 and point[0] > 0.7)
    press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Side")
    place = plate.deformer.handles[-1].control.matrix_world.translation
    assert np.allclose(place, before[side].mean(axis=0), atol=1e-4)
    # The region becomes rigid, so a little may change, not the pose.
    assert np.abs(plate.points() - before).max() < 0.05
