# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: a lattice, posed in Edit Mode by keys; then the surface, dragged."""

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    Place,
    apart,
    enable,
    in_view,
    middle,
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
    until,
    viewport,
    window,
    write,
)
from mathutils import Vector

FRONT = (0.7071, 0.7071, 0.0, 0.0)
NOSE = (0.0, 0.0, -0.3)  # as seen from the front
EAR = (1.7, 0.0, 0.35)


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def moved(before: np.ndarray) -> float:
    return apart(shown_points(head()), before)


def on_screen(point: tuple[float, float, float]) -> Place:
    """Where a point of the head is in the window."""
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, Vector(point))
    return int(region().x + pixel.x), int(region().y + pixel.y)


def prepare():
    """A head from the front."""
    enable()
    new_head(1, {})
    view = viewport().spaces.active
    view.region_3d.view_perspective, view.region_3d.view_rotation = "ORTHO", FRONT
    view.region_3d.view_location, view.region_3d.view_distance = (0.0, 0.0, 0.0), 9.0
    view.show_region_ui = True
    view.shading.type = "SOLID"
    bpy.ops.ed.undo_push(message="Head")
    yield from rest()
    yield from open_tab()
    yield from rest()


def lattice():
    """Add Lattice, a corner pulled in Edit Mode, undo and redo."""
    at_rest = shown_points(head())
    screenshot("1-start")
    with in_view():
        bpy.ops.sinew.lattice_add("INVOKE_DEFAULT", resolution=(4, 4, 4))
    yield from until(lambda: head().sinew.active is not None and head().sinew.active.is_bound)
    deformer = head().sinew.active
    box = deformer.controls[0].object
    name = box.name
    seen["lattice"] = {
        "points": len(box.data.points),
        "active": bpy.context.view_layer.objects.active == box,
        "level": deformer.status_level,
        "status": deformer.status,
        "moved": moved(at_rest),
    }
    yield from rest()
    screenshot("2-lattice")
    move(*middle())
    yield
    press("TAB")
    yield from until(lambda: box.mode == "EDIT")
    with in_view():
        bpy.ops.lattice.select_all(action="DESELECT")
    for point in bpy.data.objects[name].data.points:
        point.select = point.co_deform.x > 0.3 and point.co_deform.z > 0.3
    seen["selected"] = sum(point.select for point in bpy.data.objects[name].data.points)
    yield from rest()
    move(*middle())
    yield
    press("G")
    yield
    press("Z")
    write(".8")
    yield from rest()
    seen["while moving"] = moved(at_rest)
    press("RET")
    yield from rest()
    posed = shown_points(head())
    seen["posed"] = moved(at_rest)
    seen["far side"] = float(np.abs(posed - at_rest)[at_rest[:, 0] < -1.2].max())
    screenshot("3-edit-mode")
    press("Z", ctrl=True)
    yield from until(lambda: moved(at_rest) < 1e-6, 10.0)
    seen["undone"] = moved(at_rest)
    press("Z", ctrl=True, shift=True)
    yield from until(lambda: moved(posed) < 1e-6, 10.0)
    seen["redone"] = moved(posed)
    press("TAB")
    yield from until(lambda: bpy.data.objects[name].mode == "OBJECT")
    seen["left edit mode"] = moved(posed)


def hold(start: Place, end: Place):
    """Press and drag, without releasing."""
    move(*start)
    yield from rest()
    window().event_simulate("LEFTMOUSE", "PRESS", x=start[0], y=start[1])
    yield
    for step in range(1, 4):
        move(*(a + (b - a) * step // 3 for a, b in zip(start, end, strict=True)))
        yield


def release(end: Place) -> None:
    window().event_simulate("LEFTMOUSE", "RELEASE", x=end[0], y=end[1])


def handles() -> list[str]:
    return [handle.name for handle in head().sinew.active.handles]


def surface():
    """The nose dragged by an inverse lattice, an ear with its image, a typed number, Esc and undo."""
    new_head(1, {})
    bpy.context.view_layer.objects.active = head()
    head().select_set(True)
    with in_view():
        bpy.ops.sinew.deformer_add(method="inverse_ffd")
        bpy.ops.wm.tool_set_by_id(name="sinew.drag")
    head().sinew.active.use_mirror_x = True
    bpy.ops.ed.undo_push(message="Head")
    yield from rest()
    at_rest = shown_points(head())
    pixel = 1.0 / (on_screen((1.0, 0.0, 0.0))[0] - on_screen((0.0, 0.0, 0.0))[0])
    start = on_screen(NOSE)
    end = (start[0], start[1] - 60)
    yield from hold(start, end)
    screenshot("4-nose")
    release(end)
    yield from rest(3)
    control = head().sinew.active.handles[0].control
    seen["nose"] = {
        "handles": handles(),
        "groups": len(head().vertex_groups),
        "level": head().sinew.active.status_level,
        "off the mouse": abs(control.matrix_world.translation.z - NOSE[2] + 60 * pixel) / pixel,
        "moved": moved(at_rest),
    }
    nose = shown_points(head())
    start = on_screen(EAR)
    yield from hold(start, (start[0] + 20, start[1] + 50))
    yield from rest()
    screenshot("5-ears")
    for key in ("X", "NUMPAD_PERIOD"):
        press(key, "." if key != "X" else "")
    write("3")
    yield from rest()
    release(start)
    yield from rest(3)
    after = shown_points(head())
    screenshot("6-typed")
    left, right = (row.control.matrix_world.translation for row in list(head().sinew.active.handles)[1:3])
    seen["ears"] = {"handles": handles(), "uneven": float((left * Vector((-1, 1, 1)) - right).length)}
    seen["ears"]["moved"] = apart(after, nose)
    start = on_screen((-0.6, 0.0, 0.6))
    yield from hold(start, (start[0] - 40, start[1]))
    press("ESC")
    yield
    release(start)
    yield from rest(3)
    seen["given up"] = [handles(), apart(shown_points(head()), after)]
    press("Z", ctrl=True)
    yield from rest(3)
    seen["undone drag"] = [handles(), apart(shown_points(head()), nose)]


def journey():
    yield from prepare()
    yield from lattice()
    yield from surface()


play(journey())
