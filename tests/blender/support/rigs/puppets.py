# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure of bones, and how it is dragged and looked at."""

import bpy
import numpy as np

from rigs.rig import armature_object, press, update

BONES = {  # head, tail and parent
    "hip": ((0.0, 0.0, 1.0), (0.0, 0.0, 1.2), ""),
    "spine": ((0.0, 0.0, 1.2), (0.0, 0.02, 1.4), "hip"),
    "chest": ((0.0, 0.02, 1.4), (0.0, 0.0, 1.6), "spine"),
    "upper.L": ((0.15, 0.0, 1.55), (0.45, 0.02, 1.55), "chest"),
    "lower.L": ((0.45, 0.02, 1.55), (0.75, 0.0, 1.55), "upper.L"),
    "hand.L": ((0.75, 0.0, 1.55), (0.85, 0.0, 1.55), "lower.L"),
    "thigh.L": ((0.1, 0.0, 1.0), (0.12, -0.02, 0.55), "hip"),
    "shin.L": ((0.12, -0.02, 0.55), (0.12, 0.0, 0.1), "thigh.L"),
    "foot.L": ((0.12, 0.0, 0.1), (0.12, -0.2, 0.0), "shin.L"),
    "thigh.R": ((-0.1, 0.0, 1.0), (-0.12, -0.02, 0.55), "hip"),
    "shin.R": ((-0.12, -0.02, 0.55), (-0.12, 0.0, 0.1), "thigh.R"),
    "foot.R": ((-0.12, 0.0, 0.1), (-0.12, -0.2, 0.0), "shin.R"),
}
FEET = ("foot.L", "foot.R")


def figure(mode: str = "QUATERNION") -> bpy.types.Object:
    armature = armature_object("Figure", BONES)
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    update()
    return armature


def standing(mode: str = "QUATERNION") -> bpy.types.Object:
    armature = figure(mode)
    for name in FEET:
        armature.pose.bones[name].sinew.pin = True
    return armature


def end_of(armature: bpy.types.Object, name: str, end: str = "tail") -> np.ndarray:
    """Where an end of a bone is shown, in the world."""
    update()
    shown = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(shown.matrix_world @ getattr(shown.pose.bones[name], end))


def pose(armature: bpy.types.Object, bone: str, value=(0.0, 0.0, 0.0), **keywords) -> None:
    press(armature, "puppet_pose", bone=bone, value=value, **keywords)
    update()
