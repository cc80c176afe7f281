# SPDX-License-Identifier: GPL-3.0-or-later
"""A pillar that sways: three frames of its animation, each as it enters and edited at a key in the middle."""

from __future__ import annotations

from math import radians

import bpy
from mathutils import Matrix, Vector

from . import markers, materials, posing, studio
from .models import pillar

FIRST, KEY, LAST = 1, 24, 48
SHOWN = (12, KEY, 38)  # before the key, at it and after it
SPACING = 1.75
EDIT = Matrix.Translation((0.25, 0.0, -0.35)) @ Matrix.Rotation(radians(75.0), 4, "Y")


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Mesh Sequence")
    scene.frame_start, scene.frame_end = FIRST, LAST
    live = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    live.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    _sway(live)
    scene.frame_set(FIRST)
    posing.add_deformer(live, "mesh_sequence")
    head = posing.add_region(live, "HANDLE", "Head")
    posing.add_region(live, "FIXED", "Foot")
    place = live.matrix_world
    markers.add_pin(head.control, place @ Vector((0, 0, 2.25)), 0.06, place @ Vector((0, 0, 2.0)))
    _key(live, head.control)
    posing.check_posed(live, FIRST, KEY)

    places = [(k - 2.5) * SPACING for k in range(6)]
    for k, frame in enumerate(SHOWN):
        _show(live, frame, False, places[2 * k], f"Frame {frame}")
        _show(live, frame, True, places[2 * k + 1], "Edited" + (" at its key" if frame == KEY else ""))
    live.location.y = 6.0  # behind what the picture shows, to play with
    for obj in (live, *head.control.children):
        obj.hide_render = True

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.2, 0.0, 0.92), distance=26.0, elevation=10.0, width=11.4)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for obj in [obj for obj in scene.objects if "label" in obj]:
        studio.add_label(scene, obj["label"], (obj.location.x, -1.0, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1600, height=380)
    studio.open_at(scene, KEY, live)
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


def _show(obj: bpy.types.Object, frame: int, edited: bool, x: float, label: str) -> None:
    """Leave a copy of what a frame shows."""
    obj.modifiers[-1].show_viewport = edited
    bpy.context.scene.frame_set(frame)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    obj.modifiers[-1].show_viewport = True
    shown = bpy.data.objects.new(f"Frame {frame}{' edited' if edited else ''}", mesh)
    shown.location.x = x
    shown["label"] = label
    bpy.context.scene.collection.objects.link(shown)
