# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and unbind. With a window a heavy mesh binds in a thread: progress in the status bar, Esc cancels."""

from bpy.types import Context, Operator

from .. import session
from ..ids import Operators
from .refusing import refusing
from .target import has_deformer, target_of
from .waiting import BindingOperator


class SINEW_OT_bind(BindingOperator, Operator):
    """Take the mesh as it is now for the rest shape, and prepare it to follow its handles"""

    bl_idname = Operators.BIND
    bl_label = "Bind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    @refusing
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        session.bind(obj, deformer, wait)
        if deformer.status:
            self.report({"INFO"}, deformer.status)
        return {"FINISHED"}


class SINEW_OT_unbind(Operator):
    """Show the rest shape; regions and settings stay.

    The next Bind starts from where the controls are then
    """

    bl_idname = Operators.UNBIND
    bl_label = "Unbind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        session.unbind(obj, obj.sinew.active)
        return {"FINISHED"}
