# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages, lattices and wires, posed by keys in Edit Mode; drags by a lattice and a vector field."""

from collections.abc import Callable, Iterator

import bmesh
import bpy
import numpy as np
import window
from driving import above, apart, claim, near, rest, run, until
from editing import select
from hand import between, drag, hold, keys, move, open_sidebar, polyline, press, release, stroke, undo
from inside import inner
from mathutils import Vector
from scenes import deformer, head, only_head, shown, smooth_head

FLOAT32 = 4e-6  # of a head 4 units wide
NOSE, EAR = (0.0, 0.0, -0.3), (1.7, 0.0, 0.35)  # as seen from the front
BROW = ((-1.0, 0.72), (-0.6, 0.85), (-0.2, 0.7))
ASIDE = ((0.0, -0.1), (0.5, 0.1), (0.8, 0.7))


def moved(before: np.ndarray) -> float:
    return apart(shown(), before)


def is_well() -> bool:
    return deformer().status_level == "INFO"


def head_from_front(levels: int) -> Iterator[None]:
    """Without a deformer, beside the panel of Sinew."""
    smooth_head(levels)
    window.look_from_front()
    yield from open_sidebar()


def pull(name: str, choose: Callable[[], None], height: str, far: float) -> Iterator[np.ndarray]:
    """Move the points that ``choose()`` selects in Edit Mode of a control; returns the shape."""
    at_rest = shown()
    yield from keys("TAB", at=window.middle())
    yield from until(lambda: bpy.data.objects[name].mode == "EDIT")
    choose()
    yield from keys("G", "Z", height, at=window.middle())
    on_the_way = shown()
    yield from keys("RET")
    posed = shown()
    window.screenshot("3-edit-mode")
    with claim("the mesh follows edits of a cage and a lattice while they happen"):
        near(posed, on_the_way, FLOAT32)
        off = np.abs(posed - at_rest)
        assert off[at_rest[:, 0] < far].max() < 0.25 * off.max()
    with claim("undo and redo in Edit Mode of a cage and a lattice take the mesh along"):
        for step, shape in (("ctrl Z", at_rest), ("ctrl shift Z", posed), ("TAB", posed)):
            yield from keys(step)
            yield from until(lambda shape=shape: moved(shape) < 1e-6, 10.0)
            near(shown(), shape, FLOAT32)
        yield from until(lambda: bpy.data.objects[name].mode == "OBJECT")
        near(shown(), posed, FLOAT32)
    return posed


def cage() -> Iterator[None]:
    """An automatic cage, with other coordinates, its weights drawn."""
    only_head().modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.shade_smooth()
    yield from open_sidebar()
    with window.in_view():
        bpy.ops.view3d.view_selected()
    window.button("cage_add", faces=200)
    yield from until(lambda: deformer() is not None and deformer().is_bound)
    made, name = deformer().cage, deformer().cage.name
    with claim("the cage is made and waits to be edited"):
        assert 150 <= len(made.data.polygons) <= 250
        assert bpy.context.view_layer.objects.active == made
        assert made.display_type == "WIRE"
        assert is_well(), deformer().status
    at_rest = shown()
    yield from rest()
    window.screenshot("2-cage")
    choose = lambda: select(bpy.data.objects[name], lambda point: point.x > 0.75)  # noqa: E731
    posed = yield from pull(name, choose, ".5", far=-1.0)
    with claim("the mesh moves as far as the cage"):
        assert abs(apart(posed, at_rest) - 0.5) < 0.2
    deformer().method = "green"
    yield from until(lambda: is_well() and moved(posed) > 1e-4)
    settings = bpy.context.scene.sinew
    settings.overlay = "CAGE"
    for name, settings.show_overlay in (("5-weights", True), ("6-plain", False)):
        yield from rest(4)
        window.screenshot(name)
    with claim("weights are drawn over the mesh"):
        above(window.differing("5-weights", "6-plain"), 0.05)


