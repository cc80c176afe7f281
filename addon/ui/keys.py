# SPDX-License-Identifier: GPL-3.0-or-later
"""The Keys sub-panel: the keys of a method that edits animations, and the buttons that change them."""

from bpy.types import Context, Panel, UILayout, UIList

from .. import bake
from ..ids import Operators
from ..operators import target_of
from ..properties import SinewDeformer, SinewKey
from ..session.actions import keys
from .layouts import unless_baked
from .places import ActiveDeformerPanel, active_deformer
from .text import draw_text


class SINEW_UL_keys(UIList):
    """The keys of a deformer: their frames, which can be changed here, and a button that goes there"""

    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        _owner: SinewDeformer,
        key: SinewKey,
        _icon: int,
        _active_owner: SinewDeformer,
        _active_property: str,
        index: int,
    ) -> None:
        row = layout.row(align=True)
        is_here = key.frame == round(context.scene.frame_current_final)
        # Within a narrow number field, an icon would take all the room of the number.
        row.label(text="", icon="KEYTYPE_KEYFRAME_VEC" if is_here else "KEYFRAME")
        row.prop(key, "frame", text="", emboss=False)
        jump = row.operator(Operators.KEY_JUMP, text="", icon="TIME", emboss=False)
        jump.to, jump.index = "ACTIVE", index


class SINEW_PT_keys(ActiveDeformerPanel, Panel):
    """How handles are edited in frames of an animation"""

    bl_label = "Keys"
    bl_order = 5
    bl_options = set()

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context)
        return deformer is not None and deformer.definition.keyed

    def draw(self, context: Context) -> None:
        deformer = active_deformer(context)
        layout = unless_baked(self.layout, deformer)
        layout.operator(Operators.KEY_ADD, icon="KEY_HLT")
        row = layout.row()
        row.template_list("SINEW_UL_keys", "", deformer, "keys", deformer, "active_key", rows=3)
        side = row.column(align=True)
        side.operator(Operators.KEY_ADD, text="", icon="ADD")
        side.operator(Operators.KEY_REMOVE, text="", icon="REMOVE")
        side.separator()
        side.operator(Operators.KEY_JUMP, text="", icon="PREV_KEYFRAME").to = "PREVIOUS"
        side.operator(Operators.KEY_JUMP, text="", icon="NEXT_KEYFRAME").to = "NEXT"
        layout.operator(Operators.KEY_ADD, text="Key None", icon="KEYFRAME").blank = True
        frames = range(context.scene.frame_start, context.scene.frame_end + 1)
        missing = bake.missing_frames(context.scene, target_of(context), deformer, frames)
        for text in (*keys.key_notes(deformer), *missing):
            draw_text(context, layout, text, "INFO")


PANELS = (SINEW_PT_keys,)
