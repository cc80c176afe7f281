# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires: where they come from, every type of curve, everything that poses a curve, and what is no wire."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from editing import edit
from inside import native
from probe import render_points
from rigs import rig as scenes
from rigs.rig_of_curves import places_of, polyline, stroke_through

RADIUS = 0.6
DRAWN = 2e-5  # Blender sums its curves up in float32, a dozen steps per segment


def line(y: float = 0.0, z: float = 0.0, count: int = 6) -> np.ndarray:
    """Places across the plate."""
    x = np.linspace(-1.0, 1.0, count)
    return np.column_stack((x, np.full(count, y), np.full(count, z)))


def curve(kind: str, name: str = "Wire") -> bpy.types.Object:
    """A wire of any type across the plate, not straight."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new(kind)
    places = line(0.1)
    places[:, 1] += 0.2 * np.sin(3.0 * places[:, 0])
    if kind == "BEZIER":
        spline.bezier_points.add(len(places) - 1)
        for point, place in zip(spline.bezier_points, places, strict=True):
            point.co = place
            point.handle_left_type = point.handle_right_type = "AUTO"
    else:
        spline.points.add(len(places) - 1)
        for point, place in zip(spline.points, places, strict=True):
            point.co = (*place, 1.0)
        spline.use_endpoint_u = True
    return scenes.linked(bpy.data.objects.new(name, data))


def drawn(wire: bpy.types.Object) -> np.ndarray:
    """What Blender draws of a curve, in the world, (c, 3)."""
    return scenes.apply_matrix(wire.matrix_world, scenes.evaluated_points(wire))


def wired(*wires: bpy.types.Object, radius: float = RADIUS, target: bpy.types.Object | None = None):
    """The plate, which these curves move."""
    plate = target or scenes.grid_object()
    for wire in wires:
        scenes.press(plate, "wire_add", curve=wire.name, radius=radius)
    scenes.make_active(plate)
    return plate


def expected(
    points: np.ndarray, *curves: tuple[np.ndarray, np.ndarray], radius: object = RADIUS, **options: object
) -> np.ndarray:
    """What wires at rest and now make of points."""
    rest, posed = zip(*curves, strict=True)
    counts = [len(one) for one in rest]
    wires = native().Wires(np.concatenate(rest), counts, radius=radius, **options)
    wires.bind(points)
    return wires.warp(np.concatenate(posed))


def test_wires_share_a_deformer_until_they_are_removed_and_steer_several_targets() -> None:
    wires = [polyline(line(y), f"Wire {y}") for y in (-0.4, 0.4)]
    plate = wired(*wires)
    other = wired(wires[0], target=scenes.grid_object("Other"))
    assert len(plate.sinew.deformers) == 1
    assert [row.object for row in plate.sinew.active.controls] == wires
    moves = []
    for wire, height in zip(wires, (0.3, 0.9), strict=True):
        wire.location.z = height
        moves.append((places_of(wire), places_of(wire) + (0.0, 0.0, height)))
    assert scenes.close(scenes.evaluated_points(plate), expected(scenes.base_points(plate), *moves))
    assert scenes.close(scenes.evaluated_points(other), expected(scenes.base_points(other), moves[0]))
    scenes.press(plate, "control_remove", index=0)
    assert [row.object for row in plate.sinew.active.controls] == wires[1:]
    wires[1].location.z = 0.0
    assert scenes.close(scenes.evaluated_points(plate), scenes.base_points(plate))
    assert bpy.ops.sinew.control_remove() == {"FINISHED"}
    assert not plate.sinew.active.controls
    assert not plate.sinew.active.is_bound
    assert wires[0].name in bpy.data.objects, "an artist's own curve stays"


def test_each_wire_has_its_own_settings() -> None:
    wires = [polyline(line(y), f"Wire {y}") for y in (-0.5, 0.5)]
    plate = wired(*wires)
    first, second = plate.sinew.active.controls
    first.radius, second.radius, second.scale, first.rotation = 0.3, 0.4, 1.5, 0.0
    for wire in wires:
        wire.rotation_euler.x = 0.5
    scenes.update()
    moves = [(places_of(wire), scenes.apply_matrix(wire.matrix_world, places_of(wire))) for wire in wires]
    own = {"radius": [0.3, 0.4], "scale": [1.0, 1.5], "rotation": [0.0, 1.0]}
    both, rest = expected(scenes.base_points(plate), *moves, **own), scenes.base_points(plate)
    assert scenes.close(scenes.evaluated_points(plate), both)
    second.enabled = False
    alone = scenes.evaluated_points(plate)
    assert not scenes.close(alone, both)
    assert np.array_equal(alone[rest[:, 1] > 0.3], rest[rest[:, 1] > 0.3])


def test_a_wire_along_selected_edges_follows_and_goes_with_the_deformer() -> None:
    plate = scenes.grid_object()
    edit(plate, lambda point: abs(point.y - 0.2) < 1e-4)
    assert bpy.ops.sinew.wire_add(points=0, radius=RADIUS) == {"FINISHED"}
    assert plate.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    wire = plate.sinew.active.controls[0].object
    assert wire.parent == plate
    assert scenes.close(drawn(wire)[np.argsort(drawn(wire)[:, 0])], line(0.2, count=11))
    wire.location.z = 0.5
    row = np.abs(scenes.base_points(plate)[:, 1] - 0.2) < 1e-4
    assert np.allclose(scenes.evaluated_points(plate)[row, 2], 0.5, atol=scenes.FLOAT32)
    name = wire.name
    scenes.press(plate, "deformer_remove")
    assert name not in bpy.data.objects


def test_a_ring_of_edges_becomes_a_closed_curve_with_few_points() -> None:
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, depth=2.0, radius=1.0)
    can = bpy.context.object
    edit(can, lambda point: point.z > 0.9)
    assert bpy.ops.sinew.wire_add(points=6) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    (spline,) = can.sinew.active.controls[0].object.data.splines
    assert spline.use_cyclic_u
    assert len(spline.bezier_points) == 6
    assert np.allclose([np.hypot(*point.co[:2]) for point in spline.bezier_points], 1.0, atol=1e-5)


def test_a_stroke_becomes_a_wire() -> None:
    plate = scenes.grid_object()
    plate.location = (3.0, 0.0, 1.0)
    scenes.make_active(plate)
    stroke = stroke_through([(3.0 + x, 0.3, 1.0) for x in np.linspace(-0.8, 0.8, 40)])
    assert bpy.ops.sinew.wire_draw(stroke=stroke, points=5, radius=RADIUS) == {"FINISHED"}
    wire = plate.sinew.active.controls[0].object
    assert len(wire.data.splines[0].bezier_points) == 5
    assert np.allclose(drawn(wire)[:, 1:], (0.3, 1.0), atol=1e-5)
    wire.location.z += 0.4
    assert scenes.evaluated_points(plate)[:, 2].max() > 0.2


def test_a_domain_curve_limits_its_wire() -> None:
    wire, domain = polyline(line(0.0)), polyline(line(0.3), "Domain")
    plate = wired(wire)
    row = plate.sinew.active.controls[0]
    row.domain = domain
    assert "Rebind" in plate.sinew.active.status or plate.sinew.active.status_level != "ERROR"
    scenes.press(plate, "bind")
    domain.location.y = 5.0  # where it is later does not count
    wire.location.z = 0.5
    shape = scenes.evaluated_points(plate)
    far = scenes.base_points(plate)[:, 1] > 0.3 - 1e-4
    assert np.abs(shape[far, 2]).max() == 0.0
    assert scenes.close(shape, expected(scenes.base_points(plate), (line(), line(z=0.5)), domain=line(0.3)))


def test_curves_without_length_are_refused_by_name() -> None:
    plate = scenes.grid_object()
    scenes.press(plate, "wire_add", curve=polyline(np.zeros((3, 3)), "Dot").name)
    assert plate.sinew.active.status_level == "ERROR"
    assert "Dot has no length" in plate.sinew.active.status
    assert scenes.close(scenes.evaluated_points(plate), scenes.base_points(plate))


@pytest.mark.parametrize("what", ["bevel_depth", "extrude"])
def test_a_curve_that_shows_faces_is_refused_by_name(what: str) -> None:
    plate, wire = scenes.grid_object(), curve("BEZIER", "Thick")
    setattr(wire.data, what, 0.1)
    scenes.press(plate, "wire_add", curve=wire.name)
    assert "Thick shows faces" in plate.sinew.active.status
    setattr(wire.data, what, 0.0)
    scenes.press(plate, "bind")
    assert plate.sinew.active.is_bound


def test_renders_with_another_resolution_show_the_same() -> None:
    wire = curve("BEZIER")
    wire.data.render_resolution_u = 36
    plate = wired(wire)
    wire.location.z = 0.5
    shown = scenes.evaluated_points(plate)
    assert np.abs(render_points(plate) - shown).max() < 1e-4  # places between samples are on their sides
    assert shown[:, 2].max() > 0.4


def test_radius_is_a_length_of_the_curve_object() -> None:
    wire = polyline(0.5 * line())
    wire.scale = (2.0, 2.0, 2.0)
    plate = wired(wire, radius=0.5 * RADIUS)
    plate.scale = (1.0, 1.0, 1.0)
    wire.location.z = 0.5
    assert scenes.close(
        scenes.evaluated_points(plate), expected(scenes.base_points(plate), (line(), line(z=0.5))), 1e-5
    )
