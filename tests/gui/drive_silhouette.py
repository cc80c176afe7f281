# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: the outline of an ear is drawn anew."""

from itertools import pairwise

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    Place,
    apart,
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

FRONT = (0.7071068, 0.7071068, 0.0, 0.0)
# From below the ear around it to above, as seen from the front: an ear that is larger and ends in a point.
STROKE = ((1.3, -0.25), (1.75, -0.1), (2.2, 0.2), (2.65, 0.75), (2.1, 0.85), (1.6, 0.85), (1.2, 0.75))

ELEMENT = {  # of a stroke, as Blender wants it whole
    "name": "",
    "mouse": (0.0, 0.0),
    "mouse_event": (0.0, 0.0),
    "pen_flip": False,
    "is_start": False,
    "pressure": 1.0,
    "size": 1.0,
    "time": 0.0,
    "x_tilt": 0.0,
    "y_tilt": 0.0,
}


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def keys() -> list[str]:
    found = head().data.shape_keys
    return [] if found is None else [key.name for key in found.key_blocks]


def on_screen(x: float, z: float) -> Place:
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, Vector((x, 0.0, z)))
    return int(region().x + pixel.x), int(region().y + pixel.y)


def prepare():
    """A head from the front."""
    enable()
    new_head(2, {})
    view = viewport().spaces.active.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = (0.0, 0.0, 0.0), 9.0
    bpy.ops.ed.undo_push(message="Head")
    yield from rest()


def start():
    move(*on_screen(0.0, 0.0))
    yield from rest()
    with in_view():
        bpy.ops.sinew.silhouette_sketch("INVOKE_DEFAULT")
    yield from rest()


def draw_stroke(places, picture: str = ""):
    """Hold the button along a polyline."""
    corners = np.array(places)
    ways = [np.linspace(a, b, 5, endpoint=False) for a, b in pairwise(corners)]
    way = [on_screen(*point) for point in np.concatenate([*ways, corners[-1:]])]
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


def journey():
    yield from prepare()
    before = shown_points(head())
    screenshot("silhouette-1-before")
    yield from start()
    yield from draw_stroke(STROKE, "silhouette-2-drawn")
    drawn = shown_points(head())
    seen["drawn"] = [keys(), apart(drawn, before)]
    screenshot("silhouette-3-follows")
    press("WHEELDOWNMOUSE")
    yield from rest()
    wider = shown_points(head())
    seen["wider"] = [int((np.abs(shape - before).max(axis=1) > 1e-6).sum()) for shape in (drawn, wider)]
    press("RET")
    yield from rest(3)
    screenshot("silhouette-4-kept")
    kept = shown_points(head())
    seen["kept"] = [keys(), apart(kept, wider)]
    seen["tip"] = [float(shape[:, 0].max()) for shape in (before, kept)]
    seen["other side moved"] = bool((np.abs(kept - before).max(axis=1) > 1e-6)[before[:, 0] < 0.0].any())
    last = bpy.context.window_manager.operators[-1]
    seen["last"] = last.bl_idname
    repeated = {name: getattr(last, name) for name in ("reach", "unlimited", "sharpness", "perspective")}
    repeated["view"] = [tuple(row) for row in last.view]
    places = [{**ELEMENT, "location": tuple(point.location)} for point in last.points]
    for name, shape in (("undone", before), ("redone", kept), ("undone again", before)):
        press("Z", ctrl=True, shift=name == "redone")
        yield from rest(3)
        seen[name] = [keys(), apart(shown_points(head()), shape)]
    bpy.ops.sinew.silhouette_sketch("EXEC_DEFAULT", True, points=places, **repeated)
    yield from rest(3)
    seen["repeated"] = [keys(), apart(shown_points(head()), kept)]
    press("Z", ctrl=True)
    yield from rest(3)
    yield from start()
    yield from draw_stroke([(x + 9.0, z) for x, z in STROKE[:1]] + [(-2.4, 1.9), (-2.0, 2.1)])
    seen["elsewhere"] = keys()
    yield from draw_stroke(STROKE)
    seen["before escape"] = keys()
    press("ESC")
    yield from rest(3)
    seen["given up"] = [keys(), apart(shown_points(head()), before)]


play(journey())
