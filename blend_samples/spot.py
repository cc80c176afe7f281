# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot lifts a hoof: a coarse mesh posed as rigidly as possible, smoothed by a Subdivision below."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import animals, markers, posing, studio
from .posing import REST, Move

POSE_FRAME = 40
SPACING, HEADING = 2.35, -52.0
LABELS = ("Rest", "As-Rigid-As-Possible")
NOD = Move(shift=(0.02, -0.06, 0.07), turn=(22.0, -14.0, -16.0), pivot=(0.05, 0.0, 0.95))
WAVE = Move(shift=(0.30, -0.12, 0.38), turn=(0.0, -52.0, -10.0), pivot=(0.18, -0.2, 0.10))
HEAD_MOVES = {
    1: REST,
    POSE_FRAME: NOD,
    56: Move(shift=(0.02, 0.06, 0.07), turn=(-18.0, -10.0, 14.0), pivot=(0.05, 0.0, 0.95)),
    72: NOD,
    96: REST,
}
HOOF_MOVES = {
    1: REST,
    POSE_FRAME: WAVE,
    48: Move(shift=(0.34, -0.18, 0.48), turn=(0.0, -66.0, -10.0), pivot=(0.18, -0.2, 0.10)),
    56: WAVE,
    64: Move(shift=(0.34, -0.18, 0.48), turn=(0.0, -66.0, -10.0), pivot=(0.18, -0.2, 0.10)),
    72: WAVE,
    96: REST,
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Spot")
    cows = posing.line_up(animals.cow(), LABELS, SPACING, HEADING)
    pose(cows[-1])
    for cow in cows:
        smooth = cow.modifiers.new("Subdivision", "SUBSURF")
        smooth.levels, smooth.render_levels = 1, 2

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.05, 0.0, 0.88), distance=20.0, elevation=12.0, width=5.1)
    studio.add_lights(scene, target=(0.0, 0.0, 0.8), size=6.0)
    for cow, label in zip(cows, LABELS):
        studio.add_label(scene, label, (cow.location.x, -1.30, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1080, height=520)
    studio.open_at(scene, POSE_FRAME, cows[-1])
    return scene


def pose(cow: bpy.types.Object) -> None:
    posing.add_deformer(cow, "arap")
    head, hoof = (posing.add_region(cow, "HANDLE", name).control for name in ("Head", "Hoof"))
    posing.add_region(cow, "FIXED", "Hooves")
    place = cow.matrix_world
    markers.add_pin(head, place @ Vector((0.10, 0, 1.88)), 0.05, place @ Vector((0.14, 0, 1.5)))
    markers.add_pin(hoof, place @ Vector((0.52, -0.2, 0.10)), 0.05, place @ Vector((0.2, -0.2, 0.08)))
    for x, y in ((-0.02, 0.235), (-0.79, 0.20), (-0.79, -0.20)):
        markers.add_pad(place @ Vector((x, y, 0.0)), 0.23)
    posing.animate(head, HEAD_MOVES, cow)
    posing.animate(hoof, HOOF_MOVES, cow)
    posing.check_posed(cow, 1, POSE_FRAME)
