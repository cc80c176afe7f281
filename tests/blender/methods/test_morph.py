# SPDX-License-Identifier: GPL-3.0-or-later
"""Morphing between two meshes with the same faces, as a setting of Pyramid Coordinates."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import notes_of
from probe import render_points
from rigs.kinds import HandleRig
from rigs.rig import base_points, close, evaluated_points, linked, make_active, press
from rigs.sheet import draw, draw_panel

METHOD = "pyramid_coordinates"
EXACT = 1e-5  # float32, and a solve


def reshaped(source: bpy.types.Object, shape, name: str = "Other") -> bpy.types.Object:
    """A copy of the mesh without deformers and modifiers, each vertex at ``shape(place)``."""
    mesh = source.data.copy()
    for vertex in mesh.vertices:
        vertex.co = shape(np.array(vertex.co))
    return linked(bpy.data.objects.new(name, mesh))


def dome(co: np.ndarray) -> np.ndarray:
    return co * (1.2, 1.2, 1.0) + (0.3, 0.0, 0.8 * (1 - 0.5 * co[0] ** 2 - 0.5 * co[1] ** 2))


def morph(obj: bpy.types.Object, other: bpy.types.Object, **keywords) -> set[str]:
    make_active(obj, other)
    return bpy.ops.sinew.morph(**keywords)


@pytest.fixture
def rig() -> HandleRig:
    return HandleRig.new()


@pytest.fixture
def pair(rig: HandleRig) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The mesh of the rig without its regions, and a dome with the same faces."""
    obj = reshaped(rig.obj, lambda co: co, "Plain")
    return obj, reshaped(obj, dome)


def test_the_operator_makes_a_live_morph_without_handles(pair: tuple):
    obj, other = pair
    assert morph(obj, other) == {"FINISHED"}
    deformer = obj.sinew.active
    assert (deformer.method, deformer.is_bound) == (METHOD, True), deformer.status
    assert close(evaluated_points(obj), base_points(other), EXACT)
    deformer.parameters.morph = 0.0
    assert close(evaluated_points(obj), base_points(obj), EXACT)
    deformer.parameters.morph = 0.5
    half = evaluated_points(obj)
    assert np.abs(half - (base_points(obj) + base_points(other)) / 2).max() < 0.2
    assert np.abs(half - base_points(obj)).max() > 0.2
    assert deformer.status_level == "INFO", deformer.status


def test_the_slider_of_the_morph_is_the_first_setting_of_the_panel(pair: tuple):
    morph(*pair)
    sheet = draw_panel()
    shown = sheet.properties()
    assert shown.index("morph") < shown.index("factor")
    (keywords,) = (k for name, args, k, _s in sheet.calls if name == "prop" and args[1] == "morph")
    assert keywords["slider"]
    advanced = draw(bpy.types.SINEW_PT_advanced).properties()
    assert "morph" not in advanced
    assert {"max_iterations", "tolerance"} <= set(advanced)


def three_parts(source: bpy.types.Object) -> bpy.types.Object:
    """Three copies of a mesh in one, above each other, and with a group of a side of the lowest one."""
    mesh = source.data
    points = base_points(source)
    faces = np.array([list(face.vertices) for face in mesh.polygons])
    parts = bpy.data.meshes.new("Parts")
    parts.from_pydata(
        np.concatenate([points + (0.0, 0.0, 3.0 * k) for k in range(3)]).tolist(),
        [],
        np.concatenate([faces + k * len(points) for k in range(3)]).tolist(),
    )
    obj = linked(bpy.data.objects.new("Parts", parts))
    side = np.flatnonzero(points[:, 0] > points[:, 0].max() - 0.1).tolist()
    obj.vertex_groups.new(name="Side").add(side, 1.0, "REPLACE")
    return obj