def lattice() -> Iterator[None]:
    yield from head_from_front(1)
    window.viewport().spaces.active.shading.type = "SOLID"
    at_rest = shown()
    window.button("lattice_add", resolution=(4, 4, 4))
    yield from until(lambda: deformer() is not None and deformer().is_bound)
    name = deformer().controls[0].object.name
    with claim("the lattice fits and waits to be edited"):
        assert len(bpy.data.objects[name].data.points) == 64
        assert bpy.context.view_layer.objects.active.name == name
        assert is_well(), deformer().status
        near(shown(), at_rest, FLOAT32)
    yield from rest()

    def choose() -> None:
        with window.in_view():
            bpy.ops.lattice.select_all(action="DESELECT")
        for point in bpy.data.objects[name].data.points:
            point.select = point.co_deform.x > 0.3 and point.co_deform.z > 0.3

    posed = yield from pull(name, choose, ".8", far=-1.2)
    with claim("the mesh moves less than the corner of the lattice"):
        assert 0.05 < apart(posed, at_rest) < 0.9


def surface() -> Iterator[None]:
    """The nose dragged by an inverse lattice, an ear with its image, a typed number, Esc and undo."""
    yield from head_from_front(1)
    head().select_set(True)
    with window.in_view():
        bpy.ops.sinew.deformer_add(method="inverse_ffd")
        bpy.ops.wm.tool_set_by_id(name="sinew.drag")
    deformer().use_mirror_x = True
    bpy.ops.ed.undo_push(message="Deformer")
    yield from rest()
    at_rest, unit = shown(), window.units_per_pixel()

    def pull_from(point: tuple[float, float, float], right: int, up: int) -> Iterator[None]:
        x, y = window.on_screen(point)
        yield from hold([(x, y), *between((x, y), (x + right, y + up))])

    def handles() -> list[str]:
        return sorted(handle.name for handle in deformer().handles)

    yield from pull_from(NOSE, 0, -60)
    yield from release()
    nose = shown()
    with claim("the surface is dragged at the very place"):
        assert handles() == ["Point"]
        assert not head().vertex_groups
        assert is_well()
        height = deformer().handles[0].control.matrix_world.translation.z
        assert abs(height - NOSE[2] + 60 * unit) < 2.0 * unit, height
        above(apart(nose, at_rest), 0.2)
    yield from pull_from(EAR, 20, 50)
    yield from rest()
    window.screenshot("5-ears")
    yield from keys("X")
    press("NUMPAD_PERIOD", ".")
    yield from keys("3")
    yield from release()
    ears = shown()
    with claim("the other side follows also a typed number"):
        assert handles() == ["Point", "Point.L", "Point.R"]
        left, right = (row.control.matrix_world.translation for row in list(deformer().handles)[1:3])
        assert (left * Vector((-1, 1, 1)) - right).length < 1e-5
        above(apart(ears, nose), 0.1)
    with claim("a drag by a lattice is one step of undo"):
        yield from undo()
        assert handles() == ["Point"]
        near(shown(), nose, FLOAT32)


def raise_from(place: window.Place, up: int) -> Iterator[None]:
    yield from keys("G", at=place)
    yield from keys("LEFTMOUSE", at=(place[0], place[1] + up))
    yield


def wires() -> Iterator[None]:
    """Select edges in Edit Mode, Add Wire, and move the wire with G; then draw another one."""
    yield from head_from_front(2)
    before = shown()
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(head().data)
    for edge in edit.edges:
        edge.select_set(False)
    max(edit.verts, key=lambda vertex: vertex.co.z).link_edges[0].select_set(True)
    bmesh.update_edit_mesh(head().data)
    with window.in_view():
        bpy.ops.mesh.loop_multi_select(ring=False)
    yield from rest(3)
    window.button("wire_add")
    yield from rest(3)
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from rest(3)
    bpy.ops.ed.undo_push(message="Wire")
    yield from radius_by_its_arrow()
    wire = deformer().controls[0].object
    with claim("edges become a wire that G moves, and undo puts it back"):
        assert len(wire.data.splines) == 1
        assert "1 wire" in deformer().status
        for other in bpy.context.selected_objects:
            other.select_set(False)
        wire.select_set(True)
        bpy.context.view_layer.objects.active = wire
        yield from raise_from(window.on_screen((0.0, 0.0, 0.5)), 60)
        above(moved(before), 0.1)
        yield from undo()
        near(shown(), before, FLOAT32)
    yield from wire_by_stroke()


