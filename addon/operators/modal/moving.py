# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while a tool moves something. This needs no window, only events like Blender's."""

from abc import ABC, abstractmethod

import numpy as np
from bpy.types import Event, Object

from ...core.transform.typed_motion import TypedMotion, View
from ...session.state.background import Work
from .shell import Outcome

CANCEL = ("RIGHTMOUSE", "ESC")
WHEEL = ("WHEELUPMOUSE", "WHEELDOWNMOUSE")
NAVIGATE = ("MIDDLEMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM")


class Moving(ABC):
    """Something that mouse and keys move.

    Call ``process`` with each event until it says that the tool ends. ``CONFIRM`` are the types and values of
    the events that confirm, and ``REPEATS`` are the keys that count again while they are held.
    """

    CONFIRM = (("LEFTMOUSE", "PRESS"), ("RET", "PRESS"), ("NUMPAD_ENTER", "PRESS"))
    REPEATS: tuple[str, ...] = ("BACK_SPACE",)

    def __init__(self, typed: TypedMotion, pivot: np.ndarray, axes: np.ndarray) -> None:
        """``pivot`` (3,) in the world, ``axes`` (3, 3) local axes as columns."""
        self.typed, self.pivot = typed, pivot
        self.notice = ""  # an error that does not end the tool
        self._axes = axes
        self._ending = False

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""
        key, pressed = event.type, event.value == "PRESS"
        if key == "TIMER":
            return self.tick(obj)
        if key in NAVIGATE or key.startswith("NDOF") or (event.ctrl and key in WHEEL):
            return Outcome.PASS
        if key in CANCEL and pressed:
            self.restore(obj)
            return Outcome.CANCELLED
        if self._ending:
            return Outcome.GO_ON
        if (key, event.value) in self.CONFIRM:
            self._ending = True
            return self.end(obj)
        self.typed.hold(event.shift, event.ctrl)
        if key in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            self._point(event, view)
        elif pressed and not (event.is_repeat and key not in self.REPEATS):
            self.press(event)
        if key != "INBETWEEN_MOUSEMOVE":  # a newer position of the mouse follows in the queue
            self.show(obj)
        return Outcome.GO_ON

    @property
    def matrix(self) -> np.ndarray:
        """The current motion, as a matrix (4, 4) for points in the world."""
        return self.typed.motion.rounded.matrix(self._axes, self.pivot)

    @property
    @abstractmethod
    def job(self) -> Work | None:
        """The work of a thread, if any."""

    def press(self, event: Event) -> None:
        """A key that neither confirms nor cancels was pressed."""
        self.typed.press(event.type, event.unicode, event.shift, event.ctrl)

    def tick(self, _obj: Object) -> Outcome:
        """Some time has passed."""
        return Outcome.GO_ON

    @abstractmethod
    def show(self, obj: Object) -> None:
        """Show the current motion."""

    @abstractmethod
    def end(self, obj: Object) -> Outcome:
        """The artist confirms."""

    @abstractmethod
    def restore(self, obj: Object) -> None:
        """Put everything back."""

    def _point(self, event: Event, view: View) -> None:
        if view.same_as(self.typed.view):
            self.typed.drag(event.mouse_x, event.mouse_y)
        else:
            self.typed.change_view(view, event.mouse_x, event.mouse_y)
