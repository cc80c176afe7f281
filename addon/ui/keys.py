# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a method that edits animations, and the buttons that change them."""

from bpy.types import Context, UILayout, UIList

from ..ids import Operators
from ..properties import SinewDeformer, SinewKey
from ..session.actions import keys
from .layouts import Button, RowList, draw_pair
from .text import draw_text

_ADDING = (
    Button(Operators.KEY_ADD, "Key Edit", "KEY_HLT"),
    Button(Operators.KEY_ADD, "Key None", "KEYFRAME", (("blank", True),)),
)


class SINEW_UL_keys(RowList, UIList):
    """The keys of a deformer: their frames, which can be changed here, and a button that goes there"""

    def draw_row(
        self, context: Context, layout: UILayout, _owner: SinewDeformer, key: SinewKey, _icon: int, index: int
    ) -> None:
        row = layout.row(align=True)
        is_here = key.frame == round(context.scene.frame_current_final)
        # Within a narrow number field, an icon would take all the room of the number.
        row.label(text="", icon="KEYTYPE_KEYFRAME_VEC" if is_here else "KEYFRAME")
        row.prop(key, "frame", text="Frame", emboss=False)
        jump = row.operator(Operators.KEY_JUMP, text="", icon="TIME", emboss=False)
        jump.to, jump.index = "ACTIVE", index


def draw(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw the list of keys, and what adds and removes them."""
    layout.label(text="Keys of the Edit")
    row = layout.row()
    row.template_list("SINEW_UL_keys", "", deformer, "keys", deformer, "active_key", rows=3)
    row.operator(Operators.KEY_REMOVE, text="", icon="REMOVE")
    draw_pair(context, layout, _ADDING)
    for text in keys.key_notes(deformer):
        draw_text(context, layout, text, "INFO")
