# SPDX-License-Identifier: GPL-3.0-or-later
"""Add, remove, move and visit the keys of a method that edits animations."""

from bpy.props import BoolProperty, EnumProperty, IntProperty
from bpy.types import Context, Operator

from ... import bake
from ...core.errors import SinewError
from ...ids import Operators
from ...properties import MAX_FRAME, SinewDeformer, field
from ...session.actions import keys
from ..arguments import once
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import object_mode, target_of

_INDEX = {"name": "Index", "default": -1, "min": -1, "description": "Choose which key; -1 is the active one"}


class OnKeys(OnDeformer):
    """Mixin for an operator on the keys of the active deformer."""

    MESHES_ONLY = True

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            ""
            if target_of(context).sinew.active.definition.keyed
            else f"Choose a method that has keys: {keys.with_keys()}"
        )


def _key_index(deformer: SinewDeformer, index: int) -> int:
    count = len(deformer.keys)
    chosen = min(deformer.active_key, count - 1) if index < 0 else index
    if not 0 <= chosen < count:
        raise SinewError(f"{deformer.name} has {count} keys, counted from 0 - there is no number {chosen}")
    return chosen


class SINEW_OT_key_add(OnKeys, Operator):
    """Keep the present edit of all handles as a key of this frame.

    The controls stay where they are. What they do from there on edits further
    """

    bl_idname = Operators.KEY_ADD
    bl_label = "Key Edit"

    blank: once(BoolProperty).named(
        "Blank", "Edit nothing in this frame, whatever the controls and the other keys do"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            keys.add_key(obj, obj.sinew.active, self.blank)
        return {"FINISHED"}


class SINEW_OT_key_remove(OnKeys, Operator):
    """Remove a key. The other keys edit its frames then"""

    bl_idname = Operators.KEY_REMOVE
    bl_label = "Remove Key"

    index: IntProperty(**_INDEX)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        keys.remove_key(obj, deformer, _key_index(deformer, self.index))
        return {"FINISHED"}


class SINEW_OT_key_move(OnKeys, Operator):
    """Move a key to another frame; a key that is there already is replaced"""

    bl_idname = Operators.KEY_MOVE
    bl_label = "Move Key"

    index: IntProperty(**_INDEX)
    frame: field(IntProperty, min=-MAX_FRAME, max=MAX_FRAME).named("Frame", "Set the new frame of the key")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        keys.move_key(obj, deformer, _key_index(deformer, self.index), self.frame)
        return {"FINISHED"}


class SINEW_OT_key_jump(OnKeys, Operator):
    """Go to the frame of a key"""

    bl_idname = Operators.KEY_JUMP
    bl_label = "Jump to Key"
    bl_options = {"INTERNAL"}

    to: field(
        EnumProperty,
        items=(
            ("ACTIVE", "Active", "The active key, or the one with the index", 0),
            ("NEXT", "Next", "The next key after this frame", 1),
            ("PREVIOUS", "Previous", "The last key before this frame", 2),
        ),
    ).named("To", "Choose which key")
    index: IntProperty(**_INDEX)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        deformer, scene = target_of(context).sinew.active, context.scene
        if self.to == "ACTIVE":
            index = _key_index(deformer, self.index)
        else:
            index = keys.key_beside(deformer, scene.frame_current_final, 1 if self.to == "NEXT" else -1)
        if index < 0:
            raise SinewError(
                "There is no key " + ("after" if self.to == "NEXT" else "before") + " this frame"
            )
        deformer.active_key = index
        frame, subframe = bake.frame_at(scene, deformer.keys[index].frame)
        scene.frame_set(frame, subframe=subframe)
        return {"FINISHED"}
