# SPDX-License-Identifier: GPL-3.0-or-later
"""The mannequin, posed by its bones."""

from __future__ import annotations

from functools import partial
from math import radians

import bpy
from mathutils import Matrix, Vector

from .. import markers, posing
from ..lineup import POSE_FRAME, Lineup
from ..models import mannequin
from ..studio import Shot

FEET = ("foot.L", "foot.R")
FALLOFF = 2.0
# Bone -> degrees about an axis of the figure, parents first.
TURNS = {
    "spine": (14.0, (0.0, 1.0, 0.0)),
    "chest": (12.0, (0.0, 1.0, 0.0)),
    "upper.L": (-42.0, (0.0, 1.0, 0.0)),
    "lower.L": (-78.0, (0.0, 1.0, 0.0)),
    "upper.R": (-50.0, (0.0, 1.0, 0.0)),
    "lower.R": (-55.0, (0.0, 1.0, 0.0)),
    "thigh.L": (-68.0, (1.0, 0.0, 0.0)),
    "shin.L": (88.0, (1.0, 0.0, 0.0)),
}


def puppet(bone: str = "", value: tuple[float, float, float] = (0.0, 0.0, 0.0), **options: object):
    """The bones are handles, the feet are pinned, and a bone is dragged by ``value`` where one is named."""

    def drag(rig: bpy.types.Object) -> None:
        answer = bpy.ops.sinew.puppet_pose(bone=bone, value=value, **options)
        posing.expect(answer, f"{rig.name}: puppet_pose")

    def pose(skin: bpy.types.Object) -> None:
        rig = mannequin.rig_of(skin)
        posing.make_active(skin)
        answer = bpy.ops.sinew.puppet_rig(armature=rig.name, method="mesh_puppetry")
        posing.expect(answer, f"{skin.name}: puppet_rig")
        for name in FEET:
            rig.pose.bones[name].sinew.pin = True
            limit = rig.pose.bones[name.replace("foot", "shin")]
            limit.use_ik_limit_x, limit.ik_min_x, limit.ik_max_x = True, 0.0, 2.4
            limit.lock_ik_y = limit.lock_ik_z = True
            head = rig.data.bones[name].head_local
            markers.add_pad(rig.matrix_world @ Vector((head.x, head.y - 0.08, 0.0)), 0.105)
        posing.make_active(rig)
        key_bones(rig, drag if bone else None)
        if bone:
            bpy.context.scene.frame_set(POSE_FRAME)
            markers.add_ball(f"{rig.name} Drag", rig.matrix_world @ rig.pose.bones[bone].tail, 0.05)
            posing.check_posed(skin, 1, POSE_FRAME)

    return pose


def space(segments: bool):
    """All bones move the space around them: at their places, or along their length."""

    def pose(skin: bpy.types.Object) -> None:
        rig = mannequin.rig_of(skin)
        posing.make_active(rig)
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="SELECT")
        skin.select_set(True)
        answer = bpy.ops.sinew.point_add(source="SELECTED", method="mls", segments=segments)
        posing.expect(answer, f"{skin.name}: point_add")
        bpy.ops.object.mode_set(mode="OBJECT")
        skin.sinew.active.parameters.alpha = FALLOFF
        key_bones(rig, turn_bones)
        posing.check_posed(skin, 1, POSE_FRAME)

    return pose


def turn_bones(rig: bpy.types.Object) -> None:
    """Turn each bone about its head."""
    for name, (degrees, axis) in TURNS.items():
        bpy.context.view_layer.update()
        bone = rig.pose.bones[name]
        head = Matrix.Translation(bone.head)
        bone.matrix = (
            head @ Matrix.Rotation(radians(degrees), 4, Vector(axis)) @ head.inverted() @ bone.matrix
        )


def key_bones(rig: bpy.types.Object, pose) -> None:
    """Key all bones: at rest, as ``pose`` leaves them, and at rest again."""
    for frame in (1, POSE_FRAME, 96):
        bpy.context.scene.frame_set(frame)
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        if pose and frame == POSE_FRAME:
            pose(rig)
        for bone in rig.pose.bones:
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            bone.keyframe_insert("location", frame=frame)


SHOT = partial(Shot, (0.0, 0.0, 0.92), distance=26.0, light=10.0, front=-1.1)
Mannequins = partial(Lineup, build=mannequin.build, anew=True)

LINEUPS = {
    "puppet": Mannequins(
        about="A mannequin as a puppet: a hand or the hip is dragged, and its feet are pinned.",
        title="Puppet",
        row={
            "Rest": puppet(),
            "Hand": puppet("hand.L", (-0.25, -0.45, 0.45)),
            "Hip": puppet("hip", (0.0, 0.08, -0.38), part="WHOLE"),
            "Hand, with balance": puppet("hand.L", (0.0, -0.75, -0.75), balance=True),
        },
        spacing=2.0,
        active=1,
        shot=SHOT(width=8.4, picture=(1440, 480)),
    ),
    "segments": Mannequins(
        about="A mannequin whose bones bend space: as places at their joints, or as segments.",
        title="Segments",
        row={"Rest": None, "Bones as places": space(False), "Bones as segments": space(True)},
        spacing=2.1,
        shot=SHOT(width=6.6, picture=(1440, 640)),
    ),
}
