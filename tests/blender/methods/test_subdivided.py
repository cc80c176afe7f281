# SPDX-License-Identifier: GPL-3.0-or-later
"""Subdivision Editing finds the levels that Blender's own Subdivision modifier made."""

from __future__ import annotations

import bpy
from inside import notes_of
from rigs.rig import Rig, change_in_edit_mode, close, press, subdivided

METHOD = "subdivision_editing"
TOLD = "1 part is no subdivision: bent as a plain plate"


def test_a_part_without_levels_is_told_and_moves_as_well():
    bpy.ops.mesh.primitive_cube_add(size=4.0)
    subdivided(bpy.context.object, 4).use_limit_surface = False
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    rig = Rig(bpy.context.object, 0.9).bind(METHOD)
    assert TOLD not in notes_of(rig.deformer)
    rig.lift()
    for _ in range(2):
        goal = rig.rest()[rig.top] + (0.0, 0.0, 1.0)
        assert close(rig.points()[rig.top], goal)
        change_in_edit_mode(rig.obj, lambda edit: edit.faces.remove(edit.faces[100]))
        press(rig.obj, "bind")
        assert TOLD in notes_of(rig.deformer)
