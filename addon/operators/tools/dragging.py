# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while a drag on the surface runs. This needs no window, only events like Blender's."""

import numpy as np
from bpy.types import Object

from ...core.transform.typed_motion import TypedMotion
from ...session.actions.drag import Drag
from ...session.state.background import Work
from ..modal.moving import Moving
from ..modal.shell import Outcome


class Dragging(Moving):
    """The handle that is being dragged. Releasing the button keeps it where it is."""

    CONFIRM = (("LEFTMOUSE", "RELEASE"), ("RET", "PRESS"), ("NUMPAD_ENTER", "PRESS"))

    def __init__(self, drag: Drag, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray) -> None:
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
        """Keep the handle. A thread that binds goes on."""
        self.show(obj)
        return Outcome.CONFIRMED

    def restore(self, obj: Object) -> None:
        """Remove what the drag made, or move the control back."""
        self.drag.restore(obj)
