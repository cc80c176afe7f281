# SPDX-License-Identifier: GPL-3.0-or-later
"""A locomotive of thousands of loose parts: the boiler stretches and bends, the wheels stay round."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import markers, materials, posing, studio
from .models import locomotive
from .posing import REST, Move

POSE_FRAME = 40
SPACING, HEADING = 4.3, -24.0
METHODS = {
    "Rest": "",
    "Radial Basis Functions": "rbf",
    "Moving Least Squares": "mls",
    "Space Propagation": "space_propagation",
}
HANDLES = {
    "Bogie": Move(shift=(0.75, 0.0, 0.0)),
    "Chimney": Move(shift=(0.42, 0.0, 0.62), turn=(0.0, 24.0, 0.0), pivot=(1.12, 0.0, 1.4)),
    "Cab": Move(shift=(-0.18, 0.0, 0.12), turn=(0.0, -14.0, 0.0), pivot=(-1.1, 0.0, 0.6)),
}
TIPS = {"Bogie": (1.22, -0.75, 0.18), "Chimney": (1.12, 0.0, 2.05), "Cab": (-1.12, 0.0, 1.85)}
FEET = {"Bogie": (1.22, -0.40, 0.18), "Chimney": (1.12, 0.0, 1.72), "Cab": (-1.12, 0.0, 1.55)}
PAINT = {
    "Black": (0.018, 0.020, 0.024),
    "Brass": (0.62, 0.30, 0.05),
    "Red": (0.36, 0.020, 0.015),
    "Steel": (0.30, 0.31, 0.33),
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Machine")
    first, parts = locomotive.build()
    for name, colour in PAINT.items():
        first.data.materials.append(materials.plain_material(name, colour, roughness=0.32, specular=0.6))
    row = posing.line_up(first, METHODS, SPACING, HEADING)
    for obj, method in zip(row, METHODS.values()):
        if method:
            pose(obj, method)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.1, 0.0, 0.86), distance=34.0, elevation=12.0, width=18.0)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=11.0)
    for obj, label in zip(row, METHODS):
        text = f"{parts:,} Loose Parts" if label == "Rest" else label
        studio.add_label(scene, text, (obj.location.x, -1.75, 0.0), 0.22)
    studio.set_up_render(scene, samples=64, width=1920, height=400)
    studio.open_at(scene, POSE_FRAME, row[1])
    return scene


def pose(obj: bpy.types.Object, method: str) -> None:
    posing.add_deformer(obj, method)
    posing.add_region(obj, "FIXED", "Drivers")
    place = obj.matrix_world.copy()
    for name, move in HANDLES.items():
        handle = posing.add_region(obj, "HANDLE", name)
        markers.add_pin(handle.control, place @ Vector(TIPS[name]), 0.07, place @ Vector(FEET[name]))
        posing.animate(handle.control, {1: REST, POSE_FRAME: move, 60: move, 96: REST}, obj)
    posing.check_posed(obj, 1, POSE_FRAME)
