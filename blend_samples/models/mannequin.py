# SPDX-License-Identifier: GPL-3.0-or-later
"""A mannequin of wood with its bones."""

from collections.abc import Iterator

import bpy
from mathutils import Vector

from ..materials import plain_material
from ..posing import add_armature, add_object
from ..studio import progress

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


def all_bones() -> Iterator[tuple[str, Vector, Vector, str, float, float]]:
    for name, (head, tail, parent, first, last) in BONES.items():
        yield name, Vector(head), Vector(tail), parent, first, last
        if name.endswith(".L"):
            mirrored = [Vector((-end[0], end[1], end[2])) for end in (head, tail)]
            yield name[:-1] + "R", *mirrored, parent.replace(".L", ".R"), first, last


def rig_of(skin: bpy.types.Object) -> bpy.types.Object:
    return bpy.data.objects[skin.name.replace("Skin", "Rig")]


def build(label: str, x: float = 0.0, cell: float = 0.022) -> bpy.types.Object:
    """Tapered limbs as one surface of faces as large as ``cell``; beside it the armature: see ``rig_of``."""
    progress(f"modelling {label}")
    places = []
    for _name, head, tail, _parent, first, last in all_bones():
        steps = max(4, round((tail - head).length / 0.02))
        shares = [k / steps for k in range(steps + 1)]
        places += [(head.lerp(tail, t), 1.25 * (first + (last - first) * t)) for t in shares]
    # The shoulders, where there are no bones
    places += [(Vector((-0.17 + 0.34 * k / 15, 0.0, 1.45)), 0.085) for k in range(16)]
    balls = bpy.data.metaballs.new(f"{label} Clay")
    balls.resolution = balls.render_resolution = cell
    balls.threshold = 0.1
    for place, radius in places:
        ball = balls.elements.new(type="BALL")
        ball.co, ball.radius = place, radius
    clay = add_object(f"{label} Clay", balls)
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(clay.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(clay)
    mesh.name = f"{label} Skin"
    skin = add_object(mesh.name, mesh)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.clear()
    mesh.materials.append(plain_material("Wood", (0.46, 0.27, 0.13), roughness=0.45))
    rig = add_armature(f"{label} Rig", (bone[:4] for bone in all_bones()))
    skin.location.x = rig.location.x = x
    bpy.context.view_layer.update()
    return skin
