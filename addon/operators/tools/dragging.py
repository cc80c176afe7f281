# SPDX-License-Identifier: GPL-3.0-or-later
"""What an operator that drags has, and what each event does meanwhile."""

import numpy as np
from bpy.types import Context, Object

from ...core.transform.typed_motion import TypedMotion
from ...session.actions.control_drag import ControlDrag
from ...session.actions.drag import Drag
from ...session.state.background import Work
from ..modal.motion_properties import MOTION_KEYS
from ..modal.moving import Moving
from ..modal.shell import Keys, Outcome, ViewportTool
from ..modal.view import length_text


class Drags(ViewportTool):
    """Mixin for an operator whose modal tool has a ``drag`` with a ``name``, on an object of the scene."""

    KEYS: Keys = ((("MOUSE_LMB",), "Release to Keep"), (("MOUSE_RMB",), "Cancel"), *MOTION_KEYS)

    def worked_on(self, context: Context) -> Object | None:
        """The object that is dragged on, as long as it is in the scene."""
        return context.scene.objects.get(self.object_name)

    def header(self, context: Context) -> str:
        settings = context.scene.unit_settings
        motion = self.tool.typed.header(lambda value: length_text(settings, value))
        return f"{motion}   {self.tool.drag.name}"


class Dragging(Moving):
    """The handle, or the part of a control, that is being dragged; releasing the button keeps it there.

    It needs no window, only events like Blender's.
    """

    CONFIRM = (("LEFTMOUSE", "RELEASE"), ("RET", "PRESS"), ("NUMPAD_ENTER", "PRESS"))

    def __init__(
        self, drag: Drag | ControlDrag, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray
    ) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns."""
        super().__init__(typed, pivot, axes)
        self.drag = drag

    @property
    def job(self) -> Work | None:
        """The bind that runs in a thread, if any."""
        return self.drag.job

    def show(self, obj: Object) -> None:
        """Move the control. The next evaluation solves, as for every motion of a control."""
        self.drag.move(obj, self.matrix)

    def end(self, obj: Object) -> Outcome:
        """Keep it. A thread that binds goes on."""
        self.show(obj)
        return Outcome.CONFIRMED

    def restore(self, obj: Object) -> None:
        """Remove what the drag made, or move the control back."""
        self.drag.restore(obj)
