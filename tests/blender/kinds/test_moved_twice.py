# SPDX-License-Identifier: GPL-3.0-or-later
"""What an armature moves twice: by a modifier, and by a control that it moves as well."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from rigs.point_objects import add, add_bones, attach, cage_around
from rigs.rig import evaluated_points, grid_object, make_active, new_armature, push, update
from rigs.sheet import draw_panel


def offers_armature_off() -> bool:
    """Whether the panel of the active object has the button."""
    return "sinew.armature_off" in draw_panel().operator_names()


def let_bones_move(obj: bpy.types.Object, armature: bpy.types.Object, how: str) -> None:
    """The bone of an armature moves all points."""
    if how == "parent":
        obj.parent, obj.parent_type = armature, "ARMATURE"
    elif how == "modifier":
        obj.modifiers.new("Skin", "ARMATURE").object = armature
    elif how == "hook":
        hook = obj.modifiers.new("Hook", "HOOK")
        hook.object, hook.subtarget, hook.vertex_group = armature, "Bone", "Bone"
    else:
        add_bones(obj, armature, method="mls")


@pytest.mark.parametrize("how", ["modifier", "parent", "hook", "handle"])
@pytest.mark.parametrize("control", ["points", "cage"])
def test_what_an_armature_moves_twice_is_said_and_mended(control: str, how: str):
    """A garment with an Armature modifier whose body, or cage, the same armature poses: by a button it moves
    once, and lies on the body."""
    armature = new_armature(Bone=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    armature_name = armature.name
    body = cage_around(grid_object("Inside")) if control == "cage" else grid_object("Body")
    garment = grid_object("Garment")
    for obj in (body, garment):
        obj.vertex_groups.new(name="Bone").add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    let_bones_move(garment, armature, "modifier")
    let_bones_move(body, armature, how)
    update()
    if control == "cage":
        attach(garment, "mean_value", body)
    else:
        add(garment, body, method="mls")
    rest = evaluated_points(garment)
    make_active(garment)
    assert offers_armature_off()
    push("Twice")
    assert bpy.ops.sinew.armature_off() == {"FINISHED"}
    assert not offers_armature_off()
    push("Once")
    bpy.ops.ed.undo()
    assert offers_armature_off()
    bpy.ops.ed.redo()
    garment, armature = bpy.data.objects["Garment"], bpy.data.objects[armature_name]
    bone = armature.pose.bones[0]
    bone.location = 0.0, 0.3, 0.0
    moved = evaluated_points(garment) - rest
    np.testing.assert_allclose(moved, np.broadcast_to((0.0, 0.0, 0.3), moved.shape), atol=1e-4)
    assert bpy.ops.sinew.armature_off() == {"CANCELLED"}
