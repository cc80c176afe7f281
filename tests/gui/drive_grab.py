# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: Grab Region by mouse and keyboard, beside Blender's own transforms.

Steps are a generator; each ``yield`` gives Blender the time a person would take. Observations and screenshots
go to the folder named after ``--``.
"""

import bmesh
import bpy
import numpy as np
from driving import enable, in_view, move, play, press, region, screenshot, seen, select, viewport
from mathutils import Quaternion

SEQUENCES = {  # keys, and moves of the mouse in pixels; a leading + holds Shift
    "free": ["G", (60, 40)],
    "axis": ["G", "X", (60, 40)],
    "local": ["G", "Z", "Z", (60, 40)],
    "plane": ["G", "+X", (60, 40)],
    "sight": ["G", "Y", (30, 40)],
    "typed": ["G", "ONE", "MINUS", "TAB", "TWO"],
    "turn": ["R", (-90, 120)],
    "turn x": ["R", "X", "NINE", "ZERO"],
    "turn z": ["R", "Z", (-90, 120)],
    "size": ["S", (70, 20)],
    "size plane": ["S", "+Z", "TWO"],
    "switched": ["G", "Z", (60, 40), "R", (-90, 120)],
}
SLANTED = (0.75, 0.55, 0.2, 0.3)  # a view from the front, the right and above


def home() -> tuple[int, int]:
    """Right of the selection."""
    view = region()
    return view.x + view.width // 2 + 190, view.y + view.height // 2 + 60


def mesh():
    return bmesh.from_edit_mesh(bpy.data.objects["Head"].data)


def points() -> np.ndarray:
    return np.array([vertex.co[:] for vertex in mesh().verts], dtype=np.float32)


def chosen() -> list[int]:
    return [vertex.index for vertex in mesh().verts if vertex.select]


def prepare() -> None:
    """A head of 7,958 vertices in Edit Mode, turned a little, the tip of an ear selected."""
    enable()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_monkey_add(size=3.0)
    obj = bpy.context.object
    obj.name = "Head"
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.object.shade_smooth()
    obj.rotation_euler = (0.1, 0.2, 0.1)
    space = viewport().spaces.active
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = (0.7071068, 0.7071068, 0.0, 0.0)
    space.region_3d.view_location = (0.3, 0.0, 0.2)
    space.region_3d.view_distance = 7.0
    with in_view():
        bpy.ops.object.mode_set(mode="EDIT")
    select(obj, lambda point: point.x > 1.75)
    with in_view():
        bpy.ops.mesh.select_mode(type="FACE")


def start(key: str) -> None:
    mode = {"G": "TRANSLATE", "R": "ROTATE", "S": "RESIZE"}[key]
    with in_view():
        bpy.ops.sinew.grab_region("INVOKE_DEFAULT", mode=mode, radius=0.8)


def perform(sequence: list) -> None:
    x, y = home()
    for step in sequence:
        if isinstance(step, tuple):
            move(x + step[0], y + step[1])
        else:
            press(step.lstrip("+"), shift=step.startswith("+"))


def motion(rest: np.ndarray) -> list:
    """The affine map of the selection, by least squares."""
    members = chosen()
    before = np.column_stack((rest[members].astype(float), np.ones(len(members))))
    return np.linalg.lstsq(before, points()[members].astype(float), rcond=None)[0].T.tolist()


def compared(rest: np.ndarray, prefix: str, names: list[str]):
    """The same events to Blender's transform and to ours."""
    move(*home())
    yield
    for name in names:
        both = []
        for ours in (False, True):
            if ours:
                start(SEQUENCES[name][0])
            else:
                press(SEQUENCES[name][0])
            perform(SEQUENCES[name][1:])
            yield
            both.append(motion(rest))
            press("ESC")
            move(*home())
            yield
        seen[f"{prefix}{name}"] = both
        if not np.array_equal(points(), rest):
            seen["not restored"] = [*seen.get("not restored", []), prefix + name]


def journey():
    prepare()
    yield
    yield
    rest, members = points(), chosen()
    bpy.ops.ed.undo_push(message="Select")
    yield
    move(*home())
    press("Y", alt=True)
    yield
    for step in (1, 2):
        move(home()[0] + 40 * step, home()[1] + 30 * step)
        yield
    seen["dragged"] = float(np.abs(points() - rest).max())
    screenshot("1-dragged")
    yield
    press("X")
    yield
    for key in ("ZERO", "PERIOD", "FIVE"):
        press(key)
    yield
    yield
    screenshot("2-typed")
    yield
    press("RET")
    yield
    yield
    world = np.array(bpy.data.objects["Head"].matrix_world)[:3, :3]
    moved = (points() - rest).astype(float) @ world.T
    seen["typed along x"] = float(np.abs(moved[members] - (0.5, 0.0, 0.0)).max())
    seen["followed"] = int(((points() != rest).any(axis=1)).sum()) - len(members)
    last = bpy.context.window_manager.operators[-1]
    seen["last"] = [last.bl_idname, last.mode, [round(number, 5) for number in last.value]]
    move(home()[0], home()[1] + 10)
    yield
    screenshot("3-confirmed")
    press("Z", ctrl=True)
    yield
    yield
    seen["undone"] = float(np.abs(points() - rest).max())
    members, flags = chosen(), [face.select for face in mesh().faces]
    move(*home())
    start("R")
    yield
    for step in (1, 2):
        move(home()[0] - 40 * step, home()[1] + 50 * step)
        yield
    for _ in range(4):
        press("WHEELDOWNMOUSE")
    yield
    yield
    screenshot("4-turned")
    yield
    press("ESC")
    yield
    seen["restored"] = points().tobytes() == rest.tobytes()
    seen["selection kept"] = chosen() == members and [face.select for face in mesh().faces] == flags
    yield from compared(rest, "", list(SEQUENCES))
    view = viewport().spaces.active.region_3d
    view.view_rotation = Quaternion(SLANTED).normalized()
    yield
    yield from compared(rest, "slanted ", ["axis", "plane", "turn z"])
    view.view_perspective = "PERSP"
    yield
    yield
    yield from compared(rest, "perspective ", ["free", "axis"])


play(journey(), pause=0.25)
