# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and unbind. With a window a heavy mesh binds in a thread: progress in the status bar, Esc cancels."""

from bpy.types import Context, Event, Operator

from .. import session
from ..core.errors import SinewError
from ..ids import Operators
from .target import has_deformer, target_of
from .waiting import WaitsForBind


class SINEW_OT_bind(WaitsForBind, Operator):
    """Take the mesh as it is now for the rest shape, and prepare it to follow its handles"""

    bl_idname = Operators.BIND
    bl_label = "Bind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    def execute(self, context: Context) -> set[str]:
        return self._start(context, wait=True)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        result = self._start(context, wait=False)
        return self.wait_for(context, target_of(context).sinew.active.uid, result)

    def _start(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        try:
            session.bind(obj, deformer, wait)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
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
