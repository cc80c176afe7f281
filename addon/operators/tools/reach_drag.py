# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the active wire or tool reaches: what shows it, and the operator of its arrows."""

from typing import NamedTuple

import numpy as np
from bpy.props import EnumProperty, FloatProperty
from bpy.types import Context, Depsgraph, Event, Object, Operator

from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.methods import CONTROL_PARAMETERS
from ...core.transform.typed_motion import View
from ...ids import Operators
from ...properties import SinewControl
from ...session.actions.controls.control_list import active_row
from ...session.targets.kinds import kind_of
from ..arguments import once
from ..modal.moving import CANCEL
from ..modal.ring import ring
from ..modal.shell import Keys, Outcome, ViewportTool
from ..modal.view import length_text
from ..offered import OnLiveDeformer
from ..reporting import reports_errors
from ..target import target_of

_KEYS: Keys = (
    (("MOUSE_LMB",), "Release to Keep"),
    (("MOUSE_RMB",), "Cancel"),
    (("EVENT_SHIFT",), "Precision"),
)
_AXES = np.eye(3)
_X, _Y, _Z = _AXES
_ORIGIN = np.zeros(3)
_FINE = 0.1  # of the motion of the mouse, with Shift
LENGTHS = ("radius", "inner", "outer", "width")  # of wires, and of tools
_TOLD = {row.id: row for row in CONTROL_PARAMETERS if row.id in LENGTHS}


class Reach(NamedTuple):
    """How far a control reaches, in its own frame: ``lines`` (k, 3) show it.

    ``measured`` says from where (3,) and in which direction (3,) each of its lengths is measured.
    """

    lines: list[np.ndarray]
    measured: dict[str, tuple[np.ndarray, np.ndarray]]


def reach_of(row: SinewControl, depsgraph: Depsgraph) -> Reach | None:
    """The radius of a wire at its middle, or the lengths of a tool; None if there is nothing to show."""
    if row.object is None or row.missing:
        return None
    if row.object.type == "CURVE":
        points = kind_of(row.object).points_shown(row.object, depsgraph).astype(np.float64)
        return _around(points, row.radius)
    if row.tools == "drag":
        lines = [ring(_ORIGIN, axis, size) for size in (row.inner, row.outer) for axis in _AXES]
        return Reach(lines, {"inner": (_ORIGIN, _X), "outer": (_ORIGIN, _X)})
    lines = [ring(height * _Z, _Z, row.width) for height in (row.inner, row.outer)]
    middle = 0.5 * (row.inner + row.outer) * _Z
    return Reach(lines, {"inner": (_ORIGIN, _Z), "outer": (_ORIGIN, _Z), "width": (middle, _X)})


def _around(points: np.ndarray, radius: float) -> Reach | None:
    """A ring around the middle of a line of points (n, 3)."""
    if len(points) < 2:
        return None
    middle = len(points) // 2
    along = points[middle] - points[middle - 1]
    length = np.linalg.norm(along)
    if length == 0.0:
        return None
    across = ring(_ORIGIN, along / length, 1.0)[0]
    line = ring(points[middle], along / length, radius)
    return Reach([line], {"radius": (points[middle], across)})


def world_of(row: SinewControl, depsgraph: Depsgraph) -> np.ndarray:
    """The frame of the control of a row, (4, 4)."""
    return np.array(row.object.evaluated_get(depsgraph).matrix_world, dtype=np.float64)


class ReachDragging:
    """A length of the active wire or tool, which follows the mouse along its direction."""

    job = None  # no thread works

    def __init__(
        self, row: SinewControl, name: str, depsgraph: Depsgraph, mouse: tuple[float, float]
    ) -> None:
        reach = reach_of(row, depsgraph)
        if reach is None or name not in reach.measured:
            raise SinewError(f"{row.name} has no length that is called {_TOLD[name].label}")
        world, (place, direction) = world_of(row, depsgraph), reach.measured[name]
        self.notice = ""  # an error that does not end the tool
        self._name, self._row, self._mouse = name, row.name, mouse
        self._along = world[:3, :3] @ direction
        self.before = self.value = float(getattr(row, name))
        self.pivot = frames.transformed(world, (place + self.value * direction)[None])[0]

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""
        if event.type in CANCEL and event.value == "PRESS":
            self.restore(obj)
            return Outcome.CANCELLED
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            self._move(event, view)
            self._set(obj, self.value)
        return Outcome.CONFIRMED if (event.type, event.value) == ("LEFTMOUSE", "RELEASE") else Outcome.GO_ON

    def restore(self, obj: Object) -> None:
        """Put it back."""
        self._set(obj, self.before)

    def _move(self, event: Event, view: View) -> None:
        """Follow the mouse along the line that the direction is on the screen."""
        motion = np.array((event.mouse_x, event.mouse_y)) - self._mouse
        self._mouse = (event.mouse_x, event.mouse_y)
        way = np.array((view.right, view.up)) @ self._along / view.pixel  # pixels of a unit
        if way @ way > 1.0:
            self.value += (_FINE if event.shift else 1.0) * float(motion @ way) / float(way @ way)

    def _set(self, obj: Object, value: float) -> None:
        row = active_row(obj.sinew.active) if obj.sinew.active is not None else None
        if row is None or row.name != self._row:
            raise SinewError("The control was removed meanwhile")
        setattr(row, self._name, value)


class SINEW_OT_reach_drag(OnLiveDeformer, ViewportTool, Operator):
    """Set how far the active wire or tool reaches"""

    bl_idname = Operators.REACH_DRAG
    bl_label = "Set Reach"
    bl_options = {"REGISTER", "UNDO", "BLOCKING", "INTERNAL"}  # an arrow in the viewport begins it

    KEYS = _KEYS

    length: once(EnumProperty, items=[(row.id, row.label, row.description) for row in _TOLD.values()]).named(
        "Length", "Choose which length"
    )
    value: once(FloatProperty, unit="LENGTH").named("Value", "Set the length, in the space of the control")

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_reach_drag") -> str:
        """What the length means."""
        return f"{_TOLD[properties.length].label}: {_TOLD[properties.length].description}"

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if active_row(target_of(context).sinew.active) else "Add a wire or a tool first"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        setattr(active_row(target_of(context).sinew.active), self.length, self.value)
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        obj, mouse = target_of(context), (event.mouse_x, event.mouse_y)
        row = active_row(obj.sinew.active)
        tool = ReachDragging(row, self.length, context.evaluated_depsgraph_get(), mouse)
        return self.begin(context, tool, obj, _draw_nothing)

    def worked_on(self, context: Context) -> Object | None:
        """The object that the control moves, as long as it is in the scene."""
        return context.scene.objects.get(self.object_name)

    def store_result(self, _context: Context) -> None:
        self.value = self.tool.value

    def header(self, context: Context) -> str:
        return f"{_TOLD[self.length].label}: {length_text(context.scene.unit_settings, self.tool.value)}"


def _draw_nothing() -> None:
    """The arrows and rings themselves show it."""
