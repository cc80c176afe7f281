# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag a point of a cage, a lattice or a wire, or a clay tool, without Edit Mode."""

import bpy
import numpy as np
from bpy.props import IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ...core.errors import SinewError
from ...core.transform.typed_motion import TypedMotion
from ...ids import Operators
from ...session.actions.control_drag import ControlDrag
from ..arguments import once
from ..modal.motion_properties import MOTION_KEYS, MotionValues
from ..modal.moving import Moving
from ..modal.shell import Keys, Outcome, ViewportTool
from ..modal.view import axes_of, length_text, view_of
from ..offered import Offered
from ..reporting import reports_errors
from ..target import object_named

_KEYS: Keys = ((("MOUSE_LMB",), "Release to Keep"), (("MOUSE_RMB",), "Cancel"), *MOTION_KEYS)


class ControlDragging(Moving):
    """The part of a control that is being dragged. Releasing the button keeps it where it is."""

    CONFIRM = (("LEFTMOUSE", "RELEASE"), ("RET", "PRESS"), ("NUMPAD_ENTER", "PRESS"))
    job = None  # no thread works

    def __init__(self, drag: ControlDrag, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns."""
        super().__init__(typed, pivot, axes)
        self.drag = drag

    def show(self, obj: Object) -> None:
        """Move it. The next evaluation solves."""
        self.drag.move(obj, self.matrix)

    def end(self, obj: Object) -> Outcome:
        """Keep it."""
        self.show(obj)
        return Outcome.CONFIRMED

    def restore(self, obj: Object) -> None:
        """Put it back."""
        self.drag.restore(obj)


class SINEW_OT_control_drag(Offered, MotionValues, ViewportTool, Operator):
    """Drag a point of the cage, the lattice or a wire, or a tool as a whole"""

    bl_idname = Operators.CONTROL_DRAG
    bl_label = "Sinew Drag: Control"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING", "INTERNAL"}  # it begins with a press

    KEYS = _KEYS

    control: StringProperty(
        name="Control", description="Give the name of the object", options={"SKIP_SAVE", "HIDDEN"}
    )
    point: once(
        IntProperty,
        "Point",
        "Choose the point by its number in the mesh, lattice or curve; -1 is the whole object",
        default=-1,
        min=-1,
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
        return self.begin(context, ControlDragging(drag, typed, place, axes), control, _draw_nothing)

    def worked_on(self, context: Context) -> Object | None:
        """The control, as long as it is in the scene."""
        return context.scene.objects.get(self.object_name)

    def store_result(self, context: Context) -> None:
        self.store_motion(self.tool.typed.motion)
        self._keep(context, self.worked_on(context), self.tool.drag)

    def header(self, context: Context) -> str:
        settings = context.scene.unit_settings
        return f"{self.tool.typed.header(lambda value: length_text(settings, value))}   {self.control}"

    def draw(self, _context: Context) -> None:
        self.draw_motion()

    def _keep(self, context: Context, control: Object, drag: ControlDrag) -> None:
        bpy.context.view_layer.update()
        if context.scene.tool_settings.use_keyframe_insert_auto:
            drag.key(control)


def _draw_nothing() -> None:
    """The control itself shows what moves."""
