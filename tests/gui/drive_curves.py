# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: wires along edges and by a stroke, and a drag of a vector field."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import bmesh
import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    Place,
    apart,
    click,
    enable,
    in_view,
    move,
    new_head,
    open_tab,
    play,
    press,
    region,
    rest,
    screenshot,
    seen,
    shown_points,
    viewport,
    window,
)
from mathutils import Vector

FRONT = (0.7071068, 0.7071068, 0.0, 0.0)
BROW = ((-1.0, 0.72), (-0.6, 0.85), (-0.2, 0.7))  # as seen from the front, at the left
NOSE, ASIDE = (0.0, -0.1), ((0.0, -0.1), (0.5, 0.1), (0.8, 0.7))


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def on_screen(x: float, z: float) -> Place:
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, Vector((x, -1.2, z)))
    return int(region().x + pixel.x), int(region().y + pixel.y)


def prepare() -> Iterator[None]:
    """A head from the front, with the panel of Sinew beside it."""
    new_head(2, {})
    view = viewport().spaces.active
    view.region_3d.view_perspective, view.region_3d.view_rotation = "ORTHO", FRONT
    view.region_3d.view_location, view.region_3d.view_distance = (0.0, 0.0, 0.0), 9.0
    view.show_region_ui = True
    bpy.ops.ed.undo_push(message="Head")
    yield from rest(3)
    yield from open_tab()
    yield from rest(3)


def way_of(places: Iterable[tuple[float, float]]) -> list[Place]:
    corners = np.array(list(places))
    parts = [np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(corners)]
    return [on_screen(*point) for point in np.concatenate([*parts, corners[-1:]])]


def hold(places: Iterable[tuple[float, float]], picture: str = "") -> Iterator[None]:
    """Hold the left button along a polyline."""
    way = way_of(places)
    move(*way[0])
    yield
    window().event_simulate("LEFTMOUSE", "PRESS", x=way[0][0], y=way[0][1])
    yield
    for place in way[1:]:
        move(*place)
        yield
    if picture:
        screenshot(picture)
        yield
    window().event_simulate("LEFTMOUSE", "RELEASE", x=way[-1][0], y=way[-1][1])
    yield from rest(3)


def along_edges() -> Iterator[None]:
    """Select edges in Edit Mode, Add Wire, and move the wire with G."""
    before = shown_points(head())
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(head().data)
    for edge in edit.edges:
        edge.select_set(False)
    ring = max(edit.verts, key=lambda vertex: vertex.co.z)
    start = next(edge for edge in ring.link_edges)
    start.select_set(True)
    bmesh.update_edit_mesh(head().data)
    with in_view():
        bpy.ops.mesh.loop_multi_select(ring=False)
    yield from rest(3)
    screenshot("wire-1-edges")
    with in_view():
        bpy.ops.sinew.wire_add("INVOKE_DEFAULT")
    yield from rest(3)
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from rest(3)
    wire = head().sinew.active.controls[0].object
    seen["wire"] = [len(wire.data.splines), head().sinew.active.status]
    screenshot("wire-2-added")
    for other in bpy.context.selected_objects:
        other.select_set(False)
    wire.select_set(True)
    bpy.context.view_layer.objects.active = wire
    centre = on_screen(0.0, 0.5)
    move(*centre)
    yield from rest()
    press("G")
    yield
    move(centre[0], centre[1] + 60)
    yield from rest()
    press("LEFTMOUSE")
    yield from rest(3)
    seen["wire moved"] = apart(shown_points(head()), before)
    screenshot("wire-3-moved")
    press("Z", ctrl=True)
    yield from rest(3)
    seen["wire undone"] = apart(shown_points(head()), before)


