# SPDX-License-Identifier: GPL-3.0-or-later
"""A pillar that sways: three frames of its animation, each as it enters and edited at a key in the middle."""

from math import radians

import bpy
from mathutils import Matrix, Vector

from .. import markers, posing
from ..models import pillar
from ..studio import Shot, empty_scene, open_at

FIRST, KEY, LAST = 1, 24, 48
SHOWN = (12, KEY, 38)  # before the key, at it and after it
EDIT = Matrix.Translation((0.25, 0.0, -0.35)) @ Matrix.Rotation(radians(75.0), 4, "Y")
SHOT = Shot((0.2, 0.0, 0.92), 11.4, distance=26.0, picture=(1600, 380))


def make() -> bpy.types.Scene:
    scene = empty_scene()
    scene.frame_start, scene.frame_end = FIRST, LAST
    live = pillar.build()
    sway = live.modifiers.new("Sway", "SIMPLE_DEFORM")  # Blender's own animation, from side to side
    sway.deform_method, sway.deform_axis = "BEND", "Y"
    posing.key(sway, "angle", {FIRST: radians(-35.0), LAST: radians(35.0)})
    scene.frame_set(FIRST)
    posing.add_deformer(live, "mesh_sequence")
    control = posing.add_region(live, "HANDLE", "Head").control
    posing.add_region(live, "FIXED", "Foot")
    place = live.matrix_world
    markers.add_pin(control, place @ Vector((0, 0, 2.25)), 0.06, place @ Vector((0, 0, 2.0)))
    for frame in (FIRST, LAST, KEY):
        scene.frame_set(frame)
        if frame == KEY:
            centre = Matrix.Translation(control.matrix_world.translation)
            control.matrix_world = centre @ EDIT @ centre.inverted() @ control.matrix_world
        posing.operate(live, "key_add", blank=frame != KEY)
    posing.check_posed(live, FIRST, KEY)

    labels = []
    for number, x in enumerate(posing.places(2 * len(SHOWN), 1.75)):
        frame, edited = SHOWN[number // 2], number % 2 == 1
        _show(live, frame, edited, x)
        how = "Edited at its key" if frame == KEY else "Edited"
        labels.append((how if edited else f"Frame {frame}", x))
    live.location.y = 6.0  # behind what the picture shows, to play with
    for obj in (live, *control.children):
        obj.hide_render = True
    SHOT.set_up(scene, labels)
    open_at(scene, KEY, live)
    return scene


def _show(obj: bpy.types.Object, frame: int, edited: bool, x: float) -> None:
    """Leave a copy of what a frame shows."""
    obj.modifiers[-1].show_viewport = edited
    bpy.context.scene.frame_set(frame)
    shown = posing.add_object(f"Frame {frame}{' edited' if edited else ''}", posing.shown_mesh(obj))
    obj.modifiers[-1].show_viewport = True
    shown.location.x = x
