# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a bone that becomes a control moves the mesh already."""

from bpy.types import Object

from ....properties import SinewDeformer, SinewHandle
from ...targets import modified


def is_moved_by_control(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> bool:
    """Whether an Armature modifier before the deformer moves the mesh by the bone of the handle."""
    armature, bone = handle.control, handle.bone
    if armature is None or not bone or bone not in obj.vertex_groups or bone not in armature.data.bones:
        return False
    own = modified.shown_by(obj, deformer)
    before = list(obj.modifiers)[: list(obj.modifiers).index(own)] if own else obj.modifiers
    carries = any(modifier.type == "ARMATURE" and modifier.object == armature for modifier in before)
    return carries and armature.data.bones[bone].use_deform
