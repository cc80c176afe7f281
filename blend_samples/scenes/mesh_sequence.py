# SPDX-License-Identifier: GPL-3.0-or-later
"""A pillar that sways: three frames of its animation, each as it enters and edited at a key in the middle."""

from __future__ import annotations

from math import radians

import bpy
from mathutils import Matrix, Vector

from .. import markers, posing
from ..models import pillar
from ..studio import Shot, empty_scene, open_at

FIRST, KEY, LAST = 1, 24, 48
SHOWN = (12, KEY, 38)  # before the key, at it and after it
SPACING = 1.75
EDIT = Matrix.Translation((0.25, 0.0, -0.35)) @ Matrix.Rotation(radians(75.0), 4, "Y")
SHOT = Shot((0.2, 0.0, 0.92), 11.4, distance=26.0, picture=(1600, 380))


def make() -> bpy.types.Scene:
    scene = empty_scene("Mesh Sequence")
    scene.frame_start, scene.frame_end = FIRST, LAST
    live = pillar.build()
    _sway(live)
    scene.frame_set(FIRST)
    posing.add_deformer(live, "mesh_sequence")
    head = posing.add_region(live, "HANDLE", "Head")
    posing.add_region(live, "FIXED", "Foot")
    place = live.matrix_world
    markers.add_pin(head.control, place @ Vector((0, 0, 2.25)), 0.06, place @ Vector((0, 0, 2.0)))
    _key(live, head.control)
    posing.check_posed(live, FIRST, KEY)

    labels = []
    places = iter(posing.places(2 * len(SHOWN), SPACING))
    for frame in SHOWN:
        for edited, label in (
            (False, f"Frame {frame}"),
            (True, "Edited at its key" if frame == KEY else "Edited"),
        ):
            x = next(places)
            _show(live, frame, edited, x)
            labels.append((label, x))
    live.location.y = 6.0  # behind what the picture shows, to play with
    for obj in (live, *head.control.children):
        obj.hide_render = True

    SHOT.set_up(scene, labels)
    open_at(scene, KEY, live)
    return scene


def _sway(obj: bpy.types.Object) -> None:
    """Blender's own animation: the pillar leans to one side, then to the other."""
    bend = obj.modifiers.new("Sway", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "BEND", "Y"
    for frame, angle in ((FIRST, -35.0), (LAST, 35.0)):
        bend.angle = radians(angle)
        bend.keyframe_insert("angle", frame=frame)


def _key(obj: bpy.types.Object, control: bpy.types.Object) -> None:
    scene = bpy.context.scene
    for frame in (FIRST, LAST, KEY):
        scene.frame_set(frame)
        if frame == KEY:
            centre = Matrix.Translation(control.matrix_world.translation)
            control.matrix_world = centre @ EDIT @ centre.inverted() @ control.matrix_world
        posing.make_active(obj)
        posing.expect(bpy.ops.sinew.key_add(blank=frame != KEY), f"key_add at frame {frame}")


def _show(obj: bpy.types.Object, frame: int, edited: bool, x: float) -> None:
    """Leave a copy of what a frame shows."""
    obj.modifiers[-1].show_viewport = edited
    bpy.context.scene.frame_set(frame)
    shown = posing.add_object(f"Frame {frame}{' edited' if edited else ''}", posing.shown_mesh(obj))
    obj.modifiers[-1].show_viewport = True
    shown.location.x = x
