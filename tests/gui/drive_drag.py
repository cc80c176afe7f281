# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: an ear is dragged on the surface by the tool of the toolbar."""

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    Place,
    apart,
    drag,
    enable,
    in_view,
    move,
    new_head,
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

FRONT = (0.7071, 0.7071, 0.0, 0.0)
EAR, NOSE = (1.7, 0.0, 0.35), (0.0, 0.0, -0.3)  # as seen from the front


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def on_screen(point: tuple[float, float, float]) -> Place:
    """Where a point of the head is in the window."""
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, Vector(point))
    return int(region().x + pixel.x), int(region().y + pixel.y)


def left_behind() -> list:
    """What a drag makes."""
    obj = head()
    rows = [(row.kind, row.name) for deformer in obj.sinew.deformers for row in deformer.handles]
    empties = sorted(other.name for other in bpy.data.objects if other.type == "EMPTY")
    return [rows, [group.name for group in obj.vertex_groups], len(obj.modifiers), empties]


def prepare():
    """A head from the front, and the tool."""
    enable()
    new_head(1, {})
    view = viewport().spaces.active.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = (0.0, 0.0, 0.0), 9.0
    bpy.ops.ed.undo_push(message="Head")
    with in_view():
        bpy.ops.wm.tool_set_by_id(name="sinew.drag")
    yield from rest()


def hold(start: Place, end: Place):
    """Press and drag, without releasing."""
    move(*start)
    yield from rest()
    window().event_simulate("LEFTMOUSE", "PRESS", x=start[0], y=start[1])
    yield
    for step in range(1, 4):
        move(*(a + (b - a) * step // 3 for a, b in zip(start, end, strict=True)))
        yield


def release() -> None:
    window().event_simulate("LEFTMOUSE", "RELEASE", x=end_of_drag[0], y=end_of_drag[1])


end_of_drag = [0, 0]


def pull():
    """One ear up and out, in one go, and then further by the same handle."""
    before = shown_points(head())
    seen["before"] = left_behind()
    start = on_screen(EAR)
    end = (start[0] + 50, start[1] + 70)
    move(start[0] - 2, start[1])
    yield
    move(*start)
    yield from rest(3)
    screenshot("drag-1-hover")
    yield from hold(start, end)
    end_of_drag[:] = end
    screenshot("drag-2-dragging")
    yield
    release()
    yield from rest(3)
    screenshot("drag-3-kept")
    after = shown_points(head())
    seen["kept"] = left_behind()
    pixel = 1.0 / (on_screen((1.0, 0.0, 0.0))[0] - on_screen((0.0, 0.0, 0.0))[0])
    group = head().vertex_groups["Handle"].index
    region_of = [v.index for v in head().data.vertices if any(g.group == group for g in v.groups)]
    seen["region"] = len(region_of)
    wanted = np.array((50.0, 0.0, 70.0)) * pixel
    seen["off the mouse"] = apart(after[region_of] - before[region_of], wanted) / pixel
    moved = np.abs(after - before).max(axis=1) > 1e-5
    seen["share that moved"] = float(moved.mean())
    seen["other side moved"] = bool(moved[before[:, 0] < 0.0].any())
    seen["active"] = bpy.context.view_layer.objects.active.name
    last = bpy.context.window_manager.operators[-1]
    seen["last"] = last.bl_idname
    repeated = {name: getattr(last, name) for name in ("radius", "reach", "method", "mode")}
    repeated |= {name: tuple(getattr(last, name)) for name in ("origin", "direction", "value")}
    yield from drag(end, (end[0], end[1] - 40))
    yield from rest(3)
    again = shown_points(head())
    seen["dragged again"] = left_behind()
    seen["off the mouse again"] = (
        apart(again[region_of] - after[region_of], np.array((0.0, 0.0, -40.0)) * pixel) / pixel
    )
    return before, after, again, repeated


def give_up(again: np.ndarray):
    """Esc on another place, then on the handle."""
    other = on_screen(NOSE)
    for start in (other, (end_of_drag[0], end_of_drag[1] - 40)):
        yield from hold(start, (start[0], start[1] + 60))
        seen.setdefault("while held", []).append([len(left_behind()[0]), apart(shown_points(head()), again)])
        press("ESC")
        yield
        end_of_drag[:] = start
        release()
        yield from rest(3)
        seen.setdefault("given up", []).append([left_behind(), apart(shown_points(head()), again)])


def journey():
    yield from prepare()
    before, after, again, repeated = yield from pull()
    yield from give_up(again)
    for name, shape in (("undone", after), ("all undone", before)):
        press("Z", ctrl=True)
        yield from rest(3)
        seen[name] = [left_behind(), apart(shown_points(head()), shape)]
    press("Z", ctrl=True, shift=True)
    yield from rest(3)
    seen["redone"] = [left_behind(), apart(shown_points(head()), after)]
    press("Z", ctrl=True)
    yield from rest(3)
    bpy.ops.sinew.drag(**repeated)
    yield from rest(3)
    seen["repeated"] = [left_behind(), apart(shown_points(head()), after)]


play(journey())
