# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles without a region: empties, bones and points of objects that move the space around them."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import notes_of
from mathutils import Matrix, Vector
from registry import ON_HANDLE_POINTS
from rigs import rig as scenes
from rigs.cages import ball
from rigs.point_objects import add, bezier

PLACES = ((-1, -1, 0), (1, -1, 0), (-1, 1, 0), (1, 1, 0.6), (0, 0, -0.5))


def empties() -> list[bpy.types.Object]:
    return [scenes.new_empty(f"Point {number}", place) for number, place in enumerate(PLACES)]


def test_one_empty_turns_the_space_around_it():
    plate, controls = scenes.grid_object(), empties()
    add(plate, *controls, source="SELECTED", method="rbf")
    before = scenes.base_points(plate)
    away = np.linalg.norm(before - PLACES[0], axis=1)
    near, *around = np.argsort(away)[:3]
    motion = (
        Matrix.Translation(PLACES[0]) @ Matrix.Rotation(0.8, 4, "Z") @ Matrix.Translation(-Vector(PLACES[0]))
    )
    controls[0].rotation_euler.z = 0.8
    shown, turned = scenes.evaluated_points(plate), scenes.apply_matrix(motion, before)
    assert np.abs(shown[near] - before[near]).max() < 1e-4
    # In first order of the distance, which is 0.2 here.
    assert np.abs((shown - turned)[around]).max() < 0.5 * np.abs((turned - before)[around]).max()


def test_the_cursor_places_an_empty_of_its_own_and_undo_takes_it_back():
    plate = scenes.grid_object()
    bpy.context.scene.cursor.location = (0.5, 0.2, 0.1)
    (handle,) = add(plate, source="CURSOR", method="rbf").handles
    control = handle.control
    assert np.allclose(control.matrix_world.translation, (0.5, 0.2, 0.1))
    assert handle.owns_control
    control.location.z += 0.5
    assert np.abs(scenes.evaluated_points(plate) - scenes.base_points(plate) - (0, 0, 0.5)).max() < 1e-5
    name = control.name
    scenes.press(plate, "handle_remove")
    assert name not in bpy.data.objects


def test_empties_follow_the_points_of_an_object():
    plate, points = scenes.grid_object(), scenes.new_object("Points", PLACES, edges=[(0, 1), (2, 3)])
    assert len(add(plate, points, source="OBJECT", method="rbf").handles) == len(PLACES)
    points.data.vertices[3].co.z += 1.0
    points.data.update()
    shown = scenes.evaluated_points(plate)
    corner = np.abs(scenes.base_points(plate) - (1, 1, 0)).sum(axis=1).argmin()
    assert shown[corner, 2] > 0.3
    assert np.abs(shown - scenes.base_points(plate)).min(axis=0).max() < 0.2


def test_handles_that_cannot_be_met_are_named():
    """Points at one place that go apart; one that has neither a region nor a control."""
    plate, controls = scenes.grid_object(), empties()
    controls[1].location = PLACES[0]
    deformer = add(plate, *controls, source="SELECTED", method="rbf")
    for apart, level in ((0.5, "ERROR"), (0.0, "INFO")):
        controls[1].location.z = apart
        scenes.update()
        assert deformer.status_level == level, deformer.status
        assert ("Point 0" in deformer.status and "Point 1" in deformer.status) == (apart > 0.0)
    deformer.handles.add().name = "New"
    plate.update_tag()
    scenes.update()
    assert "New has no vertex group and no control" in deformer.status


def test_two_points_carry_no_turn_and_the_panel_says_so():
    """A region of two vertices: a line."""
    plate = scenes.grid_object()
    group = plate.vertex_groups.new(name="Line")
    group.add([0, 1], 1.0, "REPLACE")
    deformer = scenes.add_regions(plate, "rbf", {"Line": "HANDLE"})
    assert any("on a line" in note for note in notes_of(deformer))


