# SPDX-License-Identifier: GPL-3.0-or-later
"""Selection of pose bones. Blender 5.0 moved it from the bone to the pose bone."""

from bpy.types import Object


def _holder(armature: Object, name: str):
    posed = armature.pose.bones[name]
    return posed if hasattr(posed, "select") else posed.bone


def select_bone(armature: Object, name: str, select: bool = True) -> None:
    """Select a pose bone, or let it go."""
    _holder(armature, name).select = select


def is_bone_selected(armature: Object, name: str) -> bool:
    """The pose bone is selected."""
    return _holder(armature, name).select