def radius_by_its_arrow() -> Iterator[None]:
    """The mesh is active, and the tool is Move."""
    with window.in_view():
        bpy.ops.wm.tool_set_by_id(name="builtin.move")
    yield from rest(3)
    row, depsgraph = deformer().controls[0], bpy.context.evaluated_depsgraph_get()
    place, direction = inner.reach_drag.reach_of(row, depsgraph).measured["radius"]
    before = row.radius

    def tip(radius: float) -> window.Place:
        return window.on_screen(
            deformer().controls[0].object.matrix_world @ Vector(place + radius * direction)
        )

    start, end = tip(before), tip(2.0 * before)
    move(*start)
    yield from rest(4)
    with claim("an arrow changes the radius of a wire, as one step of undo"):
        yield from drag(start, end)
        assert abs(deformer().controls[0].radius / before - 2.0) < 0.1
        yield from undo()
        assert abs(deformer().controls[0].radius - before) < FLOAT32


def wire_by_stroke() -> Iterator[None]:
    """Draw a brow beside the first wire, and pull the middle of the curve up in its Edit Mode."""
    bpy.context.view_layer.objects.active = head()
    before = shown()
    count = 0 if deformer() is None else len(deformer().controls)  # the undo may have taken the first
    move(*window.on_screen((0.0, 0.0, 0.0)))
    yield from rest()
    window.button("wire_draw")
    yield from rest()
    yield from stroke(((9.0, 9.0), (9.1, 9.1)))  # beside the head: nothing
    yield from stroke(BROW)
    rows = deformer().controls
    wire = rows[-1].object
    with claim("a stroke on the surface becomes a wire that is posed in its Edit Mode"):
        points = wire.data.splines[0].bezier_points
        assert (len(rows) - count, len(points)) == (1, 6)
        length = np.linalg.norm(np.diff(np.array(BROW), axis=0), axis=1).sum()
        assert 0.3 < rows[-1].radius / length < 0.5  # on the surface the brow is longer than on the screen
        near(shown(), before, FLOAT32)
        bpy.context.view_layer.objects.active = wire
        bpy.ops.object.mode_set(mode="EDIT")
        for index, point in enumerate(wire.data.splines[0].bezier_points):
            point.select_control_point = point.select_left_handle = point.select_right_handle = index == 2
        yield from rest()
        yield from raise_from(window.on_screen((-0.6, 0.0, 0.8)), 45)
        above(moved(before), 0.05)


def vector_field() -> Iterator[None]:
    """Drag the nose along a bent path, then undo, drag again, and escape."""
    yield from head_from_front(2)
    before = shown()

    def start(x: float) -> Iterator[None]:
        move(*window.on_screen((x, 0.0, -0.1)))
        yield from rest()
        window.button("tool_drag")
        yield from rest()

    yield from start(0.0)
    yield from keys("WHEELUPMOUSE", at=window.on_screen((0.02, 0.0, -0.1)))
    yield from stroke(ASIDE)
    after, row = shown(), deformer().controls[0]
    with claim("a drag of a vector field stores its path"):
        assert len(row.rest.vertices) // 4 - 1 >= 3
        reach = row.outer / np.ptp(before, axis=0).max()
        assert abs(reach * 3.0 * 1.1 - 1.0) < 0.03, reach  # a click of the wheel smaller
        above(apart(after, before), 0.5)
        assert "1 tool" in deformer().status
        row.progress = 0.5
        yield from rest(3)
        above(min(moved(before), moved(after)), 0.1)
        row.progress = 1.0
        yield from rest(3)
        near(shown(), after, FLOAT32)
    with claim("undo and Esc leave nothing of a drag of a vector field"):
        yield from undo()
        assert not head().sinew.deformers
        near(shown(), before, FLOAT32)
        window.button("drag_start", mode="CLAY")
        yield from rest()
        yield from hold(polyline(ASIDE)[:10])
        above(moved(before), 0.05)
        yield from keys("ESC")
        yield from release()
        assert not head().sinew.deformers
        assert [obj.name for obj in bpy.data.objects if obj.type == "EMPTY"] == []
        near(shown(), before, FLOAT32)


run(cage, lattice, surface, wires, vector_field)
