# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while Grab Region runs. This needs no window, only events like Blender's."""

import math

import numpy as np
from bpy.types import Event, Object

from .. import session
from ..core.errors import SinewError
from ..core.transform.typed_motion import TypedMotion, View
from .modal.shell import Outcome

CONFIRM = ("LEFTMOUSE", "RET", "NUMPAD_ENTER")
CANCEL = ("RIGHTMOUSE", "ESC")
_WHEEL = ("WHEELUPMOUSE", "WHEELDOWNMOUSE")
_NAVIGATE = ("MIDDLEMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM")
_STEP = 1.1  # factor of the radius, as in proportional editing, where wheel down enlarges it, too
_RESIZE = {
    "WHEELDOWNMOUSE": _STEP,
    "PAGE_UP": _STEP,
    "WHEELUPMOUSE": 1.0 / _STEP,
    "PAGE_DOWN": 1.0 / _STEP,
}
_REPEATS = (*_RESIZE, "BACK_SPACE")  # all other keys count once, as long as they are held


class Grabbing:
    """The selection that is being grabbed.

    Call ``process`` with each event until it says that the tool ends.
    """

    def __init__(
        self, grab: session.Grab, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray, radius: float
    ) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns; ``radius`` may be infinite."""
        self.grab, self.typed, self.pivot = grab, typed, pivot
        self.radius = radius
        self.notice = ""  # an error that does not end the tool
        self._finite = radius if math.isfinite(radius) else 1.0
        self._axes = axes
        self._ending = False
        self._last_shown: tuple[bytes, float] | None = None
        grab.follow(radius, wait=False)

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""
        key, pressed = event.type, event.value == "PRESS"
        if key == "TIMER":
            return self._tick(obj)
        if key in _NAVIGATE or key.startswith("NDOF") or (event.ctrl and key in _WHEEL):
            return Outcome.PASS
        if key in CANCEL and pressed:
            self.grab.restore(obj)
            return Outcome.CANCELLED
        if self._ending:
            return Outcome.GO_ON
        if key in CONFIRM and pressed:
            self._ending = True
            return self._end(obj)
        self.typed.hold(event.shift, event.ctrl)
        if key in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            self._point(event, view)
        elif pressed and not (event.is_repeat and key not in _REPEATS):
            self._press(event)
        if key != "INBETWEEN_MOUSEMOVE":  # a newer position of the mouse follows in the queue
            self._show(obj)
        return Outcome.GO_ON

    def restore(self, obj: Object) -> None:
        """Move every vertex back to where it was."""
        self.grab.restore(obj)

    @property
    def job(self) -> session.Work | None:
        """The bind or the final solve that runs in a thread, if any."""
        return self.grab.job

    @property
    def matrix(self) -> np.ndarray:
        """The current motion, as a matrix (4, 4) for points in the world."""
        return self.typed.motion.rounded.matrix(self._axes, self.pivot)

    def _point(self, event: Event, view: View) -> None:
        if view.same_as(self.typed.view):
            self.typed.drag(event.mouse_x, event.mouse_y)
        else:
            self.typed.change_view(view, event.mouse_x, event.mouse_y)

    def _press(self, event: Event) -> None:
        if event.type in _RESIZE:
            self._finite *= _RESIZE[event.type]
            self._follow(self._finite)
        elif event.type == "A":
            self._follow(self._finite if math.isinf(self.radius) else math.inf)
        else:
            self.typed.press(event.type, event.unicode, event.shift, event.ctrl)

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

    def _show(self, obj: Object, again: bool = False) -> None:
        """Solve if anything changed, or ``again`` to continue a preview."""
        if self.grab.radius is None:
            return
        matrix = self.matrix
        now = (matrix.tobytes(), self.grab.radius)
        if now != self._last_shown or again:
            self.grab.show(obj, matrix, preview=True)
            self._last_shown = now

    def _tick(self, obj: Object) -> Outcome:
        """Take the result of a bind that has ended, and continue a preview."""
        try:
            collected = self.grab.collect()
        except SinewError as error:
            collected = False
            self._keep_radius(error)
        if self._ending:
            return self._end(obj)
        self._show(obj, again=collected or not self.grab.settled)
        return Outcome.GO_ON

    def _end(self, obj: Object) -> Outcome:
        """Show the final shape as soon as it is computed."""
        if self.grab.is_binding or not self.grab.settle(obj, self.matrix, wait=False):
            return Outcome.GO_ON
        return Outcome.CONFIRMED
