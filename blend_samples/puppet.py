# SPDX-License-Identifier: GPL-3.0-or-later
"""A mannequin as a puppet: a hand or the hip is dragged, its feet are pinned, and its skin follows."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from mathutils import Vector

from . import markers, materials, posing, studio

POSE_FRAME = 40
SPACING = 2.0
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
FEET = ("foot.L", "foot.R")
# Label -> what is dragged, how far, and how.
DRAGS = {
    "Rest": (),
    "Hand": (("hand.L", (-0.25, -0.45, 0.45), {}),),
    "Hip": (("hip", (0.0, 0.08, -0.38), {"part": "WHOLE"}),),
    "Hand, with balance": (("hand.L", (0.0, -0.75, -0.75), {"balance": True}),),
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Puppet")
    places = [SPACING * (k - 0.5 * (len(DRAGS) - 1)) for k in range(len(DRAGS))]
    figures = []
    for (label, drags), x in zip(DRAGS.items(), places):
        skin, rig = mannequin(label)
        skin.location.x = rig.location.x = x
        bpy.context.view_layer.update()
        pose(skin, rig, drags)
        figures.append((skin, rig))

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.0, 0.0, 0.92), distance=26.0, elevation=10.0, width=8.4)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for label, x in zip(DRAGS, places):
        studio.add_label(scene, label, (x, -1.1, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, height=480)
    studio.open_at(scene, POSE_FRAME, figures[1][0])
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


def pose(skin: bpy.types.Object, rig: bpy.types.Object, drags: tuple) -> None:
    """Give the mesh the bones as handles, pin the feet, and key the figure at rest and as it is dragged."""
    posing.make_active(skin)
    posing.expect(
        bpy.ops.sinew.puppet_rig(armature=rig.name, method="mesh_puppetry"), f"{skin.name}: puppet_rig"
    )
    for name in FEET:
        rig.pose.bones[name].sinew.pin = True
        limit = rig.pose.bones[name.replace("foot", "shin")]
        limit.use_ik_limit_x, limit.ik_min_x, limit.ik_max_x = True, 0.0, 2.4
        limit.lock_ik_y = limit.lock_ik_z = True
    for name, head, _tail, _parent, _first, _last in all_bones():
        if name in FEET:
            markers.add_pad(rig.matrix_world @ Vector((head.x, head.y - 0.08, 0.0)), 0.105)
    posing.make_active(rig)
    for frame, steps in ((1, ()), (POSE_FRAME, drags), (96, ())):
        bpy.context.scene.frame_set(frame)
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        for bone, value, options in steps:
            posing.expect(
                bpy.ops.sinew.puppet_pose(bone=bone, value=value, **options), f"{rig.name}: puppet_pose"
            )
        for bone in rig.pose.bones:
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            bone.keyframe_insert("location", frame=frame)
    if drags:
        bpy.context.scene.frame_set(POSE_FRAME)
        name = drags[0][0]
        tip = rig.matrix_world @ rig.pose.bones[name].tail
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.05, location=tip)
        ball = bpy.context.object
        ball.name, ball.hide_select = f"{rig.name} Drag", True
        ball.data.materials.append(materials.plain_material("Handle", materials.HANDLE_COLOUR, roughness=0.3))
        posing.check_posed(skin, 1, POSE_FRAME)
