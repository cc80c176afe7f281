# SPDX-License-Identifier: GPL-3.0-or-later
"""A UV map as the parameter of a method: read at each vertex, edited, and gone."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from expected import faces_of
from inside import notes_of
from rigs.kinds import HandleRig
from rigs.rig import base_points, close, make_active, update

METHOD = "spline_surface"


def add_map(obj: bpy.types.Object, name: str, place) -> None:
    """A UV map with ``place`` of each vertex."""
    layer = obj.data.uv_layers.new(name=name)
    for loop in obj.data.loops:
        layer.data[loop.index].uv = place(*obj.data.vertices[loop.vertex_index].co)


def wave(x: float, y: float, z: float) -> tuple[float, float]:
    return x + 0.3 * y * y, y - 0.2 * x


@pytest.fixture
def rig() -> HandleRig:
    rig = HandleRig.new()
    add_map(rig.obj, "Wave", wave)
    rig.bind(METHOD)
    rig.deformer.parameters.degree = 2
    rig.lift(1.0)
    return rig


def test_the_native_object_gets_the_places_of_the_vertices(rig: HandleRig):
    flat = rig.points()
    rig.deformer.parameters.uv_map = "Wave"
    mapped = rig.points()
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    assert np.abs(mapped - flat).max() > 1e-4
    places = np.array([wave(*point) for point in base_points(rig.obj)])
    expected = rig.expected(METHOD, degree=2, uv_map=places)
    assert close(mapped, expected.lifted(1.0), 1e-5)
    rig.deformer.parameters.uv_map = ""
    assert close(rig.points(), flat)


def test_a_vertex_of_a_seam_takes_the_place_of_its_first_corner():
    rig = HandleRig.new()
    layer = rig.obj.data.uv_layers.new(name="Seams")
    at_corners = np.random.default_rng(3).random((len(layer.data), 2)).astype(np.float32)
    layer.data.foreach_set("uv", at_corners.ravel())
    rig.bind(METHOD)
    rig.deformer.parameters.degree = 2
    rig.deformer.parameters.uv_map = "Seams"
    rig.lift(1.0)
    places = np.full((len(rig.rest()), 2), np.nan)
    for corner, vertex in enumerate(faces_of(rig.obj.data)[1]):
        if np.isnan(places[vertex, 0]):
            places[vertex] = at_corners[corner]
    seen = rig.points()
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    expected = rig.expected(METHOD, degree=2, uv_map=places.astype(np.float64))
    assert close(seen, expected.lifted(1.0), 1e-5)


def test_an_edit_of_the_map_is_followed_after_a_bind(rig: HandleRig):
    rig.deformer.parameters.uv_map = "Wave"
    before = rig.points()
    layer = rig.obj.data.uv_layers["Wave"]
    for loop in rig.obj.data.loops:
        x, y, _z = rig.obj.data.vertices[loop.vertex_index].co
        layer.data[loop.index].uv = (y * y * y, x)
    rig.obj.data.update()
    make_active(rig.obj)
    update()
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert np.abs(rig.points() - before).max() > 1e-4


def test_a_map_that_is_gone_is_named_and_the_plane_is_used(rig: HandleRig):
    flat = rig.points()
    rig.deformer.parameters.uv_map = "Gone"
    assert close(rig.points(), flat)
    assert notes_of(rig.deformer) == [
        "UV Map 'Gone' is not on the mesh: a plane is used instead - pick another"
    ]
