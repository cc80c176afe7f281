# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: one ear dragged by mouse and keys, while the other one follows, or
another rig.
"""

import bpy
import numpy as np
from driving import (
    enable,
    in_view,
    middle,
    move,
    new_head,
    open_tab,
    play,
    press,
    rest,
    screenshot,
    seen,
    shown_points,
    viewport,
)

FRONT = (0.7071, 0.7071, 0.0, 0.0)
REGIONS = {
    "Ear": ("HANDLE", lambda point: point.x > 1.6),
    "Back": ("FIXED", lambda point: point.y > 0.35 and abs(point.x) < 1.2),
}


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def deformer():
    return head().sinew.active


def ear(side: str) -> bpy.types.Object:
    return next(handle.control for handle in deformer().handles if handle.name == f"Ear.{side}")


def places() -> list[list[float]]:
    """Of the left and the right control."""
    return [list(ear(side).location) for side in "LR"]


def uneven() -> float:
    """How far the shown ears are from each other's mirror images."""
    base = np.round([vertex.co for vertex in head().data.vertices], 4) + 0.0
    where = {tuple(place): index for index, place in enumerate(base)}
    flip = np.array((-1.0, 1.0, 1.0))
    images = [where.get(tuple(place * flip + 0.0), -1) for place in base]
    paired = np.array([index >= 0 for index in images]) & (np.abs(base[:, 0]) > 1.65)
    points = shown_points(head())
    return float(np.abs(points[paired] - points[np.array(images)[paired]] * flip).max())


def prepare():
    """A head whose left ear is a handle without a side in its name; Mirror makes the right one."""
    enable()
    new_head(1, REGIONS)
    deformer().active_handle = 0
    bpy.ops.sinew.handle_mirror(tolerance=0.01)
    seen["names"] = [handle.name for handle in deformer().handles]
    view = viewport().spaces.active.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = (0.0, 0.0, 0.0), 9.0
    viewport().spaces.active.show_region_ui = True
    yield from rest()
    yield from open_tab()
    deformer().use_mirror_x = True
    choose("L")
    bpy.ops.ed.undo_push(message="X-Axis Mirror")
    yield from rest()


def choose(side: str) -> None:
    with in_view():
        bpy.ops.object.select_all(action="DESELECT")
    ear(side).select_set(True)
    bpy.context.view_layer.objects.active = ear(side)


def grab(steps: int = 4):
    """G, and the mouse goes up and aside."""
    x, y = middle()
    move(x, y)
    yield
    press("G")
    yield
    found = []
    for step in range(1, steps + 1):
        move(x + 6 * step, y + 12 * step)
        yield from rest()
        found.append([*places(), uneven()])
    seen["steps"] = found


def drag():
    yield from grab()
    press("LEFTMOUSE")
    yield from rest()
    seen["dragged"] = [*places(), uneven()]
    screenshot("1-dragged")
    press("Z", ctrl=True)
    yield from rest()
    seen["undone"] = [*places(), uneven()]
    press("Z", ctrl=True, shift=True)
    yield from rest()
    seen["redone"] = [*places(), uneven()]


def clear():
    """Alt+G, for which Blender takes its step of undo before the other side follows; another step; undo."""
    choose("L")
    bpy.ops.ed.undo_push(message="Select")
    move(*middle())
    yield
    press("G", alt=True)
    yield from rest()
    seen["cleared"] = places()
    choose("R")
    ear("R").rotation_euler.x = 0.25
    ear("L").rotation_euler.x = 0.25
    yield from rest()
    bpy.ops.ed.undo_push(message="Turn")
    yield from rest()
    press("Z", ctrl=True)
    yield from rest()
    seen["cleared again"] = places()
    press("Z", ctrl=True)
    yield from rest()
    seen["before it was cleared"] = places()


def cancel():
    """The right ear is posed by itself; a drag of the left one takes it along, and Esc gives both back."""
    deformer().use_mirror_x = False
    yield from rest()
    ear("R").location.z += 0.5
    yield from rest()
    deformer().use_mirror_x = True
    choose("L")
    bpy.ops.ed.undo_push(message="Pose")
    yield from rest()
    before = places()
    yield from grab()
    seen["taken along"] = [before, places()]
    press("ESC")
    yield from rest()
    seen["cancelled"] = [before, places()]


def typed():
    """G Z 1 Enter."""
    move(*middle())
    yield
    for key in ("G", "Z", "ONE"):
        press(key)
        yield
    press("RET")
    yield from rest()
    seen["typed"] = [*places(), uneven()]
    screenshot("2-typed")


def keys() -> list[dict[str, list[float]]]:
    """The frames and values of the keyframes of the left and the right control, by channel."""
    found = []
    for side in "LR":
        animation = ear(side).animation_data
        curves = [] if animation is None or animation.action is None else animation.action.fcurves
        found.append(
            {
                f"{curve.data_path} {curve.array_index}": [tuple(point.co) for point in curve.keyframe_points]
                for curve in curves
            }
        )
    return found


def keyed():
    """I, and Location in its menu: as it is, then moved on another frame, then moved again on that frame."""
    found = seen["keyed"] = []
    for frame, key in ((1, ""), (11, "ONE"), (11, "TWO")):
        bpy.context.scene.frame_set(frame)
        choose("L")
        yield from rest()
        move(*middle())
        yield
        for name in ("G", "Z", key, "RET") if key else ():
            press(name)
            yield
        yield from rest()
        press("I")
        yield from rest()
        press("L")
        yield from rest()
        found.append(keys())
    screenshot("3-keyed")
    for side in "LR":
        ear(side).animation_data_clear()


def chain():
    """A flag whose control is a child of a vertex of the ear that is dragged."""
    deformer().use_mirror_x = False
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, location=(2.0, 0.0, 1.5))
    flag = bpy.context.object
    ends = {"Mast": ("FIXED", -1.0), "Tip": ("HANDLE", 1.0)}
    for name, (kind, side) in ends.items():
        members = [vertex.index for vertex in flag.data.vertices if vertex.co.x == side]
        flag.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
        bpy.context.view_layer.objects.active = flag
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=name)
    control = flag.sinew.active.handles[1].control
    rested = np.array(control.matrix_world.translation)
    base = np.array([vertex.co for vertex in flag.data.vertices])[members]
    vertex = max(head().data.vertices, key=lambda one: one.co.x).index
    control.parent, control.parent_type, control.parent_vertices = head(), "VERTEX", (vertex, 0, 0)
    control.location = (0.0, 0.0, 0.0)
    choose("L")
    yield from rest(4)

    def apart_now() -> list[float]:
        """The height of the vertex; how far from it the control is, and from that the tip of the flag."""
        carrier = shown_points(head())[vertex]
        place = np.array(control.matrix_world.translation)
        tip = shown_points(flag)[members] - base - (place - rested)
        return [float(carrier[2]), float(np.abs(place - carrier).max()), float(np.abs(tip).max())]

    found = seen["ridden"] = [apart_now()]
    x, y = middle()
    move(x, y)
    yield
    press("G")
    yield
    for step in range(1, 5):
        move(x + 6 * step, y - 12 * step)
        yield from rest()
        found.append(apart_now())
    press("LEFTMOUSE")
    yield from rest()
    found.append(apart_now())
    screenshot("4-ridden")


def journey():
    viewport().spaces.active.show_region_hud = False
    yield from prepare()
    yield from drag()
    yield from clear()
    yield from cancel()
    yield from typed()
    yield from keyed()
    yield from chain()


play(journey())
