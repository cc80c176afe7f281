# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal half of Grab Region: what each event does. Needs no window, only events like Blender's."""

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
_STEP = 1.1  # of the radius, as in proportional editing; wheel down is larger there too
_RESIZE = {
    "WHEELDOWNMOUSE": _STEP,
    "PAGE_UP": _STEP,
    "WHEELUPMOUSE": 1.0 / _STEP,
    "PAGE_DOWN": 1.0 / _STEP,
}
_REPEATS = (*_RESIZE, "BACK_SPACE")  # other keys may be held, as the one that started the tool is


class Grabbing:
    """A selection in hand. Feed it ``handle``; it moves the mesh and says when it is over."""

    def __init__(
        self, grab: session.Grab, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray, radius: float
    ) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns; ``radius`` may be infinite."""
        self.grab, self.typed, self.pivot = grab, typed, pivot
        self.radius = radius
        self.notice = ""  # a refusal that did not end the tool
        self._finite = radius if math.isfinite(radius) else 1.0
        self._axes = axes
        self._ending = False
        self._seen: tuple[bytes, float] | None = None
        grab.follow(radius, wait=False)

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Take an event in. ``view`` is how the mesh is seen now."""
        kind, pressed = event.type, event.value == "PRESS"
        if kind == "TIMER":
            return self._tick(obj)
        if kind in _NAVIGATE or kind.startswith("NDOF") or (event.ctrl and kind in _WHEEL):
            return Outcome.PASS
        if kind in CANCEL and pressed:
            self.grab.restore(obj)
            return Outcome.CANCELLED
        if self._ending:
            return Outcome.GO_ON
        if kind in CONFIRM and pressed:
            self._ending = True
            return self._end(obj)
        self.typed.hold(event.shift, event.ctrl)
        if kind in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            self._point(event, view)
        elif pressed and not (event.is_repeat and kind not in _REPEATS):
            self._press(event)
        if kind != "INBETWEEN_MOUSEMOVE":  # Blender has a newer one in the queue
            self._show(obj)
        return Outcome.GO_ON

    def restore(self, obj: Object) -> None:
        """Put every vertex back."""
        self.grab.restore(obj)

    @property
    def job(self) -> session.Work | None:
        """A bind or a final answer under way in a thread."""
        return self.grab.job

    @property
    def matrix(self) -> np.ndarray:
        """The motion of world points now, (4, 4)."""
        return self.typed.motion.rounded.matrix(self._axes, self.pivot)

    def _point(self, event: Event, view: View) -> None:
        if view.same_as(self.typed.view):
            self.typed.drag(event.mouse_x, event.mouse_y)
        else:
            self.typed.look(view, event.mouse_x, event.mouse_y)

    def _press(self, event: Event) -> None:
        if event.type in _RESIZE:
            self._finite *= _RESIZE[event.type]
            self._follow(self._finite)
        elif event.type == "A":
            self._follow(self._finite if math.isinf(self.radius) else math.inf)
        else:
            self.typed.press(event.type, event.unicode, event.shift, event.ctrl)

    def _follow(self, radius: float) -> None:
        """Another radius; where it cannot be bound, the one before stays."""
        try:
            self.grab.follow(radius, wait=False)
            self.radius = radius
        except SinewError as error:
            self._keep(error)

    def _keep(self, error: SinewError) -> None:
        if self.grab.radius is None:
            raise error
        self.notice = str(error)
        self.radius = self.grab.radius

    def _show(self, obj: Object, again: bool = False) -> None:
        """Solve where something changed, or to go on with a preview."""
        if self.grab.radius is None:
            return
        matrix = self.matrix
        now = (matrix.tobytes(), self.grab.radius)
        if now != self._seen or again:
            self.grab.show(obj, matrix, preview=True)
            self._seen = now

    def _tick(self, obj: Object) -> Outcome:
        """Time passed: a bind may be ready, a preview may go on."""
        try:
            collected = self.grab.collect()
        except SinewError as error:
            collected = False
            self._keep(error)
        if self._ending:
            return self._end(obj)
        self._show(obj, again=collected or not self.grab.settled)
        return Outcome.GO_ON

    def _end(self, obj: Object) -> Outcome:
        """The final answer, as soon as there is one."""
        if self.grab.is_binding or not self.grab.settle(obj, self.matrix, wait=False):
            return Outcome.GO_ON
        return Outcome.CONFIRMED