def by_stroke() -> Iterator[None]:
    """Draw a brow, and pull the middle of the curve up in its Edit Mode."""
    bpy.context.view_layer.objects.active = head()
    before = shown_points(head())
    count = 0 if head().sinew.active is None else len(head().sinew.active.controls)
    move(*on_screen(0.0, 0.0))
    yield from rest()
    with in_view():
        bpy.ops.sinew.wire_draw("INVOKE_DEFAULT")
    yield from rest()
    yield from hold(((9.0, 9.0), (9.1, 9.1)))
    seen["stroke elsewhere"] = count
    yield from hold(BROW, "wire-4-drawing")
    rows = head().sinew.active.controls
    wire = rows[-1].object
    seen["stroke"] = [len(rows) - count, len(wire.data.splines[0].bezier_points)]
    drawn = np.linalg.norm(np.diff(np.array(BROW), axis=0), axis=1).sum()
    seen["stroke reaches"] = rows[-1].radius / drawn
    seen["stroke rests"] = apart(shown_points(head()), before)
    yield from rest(2)
    screenshot("wire-5-drawn")
    bpy.context.view_layer.objects.active = wire
    bpy.ops.object.mode_set(mode="EDIT")
    for point in wire.data.splines[0].bezier_points:
        point.select_control_point = point.select_left_handle = point.select_right_handle = False
    middle = wire.data.splines[0].bezier_points[2]
    middle.select_control_point = middle.select_left_handle = middle.select_right_handle = True
    yield from rest()
    place = on_screen(-0.6, 0.8)
    move(*place)
    yield from rest()
    press("G")
    yield
    move(place[0], place[1] + 45)
    yield from rest()
    press("LEFTMOUSE")
    yield from rest(3)
    seen["stroke moved"] = apart(shown_points(head()), before)
    screenshot("wire-6-raised")
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from rest(2)


def by_field() -> Iterator[None]:
    """Drag the nose along a bent path, then undo, drag again, and escape."""
    yield from prepare()
    before = shown_points(head())
    move(*on_screen(*NOSE))
    yield from rest()
    with in_view():
        bpy.ops.sinew.tool_drag("INVOKE_DEFAULT")
    yield from rest()
    move(*on_screen(0.02, -0.1))
    yield from rest()
    press("WHEELUPMOUSE")
    yield from rest()
    screenshot("field-1-hover")
    yield from hold(ASIDE, "field-2-dragging")
    after = shown_points(head())
    row = head().sinew.active.controls[0]
    seen["field"] = [len(row.rest.vertices) // 4 - 1, apart(after, before), head().sinew.active.status]
    seen["field reaches"] = row.outer / np.ptp(before, axis=0).max()
    yield from rest(2)
    screenshot("field-3-kept")
    row.progress = 0.5
    yield from rest(3)
    seen["half way"] = [apart(shown_points(head()), shape) for shape in (before, after)]
    screenshot("field-4-half-way")
    row.progress = 1.0
    yield from rest(3)
    seen["whole way"] = apart(shown_points(head()), after)
    press("Z", ctrl=True)
    yield from rest(3)
    seen["field undone"] = [len(head().sinew.deformers), apart(shown_points(head()), before)]
    with in_view():
        bpy.ops.sinew.tool_drag("INVOKE_DEFAULT")
    yield from rest()
    way = way_of(ASIDE)
    move(*way[0])
    yield
    window().event_simulate("LEFTMOUSE", "PRESS", x=way[0][0], y=way[0][1])
    yield
    for place in way[1:10]:
        move(*place)
        yield
    seen["before escape"] = apart(shown_points(head()), before)
    press("ESC")
    yield from rest(3)
    window().event_simulate("LEFTMOUSE", "RELEASE", x=way[-1][0], y=way[-1][1])
    yield from rest(2)
    tools = [obj.name for obj in bpy.data.objects if obj.type == "EMPTY"]
    seen["given up"] = [len(head().sinew.deformers), tools, apart(shown_points(head()), before)]


def journey() -> Iterator[None]:
    enable()
    yield from prepare()
    yield from along_edges()
    yield from by_stroke()
    yield from by_field()
    yield from click(*on_screen(3.0, 3.0))


play(journey())
