# SPDX-License-Identifier: GPL-3.0-or-later
"""What each event does while a silhouette is drawn anew. This needs no window, only events like Blender's."""

import math
from enum import Enum

import numpy as np
from bpy.types import Event, Object

from ...core.errors import SinewError
from ...core.transform.typed_motion import View
from ...session.edit_mode.sketch import TOO_SHORT, Sight, Sketch
from ..modal.moving import CANCEL, NAVIGATE, WHEEL
from ..modal.shell import Outcome
from .grabbing import RESIZE

_CONFIRM = ("LEFTMOUSE", "RET", "NUMPAD_ENTER")
_STEP = 2.0  # pixels between two points of a stroke
_SHARPER = 0.1  # per click of the wheel
_SHORTEST = 8.0  # pixels from end to end: less is a click


class Stage(Enum):
    """What the artist does at the moment."""

    WAITING = "press at one end of the part to redraw, and draw"
    DRAWING = "release at the other end"
    ADJUSTING = "the wheel changes the reach"


class Sketching:
    """A stroke that is being drawn, and then the surface that follows it.

    Call ``process`` with each event until it says that the tool ends.
    """

    job = None  # no thread works

    def __init__(self, sketch: Sketch, pivot: np.ndarray, sharpness: float) -> None:
        """``pivot`` (3,) in the world: the stroke lies at its depth."""
        self.sketch, self.pivot, self.sharpness = sketch, pivot, sharpness
        self.notice = ""  # an error that does not end the tool
        self.stage = Stage.WAITING
        self.stroke: list[np.ndarray] = []  # points (3,) in the world
        self.sight: Sight | None = None  # of the stroke
        self.radius = 0.0
        self.unlimited = False
        self._last = (0.0, 0.0)
        self._length = 0.0

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""
        key, pressed = event.type, event.value == "PRESS"
        if key in CANCEL and pressed:
            self.restore(obj)
            return Outcome.CANCELLED
        if self.stage is Stage.DRAWING:
            self._draw(obj, event, view)
        elif key in NAVIGATE or key.startswith("NDOF") or (event.ctrl and key in WHEEL):
            return Outcome.PASS
        elif self.stage is Stage.WAITING:
            if key == "LEFTMOUSE" and pressed:
                self._begin(event, view)
            elif key in WHEEL:
                return Outcome.PASS  # zooms
        elif pressed and key in _CONFIRM:
            return Outcome.CONFIRMED
        elif pressed:
            self._adjust(obj, event)
        return Outcome.GO_ON

    def restore(self, obj: Object) -> None:
        """Remove the shape key."""
        self.sketch.restore(obj)

    @property
    def reach(self) -> float:
        """How far the surface follows; infinite: all connected."""
        return math.inf if self.unlimited else self.radius

    def _begin(self, event: Event, view: View) -> None:
        self.stage, self.stroke, self._length = Stage.DRAWING, [], 0.0
        eye = None if view.eye is None else self.pivot + view.eye
        self.sight = Sight(np.array((view.right, view.up, view.toward)), eye)
        self._add(event, view)

    def _add(self, event: Event, view: View) -> None:
        x, y = event.mouse_x - view.centre[0], event.mouse_y - view.centre[1]
        self.stroke.append(self.pivot + view.pixel * (x * view.right + y * view.up))
        self._last = (event.mouse_x, event.mouse_y)

    def _draw(self, obj: Object, event: Event, view: View) -> None:
        step = math.hypot(event.mouse_x - self._last[0], event.mouse_y - self._last[1])
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE") and step >= _STEP:
            self._length += step
            self._add(event, view)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            if step > 0.0:
                self._length += step
                self._add(event, view)
            self._end(obj)

    def _end(self, obj: Object) -> None:
        """Let the surface follow. A stroke that nothing can follow is forgotten, and another may be drawn."""
        self.stage = Stage.WAITING
        if self._length < _SHORTEST:
            self.notice = TOO_SHORT
            return
        try:
            self.radius = self.sketch.draw(np.array(self.stroke), self.sight)
            self.sketch.follow(obj, self.reach, self.sharpness)
            self.stage = Stage.ADJUSTING
        except SinewError as error:
            self.notice, self.stroke = str(error), []

    def _adjust(self, obj: Object, event: Event) -> None:
        if event.shift and event.type in WHEEL:
            step = _SHARPER if event.type == "WHEELUPMOUSE" else -_SHARPER
            self.sharpness = round(self.sharpness + step, 6)
        elif event.type in RESIZE:
            self.radius *= RESIZE[event.type]
            self.unlimited = False
        elif event.type == "A" and not event.is_repeat:
            self.unlimited = not self.unlimited
        else:
            return
        try:
            self.sketch.follow(obj, self.reach, self.sharpness)
        except SinewError as error:
            self.notice = str(error)
