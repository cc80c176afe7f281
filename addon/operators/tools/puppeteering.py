# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while a bone is dragged. This needs no window, only events like Blender's."""

import numpy as np
from bpy.types import Object

from ...core.transform.typed_motion import TypedMotion
from ...session.actions.puppet.posing import PuppetDrag
from ..modal.moving import Moving
from ..modal.shell import Outcome


class Puppeteering(Moving):
    """The bone that is being dragged. Releasing the button, or a click, keeps the pose."""

    CONFIRM = (*Moving.CONFIRM, ("LEFTMOUSE", "RELEASE"))

    def __init__(self, drag: PuppetDrag, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns."""
        super().__init__(typed, pivot, axes)
        self.drag = drag
        self._shown = b""

    @property
    def job(self) -> None:
        """None: a pose takes less than a frame."""

    def show(self, obj: Object) -> None:
        """Pose the armature, if the motion has changed."""
        matrix = self.matrix
        if matrix.tobytes() != self._shown:
            self.drag.move(obj, matrix)
            self._shown = matrix.tobytes()

    def end(self, obj: Object) -> Outcome:
        """Keep the pose."""
        self.show(obj)
        return Outcome.CONFIRMED

    def restore(self, obj: Object) -> None:
        """Pose the armature as it was."""
        self.drag.restore(obj)
