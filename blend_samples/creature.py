# SPDX-License-Identifier: GPL-3.0-or-later
"""A dragon with three regions (head, tail, fixed feet), posed alike by two methods."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import animals, markers, posing, studio
from .posing import REST, Move

POSE_FRAME = 40
SPACING, HEADING = 2.75, -49.0  # the dragons stand in a row and look to the front right

LABELS = {None: "Rest", "thin_shell": "Thin Shell", "arap": "As-Rigid-As-Possible"}

# in the dragon's own frame: x ahead, y to its left
NECK, RUMP = (0.62, 0.0, 1.00), (-0.95, 0.0, 0.50)
HEAD_MOVES = {
    1: REST,
    POSE_FRAME: Move(shift=(-0.05, -0.10, 0.16), turn=(14.0, -12.0, -34.0), pivot=NECK),
    56: Move(shift=(-0.05, -0.10, 0.16), turn=(14.0, -12.0, -34.0), pivot=NECK),
    76: Move(shift=(0.04, 0.05, -0.16), turn=(-12.0, 14.0, 20.0), pivot=NECK),
    96: REST,
}
TAIL_MOVES = {
    1: REST,
    POSE_FRAME: Move(shift=(0.04, 0.0, 0.02), turn=(0.0, 64.0, 22.0), pivot=RUMP),
    56: Move(shift=(0.04, 0.0, 0.02), turn=(0.0, 64.0, 22.0), pivot=RUMP),
    76: Move(turn=(0.0, 14.0, -32.0), pivot=RUMP),
    96: REST,
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Creature")
    dragons = posing.line_up(animals.dragon(), LABELS.values(), SPACING, HEADING)
    for method, dragon in zip(LABELS, dragons):
        pose(dragon, method)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.06, 0.0, 0.90), distance=26.0, elevation=13.0, width=8.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for dragon, label in zip(dragons, LABELS.values()):
        studio.add_label(scene, label, (dragon.location.x + 0.12, -1.75, 0.0), 0.22)
    studio.set_up_render(scene, samples=64, height=540)
    studio.open_at(scene, POSE_FRAME, dragons[-1])
    return scene


def pose(dragon: bpy.types.Object, method: str | None) -> None:
    """Add pins and pads to every dragon, and a deformer with moving controls to those that have a method."""
    place = dragon.matrix_world
    for x, y in ((0.52, 0.375), (0.52, -0.375), (-0.50, 0.43), (-0.50, -0.43)):
        markers.add_pad(place @ Vector((x, y, 0.0)), 0.26)
    if method is None:
        controls = [bpy.data.objects.new(f"{name} at rest", None) for name in ("Head", "Tail")]
        for control in controls:
            bpy.context.scene.collection.objects.link(control)
    else:
        posing.add_deformer(dragon, method)
        controls = [posing.add_region(dragon, "HANDLE", name).control for name in ("Head", "Tail")]
        posing.add_region(dragon, "FIXED", "Feet")
    markers.add_pin(controls[0], place @ Vector((1.06, 0, 2.05)), 0.062, place @ Vector((1.06, 0, 1.6)))
    markers.add_pin(controls[1], place @ Vector((-2.19, 0, 1.33)), 0.062, place @ Vector((-2.13, 0, 1.0)))
    if method is not None:
        for control, moves in zip(controls, (HEAD_MOVES, TAIL_MOVES)):
            posing.animate(control, moves, dragon)
        posing.check_posed(dragon, 1, POSE_FRAME)
