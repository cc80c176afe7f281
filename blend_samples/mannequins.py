# SPDX-License-Identifier: GPL-3.0-or-later
"""The mannequin of several samples, and a row of them before one camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import bpy
from mathutils import Vector

from . import materials, posing, studio

POSE_FRAME = 40
# Bones of the left side and the middle: head, tail, parent, and the radius of the limb at both ends.
BONES = {
    "hip": ((0.0, 0.0, 0.98), (0.0, 0.0, 1.12), "", 0.13, 0.12),
    "spine": ((0.0, 0.0, 1.12), (0.0, 0.015, 1.28), "hip", 0.12, 0.13),
    "chest": ((0.0, 0.015, 1.28), (0.0, 0.0, 1.50), "spine", 0.13, 0.09),
    "neck": ((0.0, 0.0, 1.50), (0.0, -0.01, 1.60), "chest", 0.05, 0.055),
    "head": ((0.0, -0.01, 1.60), (0.0, -0.01, 1.80), "neck", 0.085, 0.09),
    "upper.L": ((0.17, 0.0, 1.45), (0.43, 0.02, 1.45), "chest", 0.055, 0.045),
    "lower.L": ((0.43, 0.02, 1.45), (0.68, 0.0, 1.45), "upper.L", 0.045, 0.035),
    "hand.L": ((0.68, 0.0, 1.45), (0.84, 0.0, 1.45), "lower.L", 0.035, 0.025),
    "thigh.L": ((0.10, 0.0, 0.94), (0.11, -0.02, 0.52), "hip", 0.085, 0.06),
    "shin.L": ((0.11, -0.02, 0.52), (0.11, 0.0, 0.09), "thigh.L", 0.06, 0.04),
    "foot.L": ((0.11, 0.0, 0.09), (0.11, -0.18, 0.035), "shin.L", 0.04, 0.035),
}


def row(
    name: str,
    figures: Mapping[str, Any],
    pose: Callable[[bpy.types.Object, bpy.types.Object, Any], None],
    *,
    spacing: float,
    width: float,
    height: int,
    active: int,
) -> bpy.types.Scene:
    """A scene with a mannequin for each label; ``pose`` gets skin, armature and what belongs to the label.

    The camera sees ``width`` metres, in a picture of ``height`` pixels. One of them is active in the file.
    """
    scene = studio.empty_scene(name)
    places = [spacing * (k - 0.5 * (len(figures) - 1)) for k in range(len(figures))]
    skins = []
    for (label, value), x in zip(figures.items(), places):
        skin, rig = mannequin(label)
        skin.location.x = rig.location.x = x
        bpy.context.view_layer.update()
        pose(skin, rig, value)
        skins.append(skin)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.0, 0.0, 0.92), distance=26.0, elevation=10.0, width=width)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for label, x in zip(figures, places):
        studio.add_label(scene, label, (x, -1.1, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, height=height)
    studio.open_at(scene, POSE_FRAME, skins[active])
    return scene


def all_bones() -> Iterator[tuple[str, Vector, Vector, str, float, float]]:
    for name, (head, tail, parent, first, last) in BONES.items():
        yield name, Vector(head), Vector(tail), parent, first, last
        if name.endswith(".L"):
            mirrored = [Vector((-end[0], end[1], end[2])) for end in (head, tail)]
            yield name[:-1] + "R", *mirrored, parent.replace(".L", ".R"), first, last


def mannequin(label: str) -> tuple[bpy.types.Object, bpy.types.Object]:
    """Tapered limbs, made one surface, and the armature inside."""
    studio.progress(f"modelling {label}")
    balls = bpy.data.metaballs.new(f"{label} Clay")
    balls.resolution = balls.render_resolution = 0.022
    balls.threshold = 0.1
    for _name, head, tail, _parent, first, last in all_bones():
        steps = max(4, round((tail - head).length / 0.02))
        for k in range(steps + 1):
            ball = balls.elements.new(type="BALL")
            ball.co = head.lerp(tail, k / steps)
            ball.radius = 1.25 * (first + (last - first) * k / steps)
    for k in range(16):  # shoulders, where there are no bones
        ball = balls.elements.new(type="BALL")
        ball.co, ball.radius = (-0.17 + 0.34 * k / 15, 0.0, 1.45), 0.085
    clay = bpy.data.objects.new(f"{label} Clay", balls)
    bpy.context.scene.collection.objects.link(clay)
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(clay.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(clay)
    mesh.name = f"{label} Skin"
    skin = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.scene.collection.objects.link(skin)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.clear()
    mesh.materials.append(materials.plain_material("Wood", (0.46, 0.27, 0.13), roughness=0.45))

    data = bpy.data.armatures.new(f"{label} Rig")
    data.display_type = "STICK"
    rig = bpy.data.objects.new(f"{label} Rig", data)
    bpy.context.scene.collection.objects.link(rig)
    posing.make_active(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, head, tail, parent, _first, _last in all_bones():
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    return skin, rig
