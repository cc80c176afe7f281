# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag a point of a cage, a lattice or a wire, or a clay tool, without Edit Mode."""

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ...core.errors import SinewError
from ...ids import Operators
from ...session.actions.control_drag import ControlDrag
from ..arguments import given, once
from ..modal.motion_properties import MotionValues
from ..modal.view import axes_of, view_of
from ..offered import Offered
from ..reporting import reports_errors
from ..target import object_named
from .dragging import Dragging, Drags


class SINEW_OT_control_drag(Offered, MotionValues, Drags, Operator):
    """Drag a point of the cage, the lattice or a wire, or a tool as a whole"""

    bl_idname = Operators.CONTROL_DRAG
    bl_label = "Sinew Drag: Control"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING", "INTERNAL"}  # it begins with a press

    control: given(StringProperty).named("Control", "Give the name of the object")
    point: once(IntProperty, default=-1, min=-1).named(
        "Point", "Choose the point by its number in the mesh, lattice or curve; -1 is the whole object"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.mode in ("OBJECT", "POSE") else "Go to Object Mode to drag a control"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        control = object_named(context, self.control)
        drag = ControlDrag(control, self.point)
        try:
            drag.move(control, self.motion.matrix(axes_of(control.matrix_world), drag.place(control)))
        except SinewError:
            drag.restore(control)
            raise
        self._keep(context, control, drag)
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        control = object_named(context, self.control)
        drag = ControlDrag(control, self.point)
        place, axes = drag.place(control), axes_of(control.matrix_world)
        typed = self.typed_motion(context, event, view_of(context, place), axes)
        return self.begin(context, Dragging(drag, typed, place, axes), control, _draw_nothing)

    def store_result(self, context: Context) -> None:
        self.store_motion(self.tool.typed.motion)
        self._keep(context, self.worked_on(context), self.tool.drag)

    def draw(self, _context: Context) -> None:
        self.draw_motion()

    def _keep(self, context: Context, control: Object, drag: ControlDrag) -> None:
        bpy.context.view_layer.update()
        if context.scene.tool_settings.use_keyframe_insert_auto:
            drag.key(control)


def _draw_nothing() -> None:
    """The control itself shows what moves."""