@pytest.mark.parametrize("make", [scenes.grid_object, bezier])
def test_a_point_that_has_lost_its_empty_gets_another_one_where_it_was(make):
    obj, controls = make(), empties()
    handles = add(obj, *controls, source="SELECTED", method="rbf").handles
    controls[0].location.z += 0.5
    before = scenes.evaluated_points(obj)
    bpy.data.objects.remove(controls[0])
    assert np.abs(scenes.evaluated_points(obj) - before).max() < 1e-5
    scenes.press(obj, "control_new")
    assert np.abs(scenes.evaluated_points(obj) - before).max() < 1e-5
    assert not handles[0].control_missing
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    handles[0].control.location.z -= 0.5
    assert np.abs(scenes.evaluated_points(obj) - before).max() > 0.02


def test_points_on_a_mesh_that_bones_have_posed_go_on_from_its_pose():
    plate = scenes.grid_object()
    bone = scenes.add_armature(plate, split=5.0).pose.bones["low"]  # which carries all
    bone.rotation_mode, bone.rotation_euler, bone.location = "XYZ", (0.9, 0.1, 0.4), (0.2, 0.3, 0.1)
    before = scenes.evaluated_points(plate)
    assert np.abs(before - scenes.base_points(plate)).max() > 1.0
    places = before[[0, 10, 110, 120, 60]] + np.outer((0, 0, 0, 0, 0.3), (0, 0, 1))
    controls = [scenes.new_empty(f"Point {k}", place) for k, place in enumerate(places)]
    add(plate, *controls, source="SELECTED", method="rbf")
    assert np.abs(scenes.evaluated_points(plate) - before).max() < 1e-6
    turn = Matrix.Translation((0.3, 1.0, -0.4)) @ Matrix.Rotation(1.1, 4, (0.3, 0.5, 0.8))
    for control in controls:
        scenes.move_world(control, turn)
    assert np.abs(scenes.evaluated_points(plate) - scenes.apply_matrix(turn, before)).max() < 1e-5


# --- regions painted with weights, which share vertices as those of bones do


LIFT = 0.5


def painted(method: str) -> bpy.types.Object:
    """A ball whose weights fade from the upper region to the lower one; they sum to 1 everywhere."""
    obj = ball("Target", 4)
    upper = np.clip(0.5 + 1.25 * scenes.base_points(obj)[:, 2], 0.0, 1.0)
    for name, weights in (("Upper", upper), ("Lower", 1.0 - upper)):
        group = obj.vertex_groups.new(name=name)
        for index in np.flatnonzero(weights):
            group.add([int(index)], float(weights[index]), "REPLACE")
    scenes.add_regions(obj, method, {"Upper": "HANDLE", "Lower": "FIXED"})
    return obj


@pytest.mark.parametrize("method", ON_HANDLE_POINTS)
def test_regions_that_share_painted_vertices_blend_and_their_weight_counts_at_once(method: str):
    obj = painted(method)
    deformer, rest = obj.sinew.active, scenes.base_points(obj)
    assert deformer.is_bound, deformer.status
    deformer.handles[0].control.location.z += LIFT
    height, lifts = rest[:, 2], []
    for weight in (1.0, 0.2, 0.0):
        deformer.handles[0].weight = weight
        lifts.append((scenes.evaluated_points(obj) - rest)[:, 2])
        assert deformer.status_level != "ERROR", (deformer.status, notes_of(deformer))
    up, less, none = lifts
    assert up[height > 0.5].min() > 0.6 * LIFT
    assert up[height < -0.5].max() < 0.4 * LIFT
    rings = [up[np.abs(height - z) < 0.07].mean() for z in np.linspace(-0.36, 0.36, 7)]
    assert (np.diff(rings) > 0.0).all(), rings
    middle = np.abs(height) < 0.12
    assert less[middle].mean() < up[middle].mean() - 1e-3
    assert np.abs(none).max() < 1e-5  # the lower one alone holds it
    assert any("weight is 0" in note for note in (deformer.status, *notes_of(deformer)))
