# SPDX-License-Identifier: GPL-3.0-or-later
"""The control grid of a spline surface as an object whose points are dragged."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from expected import Expected
from inside import inner
from mathutils import Matrix, Vector
from probe import render_points
from rigs.rig import Rig, base_points, change_in_edit_mode, close, linked, make_active, press, update

METHOD = "spline_surface"
SIDE = 9  # control points in each direction: 6 spans
TOLERANCE = 1e-5  # the points of the grid are in float32


@pytest.fixture
def sheet() -> Rig:
    """A plate of 20 x 20 faces, fixed at its near edge, with its far edge as a handle."""
    rig = Rig.plate(cells=20).bind(METHOD)
    rig.deformer.parameters.columns = rig.deformer.parameters.rows = SIDE
    update()
    return rig


def new_grid(rig: Rig) -> bpy.types.Object:
    press(rig.obj, "grid_new")
    return grid_of(rig)


def grid_of(rig: Rig) -> bpy.types.Object:
    return rig.obj.sinew.active.spline_surface.grid


def drag(rig: Rig, moved: dict[int, tuple[float, float, float]]) -> np.ndarray:
    """Move points of the grid in Edit Mode; how far each point is moved, (g, 3)."""
    grid = grid_of(rig)
    moves = np.zeros((len(grid.data.vertices), 3))

    def change(edit: bmesh.types.BMesh) -> None:
        for index, way in moved.items():
            edit.verts[index].co += Vector(way)
            moves[index] += way

    change_in_edit_mode(grid, change)
    return moves


def expected(rig: Rig, moves: np.ndarray | None) -> Expected:
    """By a new native object, while the control is at rest."""
    return Expected.of_rig(rig, METHOD, columns=SIDE, rows=SIDE, grid=moves)


def at_middle(index: int = SIDE * SIDE // 2) -> dict[int, tuple[float, float, float]]:
    return {index: (0.1, -0.05, 0.8)}


def test_a_new_grid_has_the_points_of_the_control_grid_and_moves_nothing(sheet: Rig):
    before = sheet.points()
    grid = new_grid(sheet)
    assert len(grid.data.vertices) == SIDE * SIDE
    assert len(grid.data.edges) == 2 * SIDE * (SIDE - 1)
    assert grid.parent == sheet.obj
    assert bpy.context.object == grid
    assert np.array_equal(sheet.points(), before)
    places = base_points(grid)
    assert np.abs(places[:, 2]).max() < 1e-4
    assert np.ptp(places[:, 0]) == pytest.approx(np.ptp(places[:, 1]), rel=1e-3)


def test_points_add_to_what_handles_do_and_held_vertices_stay_with_their_handles(sheet: Rig):
    new_grid(sheet)
    shape = {SIDE * 7 + 4: (0.0, 0.3, 0.5), SIDE + 2: (0.0, 0.0, -0.7)}
    moves = drag(sheet, shape)
    poses = expected(sheet, moves)
    sheet.lift(0.6)
    seen = sheet.points()
    assert close(seen, poses.lifted(0.6), TOLERANCE)
    assert close(seen[sheet.top], sheet.rest()[sheet.top] + (0.0, 0.0, 0.6), 1e-6)
    assert close(seen[sheet.base], sheet.rest()[sheet.base], 1e-6)
    assert np.abs(render_points(sheet.obj) - seen).max() < TOLERANCE


def test_the_object_may_stand_anywhere_and_be_hidden_and_its_turn_and_scale_count(sheet: Rig):
    grid = new_grid(sheet)
    moves = drag(sheet, at_middle())
    before = sheet.points()
    grid.location = (5.0, 3.0, 2.0)
    grid.hide_viewport = True
    assert close(sheet.points(), before, TOLERANCE)
    turn = Matrix.Rotation(0.5, 4, "X") @ Matrix.Scale(2.0, 4)
    grid.matrix_world = turn
    linear = np.array(turn)[:3, :3]
    assert close(sheet.points(), expected(sheet, moves @ linear.T).lifted(0.0), TOLERANCE)


def test_apply_of_the_target_keeps_the_shape_in_the_world(sheet: Rig):
    sheet.obj.scale = (2.0, 1.0, 0.5)
    update()
    new_grid(sheet)
    drag(sheet, at_middle())
    world = np.array(sheet.obj.matrix_world)
    before = sheet.points() @ world[:3, :3].T
    make_active(sheet.obj)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    assert close(sheet.points(), before, 1e-4)


def test_a_copy_shares_the_grid_unless_it_is_copied_too(sheet: Rig):
    new_grid(sheet)
    drag(sheet, at_middle())
    before = sheet.points()
    for together in (False, True):
        make_active(sheet.obj)
        grid_of(sheet).select_set(together)
        bpy.ops.object.duplicate()
        copy = Rig.called(next(obj.name for obj in bpy.context.selected_objects if obj.sinew.deformers))
        inner.housekeeping.separate_copies()
        assert close(copy.points(), before)
        assert (grid_of(copy) != grid_of(sheet)) == together
        drag(copy, {SIDE * 5 + 2: (0.0, 0.0, -0.4)})
        assert not close(copy.points(), before, 0.01)
        assert close(sheet.points(), before) == together
        before = sheet.points()


def test_another_grid_starts_anew_in_the_same_object(sheet: Rig):
    grid = new_grid(sheet)
    drag(sheet, at_middle())
    sheet.deformer.parameters.columns = SIDE - 2
    update()
    assert "moves given" in sheet.deformer.status
    assert "grid" in sheet.deformer.status
    assert close(sheet.points(), sheet.rest(), 1e-6)
    assert new_grid(sheet) == grid
    assert len(grid.data.vertices) == SIDE * (SIDE - 2)
    assert sheet.deformer.status_level == "INFO", sheet.deformer.status
    assert close(sheet.points(), sheet.rest(), 1e-6)


def test_a_grid_out_of_the_scene_a_deleted_one_and_another_mesh_move_nothing(sheet: Rig):
    grid = new_grid(sheet)
    drag(sheet, at_middle())
    assert not close(sheet.points(), sheet.rest(), 0.1)
    bpy.context.scene.collection.objects.unlink(grid)
    sheet.obj.update_tag()
    assert close(sheet.points(), sheet.rest(), 1e-6)
    assert new_grid(sheet) == grid
    assert grid.users_scene
    change_in_edit_mode(grid, lambda edit: edit.verts.remove(edit.verts[0]))
    make_active(sheet.obj)
    update()
    assert "has 80 vertices" in sheet.deformer.status
    bpy.data.objects.remove(grid)
    assert close(sheet.points(), sheet.rest(), 1e-6)
    other = linked(bpy.data.objects.new("Other", bpy.data.meshes.new("Other")))
    sheet.deformer.parameters.grid = other
    update()
    assert "is no control grid" in sheet.deformer.status


def test_points_that_are_not_finite_are_refused_and_the_grid_goes_with_its_deformer(sheet: Rig):
    grid = new_grid(sheet)
    grid.data.vertices[5].co.z = float("nan")
    grid.data.update()
    assert close(sheet.points(), sheet.rest(), 1e-6)
    assert "NaN" in sheet.deformer.status
    name = grid.name
    press(sheet.obj, "deformer_remove")
    assert name not in bpy.data.objects


def test_around_a_spline_multiresolution_moves_its_grid_too(sheet: Rig):
    new_grid(sheet)
    drag(sheet, at_middle())
    sheet.deformer.method = "thin_shell"
    make_active(sheet.obj)
    assert not bpy.ops.sinew.grid_new.poll()
    sheet.deformer.method = "multiresolution"
    sheet.deformer.parameters.base = METHOD
    update()
    assert sheet.deformer.status_level == "INFO", sheet.deformer.status
    assert sheet.points()[:, 2].max() > 0.2
