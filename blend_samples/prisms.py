# SPDX-License-Identifier: GPL-3.0-or-later
"""One vertex of a plate is lifted: by As-Rigid-As-Possible, and by PriMo with prisms of two heights."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from . import markers, materials, posing, studio
from .models import plate
from .posing import REST, Move

POSE_FRAME = 40
SPACING = 2.45
SETTINGS = (
    ("As-Rigid-As-Possible", "arap", {}),
    ("PriMo   height 0.01", "primo", {"height": 0.01}),
    ("PriMo   height 0.05", "primo", {"height": 0.05}),
)
LIFT = Move(shift=(0.0, 0.0, 0.5))
MOVES = {1: REST, POSE_FRAME: LIFT, 52: LIFT, 76: Move(shift=(0.3, 0.2, 0.2)), 96: REST}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Prisms")
    first = plate.build()
    middle = int(np.argmin([v.co.xy.length for v in first.data.vertices]))
    first.vertex_groups.new(name="Tip").add([middle], 1.0, "REPLACE")
    patches = (("fixed", materials.FIXED_COLOUR, 0.002),)
    surface = materials.patched_material("Plate", plate.PLAIN, patches, roughness=0.5)
    materials.rule_lines(surface, cell=0.1, line=0.014)
    first.data.materials.append(surface)
    first.location.z = 0.05
    plates = posing.line_up(first, (label for label, _, _ in SETTINGS), SPACING)
    for obj, (_, method, parameters) in zip(plates, SETTINGS):
        pose(obj, method, parameters)

    studio.add_backdrop(scene, behind=14.0, tint=(0.30, 0.27, 0.235))
    studio.add_camera(scene, target=(0.0, 0.0, 0.31), distance=24.0, elevation=19.0, width=7.5)
    studio.add_lights(scene, target=(0.0, 0.0, 0.3), size=11.0)
    for obj, (label, _, _) in zip(plates, SETTINGS):
        studio.add_label(scene, label, (obj.location.x, -1.52, 0.0), 0.165)
    studio.set_up_render(scene, samples=64, height=450)
    studio.open_at(scene, POSE_FRAME, plates[1])
    return scene


def pose(obj: bpy.types.Object, method: str, parameters: dict[str, float]) -> None:
    posing.add_deformer(obj, method, **parameters)
    handle = posing.add_region(obj, "HANDLE", "Tip")
    posing.add_region(obj, "FIXED", "Frame")
    place = obj.matrix_world
    markers.add_pin(handle.control, place @ Vector((0, 0, 0.42)), 0.06, place @ Vector((0, 0, 0)))
    posing.animate(handle.control, MOVES, obj)
    posing.check_posed(obj, 1, POSE_FRAME)
