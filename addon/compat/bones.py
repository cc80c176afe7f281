# SPDX-License-Identifier: GPL-3.0-or-later
"""Selection of pose bones. Blender 5.0 moved it from the bone to the pose bone."""

from bpy.types import Object


def _selection_owner(armature: Object, name: str):
    posed = armature.pose.bones[name]
    return posed if hasattr(posed, "select") else posed.bone


def select_bone(armature: Object, name: str, select: bool = True) -> None:
    """Select or deselect a pose bone."""
    _selection_owner(armature, name).select = select


def is_bone_selected(armature: Object, name: str) -> bool:
    """Whether a pose bone is selected."""
    return _selection_owner(armature, name).select
