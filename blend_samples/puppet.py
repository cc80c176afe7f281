# SPDX-License-Identifier: GPL-3.0-or-later
"""A mannequin as a puppet: a hand or the hip is dragged, its feet are pinned, and its skin follows."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import mannequins, markers, materials, posing
from .mannequins import POSE_FRAME

FEET = ("foot.L", "foot.R")
# Label -> what is dragged, how far, and how.
DRAGS = {
    "Rest": (),
    "Hand": (("hand.L", (-0.25, -0.45, 0.45), {}),),
    "Hip": (("hip", (0.0, 0.08, -0.38), {"part": "WHOLE"}),),
    "Hand, with balance": (("hand.L", (0.0, -0.75, -0.75), {"balance": True}),),
}


def make() -> bpy.types.Scene:
    return mannequins.row("Puppet", DRAGS, pose, spacing=2.0, width=8.4, height=480, active=1)


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
    for name, head, _tail, _parent, _first, _last in mannequins.all_bones():
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
