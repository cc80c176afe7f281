# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, bent by a space method alone, and with its details put back on a smooth base."""

from __future__ import annotations

import bpy

from . import materials, pillars, posing, studio
from .models import pillar

METHODS = {
    "Rest": "",
    "Radial Basis Functions": "rbf",
    "Multiresolution in Space": "multiresolution_space",
    "Moving Least Squares": "mls",
}
SPACING = 2.3


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Details in space")
    first = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    row = posing.line_up(first, METHODS, SPACING)
    for obj, method in zip(row, METHODS.values()):
        if method:
            pillars.pose(obj, method)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.55, 0.0, 0.84), distance=24.0, elevation=10.0, width=9.8)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for obj, label in zip(row, METHODS):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.13)
    studio.set_up_render(scene, samples=32, width=1680, height=460)
    studio.open_at(scene, pillars.POSE_FRAME, row[-1])
    return scene
