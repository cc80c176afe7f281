# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, bent by the thin shell alone and by multiresolution around it, which turns its studs."""

from __future__ import annotations

import bpy

from . import materials, pillars, posing, studio
from .models import pillar

METHODS = {
    "Rest": "",
    "Thin Shell": "thin_shell",
    "Multiresolution, Thin Shell": "multiresolution",
}
SPACING = 2.2
WAVELENGTH = 45.0  # in mean edge lengths: about the distance between two grooves


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Multiresolution")
    first = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    row = posing.line_up(first, METHODS, SPACING)
    for obj, method in zip(row, METHODS.values()):
        if method:
            pillars.pose(obj, method)
    row[-1].sinew.active.parameters.wavelength = WAVELENGTH

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.55, 0.0, 0.92), distance=24.0, elevation=10.0, width=7.0)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for obj, label in zip(row, METHODS):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1280, height=460)
    studio.open_at(scene, pillars.POSE_FRAME, row[-1])
    return scene
