# SPDX-License-Identifier: GPL-3.0-or-later
"""Let the control of a handle ride on the surface that enters, or stay in the world."""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...properties import STANDS_ON, field
from ...session.actions.handles import standing
from ...session.controls.handles import riding
from ..arguments import once, row_index
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import handle_index, target_of


class SINEW_OT_handle_stand(OnDeformer, Operator):
    """Choose what the control of the handle stands on. The shape of this frame stays as it is"""

    bl_idname = Operators.HANDLE_STAND
    bl_label = "Stands On"

    on: once(EnumProperty, items=STANDS_ON).named(
        "Stands On", "Choose whether the control stays in the world, or rides on the surface that enters"
    )
    convert_keyframes: field(BoolProperty, default=True).named(
        "Convert Keyframes",
        "Rewrite the keyframes of the control, so that the shape stays in each of their frames",
    )
    index: row_index("Choose which handle; -1 is the active one", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_handle_stand") -> str:
        """What the chosen one means."""
        return next(text for name, _label, text, _number in STANDS_ON if name == properties.on)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        handle = deformer.handles[handle_index(deformer, self.index)]
        count = standing.stand_on(obj, deformer, handle, self.on, self.convert_keyframes)
        told = riding.standing(handle)
        if count:
            frames = "1 frame was" if count == 1 else f"{count} frames were"
            told += f"; the keys of {frames} converted, and frames between them may differ"
        self.tell({"INFO"}, told)
        return {"FINISHED"}
