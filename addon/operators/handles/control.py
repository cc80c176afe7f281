# SPDX-License-Identifier: GPL-3.0-or-later
"""Give new controls to handles that have lost theirs."""

from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions.handles import handles
from ..arguments import row_index
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import handle_index, object_mode, target_of
from .handle import select_control


class SINEW_OT_control_new(OnDeformer, Operator):
    """Make a new empty for a handle that has lost its control, where its region is now"""

    bl_idname = Operators.CONTROL_NEW
    bl_label = "New Control"

    index: row_index("Which handle; -1 is every handle that has lost its control", options={"SKIP_SAVE"})

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            ""
            if any(handle.control_missing for handle in target_of(context).sinew.active.handles)
            else "Every handle has its control"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        wanted = range(len(deformer.handles)) if self.index < 0 else [handle_index(deformer, self.index)]
        lost = [index for index in wanted if deformer.handles[index].control_missing]
        with object_mode(context, obj):
            for index in lost:
                handles.new_control(obj, deformer, deformer.handles[index])
            context.view_layer.update()  # the new empties enter the view layer
            for index in lost:
                select_control(context, obj, deformer.handles[index], extend=index != lost[0])
        return {"FINISHED"}
