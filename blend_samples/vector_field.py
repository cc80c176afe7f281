# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, twisted, bent and dragged by vector fields: its volume stays."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from . import materials, posing, studio
from .models import pillar
from .posing import REST, Move
from .volume import volume

POSE_FRAME = 40
SPACING = 2.2
STRIPES, STRIPE = 3, (0.30, 0.035, 0.02)
# the tool, where it rests, its reach, and how it has moved in the frame of the pillar
TOOLS = {
    "Rest": None,
    "Twist": ("twist", 1.0, {"inner": -0.75, "outer": 0.75, "width": 1.0}, Move(turn=(0.0, 0.0, 200.0))),
    "Bend": ("bend", 1.0, {"inner": -0.75, "outer": 0.75, "width": 0.45}, Move(turn=(0.0, 80.0, 0.0))),
    "Drag": ("drag", 1.5, {"inner": 0.3, "outer": 1.2}, Move(shift=(0.55, 0.0, -0.05))),
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Vector Fields")
    first = pillar.build()
    paint_stripes(first.data)
    row = posing.line_up(first, TOOLS, SPACING)
    for obj, tool in zip(row, TOOLS.values()):
        if tool:
            pose(obj, *tool)
            posing.check_posed(obj, 1, POSE_FRAME)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.1, 0.0, 0.9), distance=24.0, elevation=10.0, width=8.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    scene.frame_set(POSE_FRAME)
    whole = volume(row[0])
    for obj, label in zip(row, TOOLS):
        drift = 100.0 * (volume(obj) / whole - 1.0)
        studio.add_label(scene, label, (obj.location.x, -1.0, 0.0), 0.13)
        text = f"{drift:+.3f} % of the volume" if label != "Rest" else "100 % of the volume"
        print(f"> {label}: {text}", flush=True)
        studio.add_label(scene, text, (obj.location.x, -1.5, 0.0), 0.11)
    studio.set_up_render(scene, samples=32, width=1680, height=520)
    studio.open_at(scene, POSE_FRAME, row[-1])
    return scene


def paint_stripes(mesh: bpy.types.Mesh) -> None:
    """Upright stripes, which show how the pillar turns."""
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.ravel())
    angle, away = np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 0], points[:, 1])
    stripes = mesh.attributes.new("stripe", "FLOAT", "POINT")
    stripes.data.foreach_set("value", away * np.cos(STRIPES * angle))
    patches = (("stripe", STRIPE, 0.006),)
    mesh.materials.append(materials.patched_material("Pillar", pillar.PLAIN, patches, roughness=0.5))


def pose(obj: bpy.types.Object, kind: str, height: float, reach: dict[str, float], move: Move) -> None:
    """Add a tool on the axis of the pillar, and key its way."""
    posing.make_active(obj)
    place = obj.matrix_world @ Vector((0.0, 0.0, height))
    answer = bpy.ops.sinew.tool_add(tool=kind, location=place, outer=reach["outer"])
    posing.expect(answer, f"{obj.name}: tool_add({kind!r})")
    row = obj.sinew.active.controls[-1]
    for name, value in reach.items():
        setattr(row, name, value)
    about = Move(move.shift, move.turn, pivot=(0.0, 0.0, height))
    posing.animate(row.object, {1: REST, POSE_FRAME: about, 96: REST}, obj)
