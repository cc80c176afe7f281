# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, bent by surface methods and by one that fills it with points: how much volume each keeps."""

from __future__ import annotations

import bmesh
import bpy

from . import materials, pillars, posing, studio
from .models import pillar

METHODS = {
    "Rest": "",
    "Thin Shell": "thin_shell",
    "Laplacian Editing, From Handles": "laplacian_editing",
    "Volumetric Graph Laplacian": "volumetric_graph_laplacian",
}
SPACING = 2.2


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Volume")
    first = pillar.build()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))
    row = posing.line_up(first, METHODS, SPACING)
    for obj, method in zip(row, METHODS.values()):
        if method:
            pillars.pose(obj, method)
        if method == "laplacian_editing":
            obj.sinew.active.parameters.transforms = "explicit"

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.55, 0.0, 0.84), distance=24.0, elevation=10.0, width=9.2)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    scene.frame_set(pillars.POSE_FRAME)
    whole = volume(row[0])
    for obj, label in zip(row, METHODS):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.13)
        share = f"{100 * volume(obj) / whole:.1f} % of the volume"
        studio.add_label(scene, share, (obj.location.x + 0.2, -1.5, 0.0), 0.11)
    studio.set_up_render(scene, samples=32, width=1680, height=460)
    studio.open_at(scene, pillars.POSE_FRAME, row[-1])
    return scene


def volume(obj: bpy.types.Object) -> float:
    """What the evaluated mesh encloses."""
    shape = bmesh.new()
    shape.from_object(obj, bpy.context.evaluated_depsgraph_get())
    enclosed = shape.calc_volume()
    shape.free()
    return enclosed
