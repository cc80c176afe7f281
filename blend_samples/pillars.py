# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, bent by each linear surface method: which of them turn the grooves and studs."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import markers, materials, posing, studio
from .models import pillar
from .posing import REST, Move

POSE_FRAME = 40
SPACING = 2.04
METHODS = {
    "Rest": "",
    "Thin Shell": "thin_shell",
    "Gradient Editing": "gradient_editing",
    "Rotation-Invariant": "rotation_invariant_coordinates",
    "Laplacian Editing": "laplacian_editing",
    "Hierarchical": "hierarchical_smoothing",
    "Subdivision": "subdivision_editing",
    "Propagation": "propagation",
}
# The axis between foot and head becomes an arc of its own length.
BEND = Move(shift=(0.94, 0.0, -0.61), turn=(0.0, 100.0, 0.0), pivot=(0.0, 0.0, pillar.HEAD))
MOVES = {
    1: REST,
    POSE_FRAME: BEND,
    52: BEND,
    76: Move(turn=(0.0, 0.0, 135.0)),
    96: REST,
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Pillars")
    first = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    pillars = posing.line_up(first, METHODS, SPACING)
    for obj, method in zip(pillars, METHODS.values()):
        if method:
            pose(obj, method)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.55, 0.0, 0.92), distance=28.0, elevation=10.0, width=16.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for obj, label in zip(pillars, METHODS):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1920, height=352)
    studio.open_at(scene, POSE_FRAME, pillars[-1])
    return scene


def pose(obj: bpy.types.Object, method: str) -> None:
    posing.add_deformer(obj, method)
    head = posing.add_region(obj, "HANDLE", "Head")
    posing.add_region(obj, "FIXED", "Foot")
    place = obj.matrix_world
    markers.add_pin(head.control, place @ Vector((0, 0, 2.25)), 0.06, place @ Vector((0, 0, 2.0)))
    posing.animate(head.control, MOVES, obj)
    posing.check_posed(obj, 1, POSE_FRAME)
