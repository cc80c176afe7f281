# SPDX-License-Identifier: GPL-3.0-or-later
"""A mannequin whose bones bend space: as places they pull at the joints, as segments along their length."""

from __future__ import annotations

from math import radians

import bpy
from mathutils import Matrix, Vector

from . import mannequins, posing
from .mannequins import POSE_FRAME

FALLOFF = 2.0
# Label -> whether bones act along their length; None for rest.
FIGURES = {"Rest": None, "Bones as places": False, "Bones as segments": True}
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


def make() -> bpy.types.Scene:
    return mannequins.row("Segments", FIGURES, pose, spacing=2.1, width=6.6, height=640, active=-1)


def pose(skin: bpy.types.Object, rig: bpy.types.Object, whole: bool | None) -> None:
    """Let all bones move the space around them, and key the figure at rest and posed."""
    if whole is None:
        return
    posing.make_active(rig)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.select_all(action="SELECT")
    skin.select_set(True)
    answer = bpy.ops.sinew.point_add(source="SELECTED", method="mls", segments=whole)
    posing.expect(answer, f"{skin.name}: point_add")
    bpy.ops.object.mode_set(mode="OBJECT")
    skin.sinew.active.parameters.alpha = FALLOFF
    for frame, turns in ((1, {}), (POSE_FRAME, TURNS), (96, {})):
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        for name, (degrees, axis) in turns.items():
            turn(rig, name, Matrix.Rotation(radians(degrees), 4, Vector(axis)))
        for bone in rig.pose.bones:
            bone.keyframe_insert("rotation_quaternion", frame=frame)
    posing.check_posed(skin, 1, POSE_FRAME)


def turn(rig: bpy.types.Object, name: str, rotation: Matrix) -> None:
    """Turn a bone about its head."""
    bpy.context.view_layer.update()
    bone = rig.pose.bones[name]
    head = Matrix.Translation(bone.head)
    bone.matrix = head @ rotation @ head.inverted() @ bone.matrix