@pytest.mark.parametrize("loose", ["STAY", "FOLLOW"])
@pytest.mark.parametrize("targeted", [False, True])
@pytest.mark.parametrize("held", [False, True])
def test_the_panel_says_that_parts_stay_at_rest_only_where_they_do(
    rig: HandleRig, held: bool, targeted: bool, loose: str
):
    obj = three_parts(rig.obj)
    other = reshaped(obj, dome)
    press(obj, "deformer_add", method=METHOD)
    deformer = obj.sinew.active
    deformer.loose_parts = loose
    if held:
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Side")
        make_active(obj)
    if targeted:
        assert morph(obj, other) == {"FINISHED"}
    if not (held or targeted):
        return  # nothing moves it
    if held:
        deformer.handles[0].control.location.x += 0.25
    shown, base = evaluated_points(obj), base_points(obj)
    count = len(base) // 3
    stay = sum(close(shown[k * count :][:count], base[k * count :][:count], EXACT) for k in (1, 2))
    said = next((text for text in notes_of(deformer) if "at rest" in text), "")
    assert said == (f"{stay} loose parts stay at rest" if stay else ""), notes_of(deformer)
    if targeted and not held:
        assert close(shown, base_points(other), EXACT)


def test_the_factor_is_keyed_and_no_frame_binds_anew(pair: tuple):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 11
    obj, other = pair
    assert morph(obj, other, key=True) == {"FINISHED"}
    seen = {}
    for frame in (1, 6, 11, 6):
        scene.frame_set(frame)
        points = evaluated_points(obj)
        if frame in seen:
            assert np.array_equal(points, seen[frame])
        seen[frame] = points
    assert close(seen[1], base_points(obj), EXACT)
    assert close(seen[11], base_points(other), EXACT)
    assert 0.0 < obj.sinew.active.parameters.morph < 1.0


def test_modifiers_of_the_target_do_not_count_and_renders_show_the_morph(pair: tuple):
    obj, other = pair
    other.modifiers.new("Subdivision", "SUBSURF").levels = 1
    assert morph(obj, other) == {"FINISHED"}
    obj.sinew.active.parameters.morph = 0.75
    shown = evaluated_points(obj)
    assert np.abs(shown - base_points(obj)).max() > 0.2, obj.sinew.active.status
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert close(render_points(obj), shown, EXACT)


def test_handles_move_the_morph(rig: HandleRig):
    rig.bind(METHOD)
    other = reshaped(rig.obj, dome)
    rig.deformer.parameters.target_shape = other
    rig.deformer.parameters.morph = 1.0
    assert close(rig.points(), base_points(other), EXACT), rig.deformer.status
    rig.lift(1.0)
    lifted = rig.points()
    assert np.abs(lifted[rig.top] - base_points(other)[rig.top] - (0.0, 0.0, 1.0)).max() < EXACT
    rig.deformer.parameters.morph = 0.0
    assert np.abs(rig.points() - lifted).max() > 0.1


def with_faces(obj: bpy.types.Object, order) -> bpy.types.Object:
    """The same points, and the corners of each face in another order."""
    mesh = bpy.data.meshes.new("Other")
    faces = [order(*face.vertices) for face in obj.data.polygons]
    mesh.from_pydata([tuple(vertex.co) for vertex in obj.data.vertices], [], faces)
    return linked(bpy.data.objects.new("Other", mesh))


def test_faces_of_the_other_shape_may_be_turned(rig: HandleRig):
    obj = reshaped(rig.obj, lambda co: co, "Plain")
    other = with_faces(reshaped(obj, dome), lambda a, b, c, d: (c, b, a, d))
    assert morph(obj, other) == {"FINISHED"}
    assert close(evaluated_points(obj), base_points(other), EXACT)
    obj.sinew.active.parameters.morph = 0.0
    assert close(evaluated_points(obj), base_points(obj), EXACT)


def test_a_target_that_is_deleted_leaves_the_mesh_as_it_is(rig: HandleRig):
    rig.bind(METHOD)
    other = reshaped(rig.obj, dome)
    rig.deformer.parameters.target_shape = other
    rig.deformer.parameters.morph = 1.0
    rig.points()
    bpy.data.objects.remove(other)
    assert close(rig.points(), base_points(rig.obj), EXACT), rig.deformer.status


def test_an_edited_target_counts_at_the_next_bind(pair: tuple):
    obj, other = pair
    morph(obj, other)
    for vertex in other.data.vertices:
        vertex.co.z += 1.0
    press(obj, "bind")
    assert close(evaluated_points(obj), base_points(other), EXACT)
