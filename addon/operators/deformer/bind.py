# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and unbind. With a window, a large mesh binds in a thread, with its progress in the status bar."""

from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions import bind
from ..offered import OnLiveDeformer
from ..reporting import reports_errors
from ..target import target_of
from ..waiting import BindingOperator


class SINEW_OT_bind(OnLiveDeformer, BindingOperator, Operator):
    """Take the current shape of the mesh as its rest shape, and prepare it to follow its controls"""

    bl_idname = Operators.BIND
    bl_label = "Bind"

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        bind.bind(obj, deformer, wait)
        self.report_state(deformer.uid)
        return {"FINISHED"}


class SINEW_OT_unbind(OnLiveDeformer, Operator):
    """Show the rest shape again. Regions and settings stay.

    The next Bind takes the places of the controls at that time as their rest
    """

    bl_idname = Operators.UNBIND
    bl_label = "Unbind"

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        bind.unbind(obj, obj.sinew.active)
        return {"FINISHED"}
