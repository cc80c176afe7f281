# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate lifted and tilted by its handle, by PriMo with prisms of three heights."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import markers, materials, posing, studio
from .models import plate
from .posing import REST, Move

POSE_FRAME = 40
SPACING = 2.45
HEIGHTS = (0.002, 0.02, 0.1)
LIFT = Move(shift=(0.0, 0.0, 0.6), turn=(25.0, -30.0, 0.0))
MOVES = {
    1: REST,
    POSE_FRAME: LIFT,
    52: LIFT,
    76: Move(shift=(0.0, 0.0, 0.4), turn=(-16.0, 20.0, 45.0)),
    96: REST,
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Prisms")
    first = plate.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    surface = materials.patched_material("Plate", plate.PLAIN, patches, roughness=0.5)
    materials.rule_lines(surface, cell=0.1, line=0.014)
    first.data.materials.append(surface)
    first.location.z = 0.05
    plates = posing.line_up(first, (f"{height}" for height in HEIGHTS), SPACING)
    for obj, height in zip(plates, HEIGHTS):
        pose(obj, height)

    studio.add_backdrop(scene, behind=14.0, tint=(0.30, 0.27, 0.235))
    studio.add_camera(scene, target=(0.0, 0.0, 0.31), distance=24.0, elevation=19.0, width=7.5)
    studio.add_lights(scene, target=(0.0, 0.0, 0.3), size=11.0)
    for obj, height in zip(plates, HEIGHTS):
        studio.add_label(scene, f"PriMo   height {height}", (obj.location.x, -1.52, 0.0), 0.165)
    studio.set_up_render(scene, samples=64, height=450)
    studio.open_at(scene, POSE_FRAME, plates[1])
    return scene


def pose(obj: bpy.types.Object, height: float) -> None:
    posing.add_deformer(obj, "primo", height=height, max_iterations=400)
    handle = posing.add_region(obj, "HANDLE", "Handle")
    posing.add_region(obj, "FIXED", "Frame")
    place = obj.matrix_world
    markers.add_pin(handle.control, place @ Vector((0, 0, 0.42)), 0.06, place @ Vector((0, 0, 0)))
    posing.animate(handle.control, MOVES, obj)
    posing.check_posed(obj, 1, POSE_FRAME)
