# SPDX-License-Identifier: GPL-3.0-or-later
"""What the nonlinear space methods do beyond what every method does: lone controls, curves, animations."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from rig import Rig, add_armature, base_points, evaluated_points, make_active, move_world, new_empty, update

METHODS = ("embedded_deformation", "rigid_cells")
TURN = Matrix.Rotation(np.radians(40.0), 4, "Z")


def carried(obj: bpy.types.Object, method: str, places: list[tuple]) -> list[bpy.types.Object]:
    """A deformer of handles that have no region, each with an empty at its place."""
    make_active(obj)
    assert bpy.ops.sinew.deformer_add(method=method) == {"FINISHED"}
    deformer = obj.sinew.active
    empties = []
    for place in places:
        empties.append(new_empty(f"Control {len(empties)}", place))
        handle = deformer.handles.add()
        handle.name, handle.kind, handle.control = empties[-1].name, "HANDLE", empties[-1]
    update()
    make_active(obj)
    assert bpy.ops.sinew.bind() == {"FINISHED"}, deformer.status
    return empties


@pytest.mark.parametrize("method", METHODS)
def test_controls_without_a_region_turn_a_mesh(method: str, plate: Rig):
    empties = carried(plate.obj, method, [(-0.8, 0.0, 0.0), (0.8, 0.0, 0.0)])
    rest = base_points(plate.obj)
    assert np.abs(evaluated_points(plate.obj) - rest).max() < 1e-6
    for empty in empties:
        move_world(empty, TURN)
    update()
    turned = rest @ np.array(TURN)[:3, :3].T
    np.testing.assert_allclose(evaluated_points(plate.obj), turned, atol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_a_curve_follows_controls_rigidly(method: str, scene):
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("POLY")
    spline.points.add(39)
    for index, point in enumerate(spline.points):
        point.co = np.cos(0.2 * index), np.sin(0.2 * index), 0.05 * index, 1.0
    obj = bpy.data.objects.new("Curve", curve)
    bpy.context.scene.collection.objects.link(obj)
    empties = carried(obj, method, [(1.0, 0.0, 0.0), (0.0, 0.0, 2.0)])
    rest = evaluated_points(obj)
    for empty in empties:
        move_world(empty, TURN)
    update()
    np.testing.assert_allclose(evaluated_points(obj), rest @ np.array(TURN)[:3, :3].T, atol=1e-5)


def test_embedded_deformation_edits_what_an_armature_has_posed(plate: Rig):
    """A handle at rest changes nothing; all handles turned rigidly turn the posed shape."""
    rig = add_armature(plate.obj)
    plate.bind("embedded_deformation")
    bone = rig.pose.bones[0]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = 0.6, 0.0, 0.3
    update()
    posed = evaluated_points(plate.obj)
    assert np.abs(posed - base_points(plate.obj)).max() > 0.05, "the armature moves the plate"
    plate.deformer.factor = 0.0
    update()
    np.testing.assert_allclose(posed, evaluated_points(plate.obj), atol=1e-6)
