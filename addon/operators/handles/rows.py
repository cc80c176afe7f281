# SPDX-License-Identifier: GPL-3.0-or-later
"""Remove a wire or a tool from the list, and let all of them rest where they are."""

from bpy.types import Context, Operator

from ...core.errors import SinewError
from ...ids import Operators
from ...session.actions import bind, rigging
from ...session.actions.controls import control_list as rows
from ..arguments import row_index
from ..deformer.sharing import BindsAll
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import object_mode, target_of
from ..waiting import BindingOperator


class OnRows(OnDeformer):
    """Mixin for an operator on the wires or tools of the active deformer."""

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if rows.rows_of(target_of(context).sinew.active) else "Add a wire or a tool first"
        )


class SINEW_OT_control_remove(OnRows, BindingOperator, Operator):
    """Remove this control from the list. The object goes too, if it was made for the deformer"""

    bl_idname = Operators.ROW_REMOVE
    bl_label = "Remove Control"

    index: row_index("Choose the control, counted from 0; -1 is the active one", options={"SKIP_SAVE"})

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        index = deformer.active_control if self.index < 0 else self.index
        if not 0 <= index < len(deformer.controls):
            count = len(deformer.controls)
            raise SinewError(
                f"{deformer.name} has {count} controls, counted from 0 - there is no number {index}"
            )
        with object_mode(context, obj):
            rows.remove_row(obj, deformer, index)
            if rows.rows_of(deformer):
                rigging.try_bind(obj, deformer, wait)
            else:
                bind.unbind(obj, deformer)
        return {"FINISHED"}


class SINEW_OT_control_set_rest(OnRows, BindsAll, Operator):
    """Take the current shape of all wires, or the current place of all tools, as their rest.

    All that the same ones move goes back to rest; later edits pose it
    """

    bl_idname = Operators.ROW_REST
    bl_label = "New Rest"
