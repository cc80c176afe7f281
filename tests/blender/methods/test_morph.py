# SPDX-License-Identifier: GPL-3.0-or-later
"""Morphing between two meshes with the same faces, as a setting of Pyramid Coordinates."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import factor_of, notes_of
from probe import render_points
from rigs import rig as scenes
from rigs.sheet import draw, draw_panel

METHOD = "pyramid_coordinates"
EXACT = 1e-5  # float32, and a solve


def reshaped(source: bpy.types.Object, shape, name: str = "Other") -> bpy.types.Object:
    """A copy of the mesh without deformers and modifiers, each vertex at ``shape(place)``."""
    mesh = source.data.copy()
    for vertex in mesh.vertices:
        vertex.co = shape(np.array(vertex.co))
    return scenes.linked(bpy.data.objects.new(name, mesh))


def dome(co: np.ndarray) -> np.ndarray:
    return co * (1.2, 1.2, 1.0) + (0.3, 0.0, 0.8 * (1 - 0.5 * co[0] ** 2 - 0.5 * co[1] ** 2))


def shows(obj: bpy.types.Object, shape: bpy.types.Object) -> bool:
    """The places of the vertices of a mesh."""
    return scenes.close(scenes.evaluated_points(obj), scenes.base_points(shape), EXACT)


def morph(obj: bpy.types.Object, other: bpy.types.Object, **keywords) -> bpy.types.PropertyGroup:
    scenes.make_active(obj, other)
    assert bpy.ops.sinew.morph(**keywords) == {"FINISHED"}
    return obj.sinew.active


@pytest.fixture
def pair() -> tuple[bpy.types.Object, bpy.types.Object]:
    """A plate without regions, and a dome with the same faces."""
    obj = scenes.grid_object()
    return obj, reshaped(obj, dome)


def turn_faces(other: bpy.types.Object) -> None:
    points, faces = (
        scenes.base_points(other).tolist(),
        [tuple(face.vertices)[::-1] for face in other.data.polygons],
    )
    other.data.clear_geometry()
    other.data.from_pydata(points, [], faces)


CHANGES = {"as it is": lambda other: None, "turned faces": turn_faces, "with a modifier": scenes.subdivided}


@pytest.mark.parametrize("change", CHANGES)
def test_the_operator_makes_a_live_morph_without_handles(pair: tuple, change: str):
    """Modifiers of the target do not count, an edit of it does at the next bind; without it nothing moves."""
    obj, other = pair
    CHANGES[change](other)
    deformer = morph(obj, other)
    assert (deformer.method, deformer.is_bound, deformer.status_level) == (METHOD, True, "INFO"), (
        deformer.status
    )
    assert shows(obj, other)
    deformer.parameters.morph = 0.0
    assert shows(obj, obj)
    deformer.parameters.morph = 0.5
    half = scenes.evaluated_points(obj)
    assert np.abs(half - (scenes.base_points(obj) + scenes.base_points(other)) / 2).max() < 0.2
    assert np.abs(half - scenes.base_points(obj)).max() > 0.2
    assert scenes.close(render_points(obj), half, EXACT)
    deformer.parameters.morph = 1.0
    for vertex in other.data.vertices:
        vertex.co.z += 1.0
    scenes.press(obj, "bind")
    assert shows(obj, other)
    bpy.data.objects.remove(other)
    assert shows(obj, obj), deformer.status


def test_the_slider_of_the_morph_is_the_first_setting_of_the_panel(pair: tuple):
    morph(*pair)
    sheet = draw_panel()
    shown = sheet.properties()
    assert shown.index("morph") < shown.index("factor")
    (keywords,) = (k for name, args, k, _s in sheet.calls if name == "prop" and args[1] == "morph")
    assert keywords["slider"]
    advanced = set(draw(bpy.types.SINEW_PT_advanced).properties())
    assert advanced & {"morph", "max_iterations", "tolerance"} == {"max_iterations", "tolerance"}


def three_parts() -> bpy.types.Object:
    """Three plates in one mesh, above each other, and with a group of a side of the lowest one."""
    obj = scenes.grid_object("Parts")
    stack = obj.modifiers.new("Array", "ARRAY")
    stack.count, stack.use_relative_offset, stack.use_constant_offset = 3, False, True
    stack.constant_offset_displace = 0.0, 0.0, 3.0
    bpy.ops.object.modifier_apply(modifier="Array")
    scenes.add_group(obj, "Side", lambda point: point[0] > 0.9 and point[2] < 1.0)
    return obj


@pytest.mark.parametrize("loose", ["STAY", "FOLLOW"])
@pytest.mark.parametrize(("held", "targeted"), [(True, True), (True, False), (False, True)])
def test_the_panel_says_that_parts_stay_at_rest_only_where_they_do(held: bool, targeted: bool, loose: str):
    obj = three_parts()
    other = reshaped(obj, dome)
    scenes.press(obj, "deformer_add", method=METHOD)
    deformer = obj.sinew.active
    deformer.loose_parts = loose
    if held:
        scenes.press(obj, "handle_add", kind="HANDLE", vertex_group="Side")
    if targeted:
        morph(obj, other)
    if held:
        deformer.handles[0].control.location.x += 0.25
    shown, base = scenes.evaluated_points(obj).reshape(3, -1, 3), scenes.base_points(obj).reshape(3, -1, 3)
    stay = sum(scenes.close(shown[part], base[part], EXACT) for part in (1, 2))
    said = next((text for text in notes_of(deformer) if "at rest" in text), "")
    assert said == (f"{stay} loose parts stay at rest" if stay else ""), notes_of(deformer)
    assert held or shows(obj, other)


def test_the_factor_is_keyed_and_no_frame_binds_anew(pair: tuple):
    scene, (obj, other) = bpy.context.scene, pair
    scene.frame_start, scene.frame_end = 1, 11
    deformer, seen = morph(obj, other, key=True), {}
    factor = factor_of(deformer)
    for frame in (1, 6, 11, 6):
        scene.frame_set(frame)
        points = scenes.evaluated_points(obj)
        assert np.array_equal(points, seen.setdefault(frame, points))
    assert scenes.close(seen[1], scenes.base_points(obj), EXACT)
    assert scenes.close(seen[11], scenes.base_points(other), EXACT)
    assert 0.0 < deformer.parameters.morph < 1.0
    assert factor_of(deformer) is factor


def test_handles_move_the_morph(plate: scenes.Rig):
    plate.bind(METHOD)
    other = reshaped(plate.obj, dome)
    plate.deformer.parameters.target_shape, plate.deformer.parameters.morph = other, 1.0
    assert shows(plate.obj, other), plate.deformer.status
    plate.lift(1.0)
    lifted = plate.points()
    assert scenes.close(lifted[plate.top], scenes.base_points(other)[plate.top] + (0.0, 0.0, 1.0), EXACT)
    plate.deformer.parameters.morph = 0.0
    assert np.abs(plate.points() - lifted).max() > 0.1
