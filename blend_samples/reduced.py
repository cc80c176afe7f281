# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, bent by surface methods with few unknowns: those of bands, and those of a cage."""

from __future__ import annotations

import bpy

from . import materials, pillars, posing, studio
from .models import pillar
from .volume import volume

METHODS = {
    "Rest": ("", {}),
    "As-Rigid-As-Possible": ("arap", {}),
    "Handle-Aware Isolines": ("handle_aware_isolines", {}),
    "Subspace Laplacian, Volume Free": ("subspace_laplacian", {"keep_volume": False}),
    "Subspace Laplacian": ("subspace_laplacian", {}),
}
SPACING = 2.2


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Few Unknowns")
    first = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    row = posing.line_up(first, METHODS, SPACING)
    for obj, (method, parameters) in zip(row, METHODS.values()):
        if method:
            pillars.pose(obj, method)
            for name, value in parameters.items():
                setattr(obj.sinew.active.parameters, name, value)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.55, 0.0, 0.84), distance=24.0, elevation=10.0, width=11.4)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    scene.frame_set(pillars.POSE_FRAME)
    whole = volume(row[0])
    for obj, label in zip(row, METHODS):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.13)
        share = f"{100 * volume(obj) / whole:.1f} % of the volume"
        studio.add_label(scene, share, (obj.location.x + 0.2, -1.5, 0.0), 0.11)
    studio.set_up_render(scene, samples=32, width=1680, height=400)
    studio.open_at(scene, pillars.POSE_FRAME, row[-1])
    return scene
