# SPDX-License-Identifier: GPL-3.0-or-later
"""Selection and visibility of pose bones. Blender 5.0 moved both from the bone to the pose bone."""

from bpy.types import Object


def _owner(armature: Object, name: str, what: str):
    posed = armature.pose.bones[name]
    return posed if hasattr(posed, what) else posed.bone


def select_bone(armature: Object, name: str, select: bool = True) -> None:
    """Select or deselect a pose bone."""
    _owner(armature, name, "select").select = select


def is_bone_selected(armature: Object, name: str) -> bool:
    """Whether a pose bone is selected."""
    return _owner(armature, name, "select").select


def is_bone_visible(armature: Object, name: str) -> bool:
    """Whether viewports that show the armature show a pose bone. Before 4.0, layers decide."""
    if _owner(armature, name, "hide").hide:
        return False
    bone = armature.data.bones[name]
    if hasattr(bone, "layers"):
        return any(on and shown for on, shown in zip(bone.layers, armature.data.layers, strict=True))
    return not bone.collections or any(group.is_visible_effectively for group in bone.collections)
