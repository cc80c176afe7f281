# SPDX-License-Identifier: GPL-3.0-or-later
"""Cancel what a thread is working on, and watch a bind that started by itself."""

from bpy.props import StringProperty
from bpy.types import Context, Event, Operator

from ...ids import Operators
from ...properties import field
from ...session.actions.controls import making
from ...session.evaluation import binding
from ...session.evaluation.binding import CANCELLED
from ..offered import OnTarget
from ..target import target_of
from ..waiting import WaitsForBind


class SINEW_OT_cancel(OnTarget, Operator):
    """Cancel the bind, or the making of a cage, that is running.

    After a bind the mesh shows its rest shape; Bind starts again
    """

    bl_idname = Operators.CANCEL
    bl_label = "Cancel Bind"
    bl_options = {"REGISTER"}

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        obj = target_of(context)
        active = obj.sinew.active
        is_bound_now = active is not None and binding.job(active.uid) is not None
        return (
            "" if is_bound_now or making.cage_work(obj.name) is not None else "Nothing is being bound or made"
        )

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        if making.cage_work(obj.name) is not None:
            making.drop_cage(obj.name)  # whoever began it says so
            return {"FINISHED"}
        binding.cancel(obj.sinew.active.uid)
        self.tell({"WARNING"}, CANCELLED)
        return {"FINISHED"}


class SINEW_OT_watch(WaitsForBind, Operator):
    """Show the progress of a bind that started by itself, and let Esc cancel it"""

    bl_idname = Operators.WATCH
    bl_label = "Watch Bind"
    bl_options = {"INTERNAL"}

    uid: field(StringProperty, options={"HIDDEN"}).named("Key", "The key of the deformer being bound")

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.wait_for(context, self.uid, {"CANCELLED"})
