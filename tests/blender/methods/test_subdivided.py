# SPDX-License-Identifier: GPL-3.0-or-later
"""Subdivision Editing finds the levels that Blender's own Subdivision modifier made."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import inner
from rigs.rig import Rig, change_in_edit_mode, close, make_active, new_file, press

METHOD = "subdivision_editing"
TOLD = "1 part is no subdivision: bent as a plain plate"


def subdivided(levels: int) -> Rig:
    new_file()
    bpy.ops.mesh.primitive_cube_add(size=4.0)
    obj = bpy.context.object
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = levels
    modifier.use_limit_surface = False
    make_active(obj)
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    return Rig(obj, 0.9)


def notes(rig: Rig) -> list[str]:
    return [line.text for line in inner.status.notes(rig.deformer.uid)]


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_the_control_mesh_is_the_mesh_before_the_modifier(levels: int):
    native = inner.backend.availability().module
    mesh = subdivided(levels).obj.data
    points = np.array([vertex.co for vertex in mesh.vertices], float)
    faces = np.array([face.vertices for face in mesh.polygons])
    editing = native.SubdivisionEditing(native.SurfaceMesh(points, faces), coarsening="levels", levels=levels)
    editing.set_handles([[0]])
    assert editing.level_counts() == [levels]
    control = editing.control_mesh()
    assert control.vertex_count == 8
    assert np.abs(np.abs(control.points) - 2.0).max() < 1e-5  # Blender's points have single precision


def test_a_part_without_levels_is_told_and_moves_as_well():
    rig = subdivided(4)
    rig.bind(METHOD)
    assert TOLD not in notes(rig)
    rest = rig.rest()
    rig.lift()
    assert close(rig.points()[rig.top], rest[rig.top] + (0.0, 0.0, 1.0))

    def cut(edit):
        edit.faces.remove(edit.faces[100])

    change_in_edit_mode(rig.obj, cut)
    press(rig.obj, "bind")
    assert TOLD in notes(rig)
    rest = rig.rest()
    assert close(rig.points()[rig.top], rest[rig.top] + (0.0, 0.0, 1.0))
