# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while Grab Once runs. This needs no window, only events like Blender's."""

import math

import numpy as np
from bpy.types import Event, Object

from ...core.errors import SinewError
from ...core.transform.typed_motion import TypedMotion
from ...session.edit_mode.grab import Grab
from ...session.state.background import Work
from ..modal.moving import Moving
from ..modal.shell import Outcome

_STEP = 1.1  # factor of the radius, as in proportional editing, where wheel down enlarges it, too
RESIZE = {  # by the event
    "WHEELDOWNMOUSE": _STEP,
    "PAGE_UP": _STEP,
    "WHEELUPMOUSE": 1.0 / _STEP,
    "PAGE_DOWN": 1.0 / _STEP,
}


class Grabbing(Moving):
    """The selection that is being grabbed."""

    REPEATS = (*RESIZE, *Moving.REPEATS)

    def __init__(
        self, grab: Grab, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray, radius: float
    ) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns; ``radius`` may be infinite."""
        super().__init__(typed, pivot, axes)
        self.grab = grab
        self.radius = radius
        self._finite = radius if math.isfinite(radius) else 1.0
        self._last_shown: tuple[bytes, float] | None = None
        grab.follow(radius, wait=False)

    def restore(self, obj: Object) -> None:
        """Move every vertex back to where it was."""
        self.grab.restore(obj)

    @property
    def job(self) -> Work | None:
        """The bind or the final solve that runs in a thread, if any."""
        return self.grab.job

    def press(self, event: Event) -> None:
        """Page Up, Page Down and the wheel change the radius; A switches to the whole surface."""
        if event.type in RESIZE:
            self._finite *= RESIZE[event.type]
            self._follow(self._finite)
        elif event.type == "A":
            self._follow(self._finite if math.isinf(self.radius) else math.inf)
        else:
            super().press(event)

    def _follow(self, radius: float) -> None:
        """Change the radius. If it cannot be bound, the previous radius stays."""
        try:
            self.grab.follow(radius, wait=False)
            self.radius = radius
        except SinewError as error:
            self._keep_radius(error)

    def _keep_radius(self, error: SinewError) -> None:
        if self.grab.radius is None:
            raise error
        self.notice = str(error)
        self.radius = self.grab.radius

    def show(self, obj: Object, again: bool = False) -> None:
        """Solve if anything changed, or ``again`` to continue a preview."""
        if self.grab.radius is None:
            return
        matrix = self.matrix
        now = (matrix.tobytes(), self.grab.radius)
        if now != self._last_shown or again:
            self.grab.show(obj, matrix, preview=True)
            self._last_shown = now

    def tick(self, obj: Object) -> Outcome:
        """Take the result of a bind that has ended, and continue a preview."""
        try:
            collected = self.grab.collect()
        except SinewError as error:
            collected = False
            self._keep_radius(error)
        if self._ending:
            return self.end(obj)
        self.show(obj, again=collected or not self.grab.settled)
        return Outcome.GO_ON

    def end(self, obj: Object) -> Outcome:
        """Show the final shape as soon as it is computed."""
        if self.grab.is_binding or not self.grab.settle(obj, self.matrix, wait=False):
            return Outcome.GO_ON
        return Outcome.CONFIRMED
