# SPDX-License-Identifier: GPL-3.0-or-later
"""What only nonlinear space methods do: controls without a region, animations, graphs as overlays."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from inside import inner
from mathutils import Matrix
from rigs import rig as scenes
from rigs.cages import ball as round_ball

METHODS = ("embedded_deformation", "rigid_cells")
TURN = Matrix.Rotation(np.radians(40.0), 4, "Z")


def ball(name: str, place: tuple, radius: float = 0.3) -> bpy.types.Object:
    """An ellipsoid whose own frame is turned and scaled, so that frames count."""
    obj = round_ball(name, 3, 2.0 * radius)
    obj.location, obj.rotation_euler, obj.scale = place, (0.3, 0.0, 0.1 + radius), (0.5, 0.4, 0.6)
    return obj


def in_world(obj: bpy.types.Object) -> np.ndarray:
    return scenes.apply_matrix(obj.matrix_world, scenes.evaluated_points(obj))


def follow(objects: list, empties: list, method: str) -> None:
    """Let objects follow the same empties, by the button."""
    scenes.make_active(objects[0], *objects, *empties)
    assert bpy.ops.sinew.point_add(source="SELECTED", method=method) == {"FINISHED"}
    for obj in objects:
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    scenes.make_active(objects[0])
    scenes.update()


@pytest.mark.parametrize("method", METHODS)
def test_a_handle_takes_hold_of_what_is_nearest_of_all_objects(method: str):
    """A handle far from an object does not move it, and an object that no handle is near stays."""
    places = {"Far": (2.0, 0.0, 2.0), "Near": (0.0, 0.0, 0.0), "Lost": (-4.0, 0.0, 0.0)}
    objects = [ball(name, place) for name, place in places.items()]
    empties = [scenes.new_empty(str(place), place) for place in [(0, 0, 0), (2, 0, 2), (1, 0, 1)]]
    follow(objects, empties, method)
    rest = [in_world(obj) for obj in objects]
    scenes.move_world(empties[0], Matrix.Translation((1.0, 0.0, 0.0)))
    far, near, lost = (in_world(obj) - at for obj, at in zip(objects, rest, strict=True))
    assert max(np.abs(far).max(), np.abs(lost).max()) < 1e-6
    assert np.abs(near - (1.0, 0.0, 0.0)).max() < 0.02


@pytest.mark.parametrize("method", METHODS)
def test_objects_that_share_handles_move_like_one(method: str):
    """The oracle is one object of all points: objects of their own are moved as it is."""
    places = [(0.4 * number, 0.0, 0.1 * number) for number in range(4)]
    objects = [ball(f"Ball {number}", place, 0.25 + 0.02 * number) for number, place in enumerate(places)]
    objects[0].rotation_euler = 0.0, 0.0, 0.0  # cells lie along the axes of the first object
    twins = [scenes.duplicated(obj) for obj in objects]
    whole = twins[0]
    scenes.make_active(whole, *twins)
    bpy.ops.object.join()
    bpy.ops.object.transform_apply()
    inside = (0.02, 0.03, 0.01)  # not on a side of a cell, where rounding would decide
    empties = [scenes.new_empty(str(place), np.add(place, inside)) for place in (places[0], places[-1])]
    follow([whole], empties, method)
    rest, motion = scenes.evaluated_points(whole), Matrix.Translation((0.0, 0.3, 0.3)) @ TURN
    scenes.move_world(empties[1], motion)
    expected = scenes.evaluated_points(whole)
    assert np.abs(expected - rest).max() > 0.3
    bpy.data.objects.remove(whole)
    scenes.move_world(empties[1], motion.inverted())
    follow(objects, empties, method)
    scenes.move_world(empties[1], motion)
    found = np.concatenate([in_world(obj) for obj in objects])
    np.testing.assert_allclose(found, expected, atol=1e-3)


def test_refine_gives_each_handle_a_cell():
    """The status names the handle that lacks a cell, and has a button for all that share the handles."""
    objects = [ball("One", (0.0, 0.0, 0.0)), ball("Other", (0.7, 0.0, 0.0))]
    empties = [scenes.new_empty(f"Pin {number}", (0.07 * number, 0.0, 0.0)) for number in range(3)]
    follow(objects, empties[:1], "rigid_cells")
    for obj in objects:
        obj.sinew.active.rigid_cells.cells = 20
    scenes.make_active(objects[0], *objects, *empties[1:])
    bpy.ops.sinew.point_add(source="SELECTED")
    deformer = objects[0].sinew.active
    assert deformer.status.startswith("Pin 1"), deformer.status
    assert inner.status.current(deformer.uid).remedy is inner.status.Remedy.REFINE
    scenes.push("Refused")
    assert bpy.ops.sinew.refine() == {"FINISHED"}
    assert deformer.status_level == "INFO", deformer.status
    assert deformer.rigid_cells.cells == objects[1].sinew.active.rigid_cells.cells > 20
    scenes.push("Refined")
    bpy.ops.ed.undo()
    for name in ("One", "Other"):
        assert bpy.data.objects[name].sinew.active.rigid_cells.cells == 20


def test_objects_that_share_handles_go_on_when_one_of_them_changes(tmp_path):
    """One of two is bound again with other vertices, copied, saved, and removed."""
    objects = [ball("One", (0.0, 0.0, 0.0)), ball("Other", (0.7, 0.0, 0.0))]
    empties = [scenes.new_empty("Left", (0.02, 0.03, 0.0)), scenes.new_empty("Right", (0.72, 0.01, 0.02))]
    follow(objects, empties, "embedded_deformation")
    delete = bmesh.ops.delete
    scenes.change_in_edit_mode(
        objects[1], lambda edit: delete(edit, geom=list(edit.verts)[:40], context="VERTS")
    )
    scenes.press(objects[1], "bind")
    scenes.move_world(empties[1], TURN)
    seen = [scenes.evaluated_points(obj) for obj in objects]
    scenes.reopen(tmp_path / "shared.blend")
    one, other = (bpy.data.objects[name] for name in ("One", "Other"))
    copy = scenes.duplicated(one)
    for obj, points in zip((one, other, copy), (*seen, seen[0]), strict=True):
        np.testing.assert_allclose(scenes.evaluated_points(obj), points, atol=1e-5)
    bpy.data.objects.remove(other)
    scenes.press(one, "bind")
    assert one.sinew.active.status_level == "INFO"
    companions = [row for obj in (one, copy) for row in obj.sinew.active.companions]
    assert all(row.rest is not None for row in companions if not row.is_target)
