# SPDX-License-Identifier: GPL-3.0-or-later
"""Cancel a bind that is running, and watch one that started by itself."""

from bpy.props import StringProperty
from bpy.types import Context, Event, Operator

from .. import session
from ..ids import Operators
from .target import has_deformer, target_of
from .waiting import WaitsForBind


class SINEW_OT_cancel(Operator):
    """Cancel the bind that is running. The mesh shows its rest shape; Bind starts again"""

    bl_idname = Operators.CANCEL
    bl_label = "Cancel Bind"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_deformer(cls, context):
            return False
        if session.job(target_of(context).sinew.active.uid) is None:
            cls.poll_message_set("Nothing is being bound")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        session.cancel(target_of(context).sinew.active.uid)
        self.report({"WARNING"}, session.CANCELLED)
        return {"FINISHED"}


class SINEW_OT_watch(WaitsForBind, Operator):
    """Show the progress of a bind that started by itself, and let Esc cancel it"""

    bl_idname = Operators.WATCH
    bl_label = "Watch Bind"
    bl_options = {"INTERNAL"}

    uid: StringProperty(name="Key", description="The key of the deformer being bound", options={"HIDDEN"})

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.wait_for(context, self.uid, {"CANCELLED"})
