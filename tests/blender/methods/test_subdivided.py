# SPDX-License-Identifier: GPL-3.0-or-later
"""Subdivision Editing finds the levels that Blender's own Subdivision modifier made."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from expected import faces_of
from inside import native, notes_of
from rigs.rig import Rig, base_points, change_in_edit_mode, close, make_active, press

METHOD = "subdivision_editing"
TOLD = "1 part is no subdivision: bent as a plain plate"


def subdivided(levels: int) -> Rig:
    bpy.ops.mesh.primitive_cube_add(size=4.0)
    obj = bpy.context.object
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = levels
    modifier.use_limit_surface = False
    make_active(obj)
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    return Rig(obj, 0.9)


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_the_control_mesh_is_the_mesh_before_the_modifier(levels: int):
    obj = subdivided(levels).obj
    mesh = native().SurfaceMesh(base_points(obj), faces_of(obj.data))
    editing = native().SubdivisionEditing(mesh, coarsening="levels", levels=levels)
    editing.set_handles([[0]])
    assert editing.level_counts() == [levels]
    control = editing.control_mesh()
    assert control.vertex_count == 8
    assert np.abs(np.abs(control.points) - 2.0).max() < 1e-5  # Blender's points have single precision


def test_a_part_without_levels_is_told_and_moves_as_well():
    rig = subdivided(4)
    rig.bind(METHOD)
    assert TOLD not in notes_of(rig.deformer)
    rig.lift()
    for _ in range(2):
        goal = rig.rest()[rig.top] + (0.0, 0.0, 1.0)
        assert close(rig.points()[rig.top], goal)
        change_in_edit_mode(rig.obj, lambda edit: edit.faces.remove(edit.faces[100]))
        press(rig.obj, "bind")
        assert TOLD in notes_of(rig.deformer)
