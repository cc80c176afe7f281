# SPDX-License-Identifier: GPL-3.0-or-later
"""One pillar, twisted, bent and dragged by vector fields: its volume stays."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import materials, posing, studio
from .models import pillar
from .posing import REST, Move
from .volume import volume

POSE_FRAME = 40
SPACING = 2.2
# the tool, where it rests, its reach, and how it has moved in the frame of the pillar
TOOLS = {
    "Rest": None,
    "Twist": ("twist", 0.25, {"inner": 0.0, "outer": 1.4, "width": 1.0}, Move(turn=(0.0, 0.0, 170.0))),
    "Bend": ("bend", 0.55, {"inner": 0.0, "outer": 0.9, "width": 0.4}, Move(turn=(0.0, 75.0, 0.0))),
    "Drag": ("drag", 1.65, {"inner": 0.28, "outer": 0.9}, Move(shift=(0.62, 0.0, 0.12))),
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Vector Fields")
    first = pillar.build()
    first.data.materials.append(materials.patched_material("Pillar", pillar.PLAIN, (), roughness=0.5))
    row = posing.line_up(first, TOOLS, SPACING)
    for obj, tool in zip(row, TOOLS.values()):
        if tool:
            pose(obj, *tool)
            posing.check_posed(obj, 1, POSE_FRAME)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.1, 0.0, 0.84), distance=24.0, elevation=10.0, width=9.2)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    scene.frame_set(POSE_FRAME)
    whole = volume(row[0])
    for obj, label in zip(row, TOOLS):
        drift = 100.0 * (volume(obj) / whole - 1.0)
        studio.add_label(scene, label, (obj.location.x, -1.0, 0.0), 0.13)
        text = f"{drift:+.3f} % of the volume" if label != "Rest" else "100 % of the volume"
        print(f"> {label}: {text}", flush=True)
        studio.add_label(scene, text, (obj.location.x, -1.5, 0.0), 0.11)
    studio.set_up_render(scene, samples=32, width=1680, height=460)
    studio.open_at(scene, POSE_FRAME, row[-1])
    return scene


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
