# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw Wire: draw a stroke on the surface, which becomes a wire."""

from enum import Enum
from functools import partial

import bpy
import numpy as np
from bpy.props import CollectionProperty, FloatProperty, IntProperty
from bpy.types import Context, Event, Object, Operator, OperatorStrokeElement

from ...core.errors import SinewError
from ...core.transform.typed_motion import View
from ...ids import Operators
from ...session.actions.controls import wires
from ...session.datablocks.parts import ShownParts
from ..controls.wires import POINTS, RADIUS, add_wires
from ..modal.moving import CANCEL, NAVIGATE, WHEEL
from ..modal.ring import draw_line, ring
from ..modal.shell import Keys, Outcome, ViewportTool
from ..modal.view import length_text
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import target_of
from ..waiting import BindingOperator
from .under_mouse import surface_under

_KEYS: Keys = ((("MOUSE_LMB_DRAG",), "Draw on the Surface"), (("MOUSE_RMB",), "Cancel"))
_LINE = (1.0, 0.6, 0.1, 1.0)
_RING = (1.0, 1.0, 1.0, 0.9)
_STEP = 4.0  # pixels between two places of a stroke
_FEWEST = 3  # places: less is a click


class Stage(Enum):
    """What the artist does at the moment."""

    WAITING = "press on the surface, and draw along the feature to steer"
    DRAWING = "release at the end of the wire"


class Drawing:
    """A stroke on a surface. Call ``process`` with each event until it says that the tool ends."""

    job = None  # no thread works

    def __init__(
        self, context: Context, name: str, pivot: np.ndarray, radius: float, parts: ShownParts
    ) -> None:
        """``name`` of the object to draw on; other surfaces are no part of the stroke.

        ``radius`` of the wire, in the world; 0 for one that fits the stroke and the part that it is on.
        """
        self._context, self._name, self.pivot = context, name, pivot
        self._radius, self._parts = radius, parts
        self.notice = ""  # an error that does not end the tool
        self.stage = Stage.WAITING
        self.stroke: list[np.ndarray] = []  # places (3,) in the world
        self.normal = np.array((0.0, 0.0, 1.0))  # of the surface at the last of them
        self._last = (0.0, 0.0)

    def process(self, _obj: Object, event: Event, _view: View) -> Outcome:
        """Process an event."""
        key, pressed = event.type, event.value == "PRESS"
        if key in CANCEL and pressed:
            return Outcome.CANCELLED
        if self.stage is Stage.DRAWING:
            return self._draw(event)
        if key in NAVIGATE or key.startswith("NDOF") or key in WHEEL:
            return Outcome.PASS
        if key == "LEFTMOUSE" and pressed:
            self.stage = Stage.DRAWING
            self._add(event)
        return Outcome.GO_ON

    @property
    def radius(self) -> float:
        """Of the wire that the stroke would make now."""
        if self._radius or len(self.stroke) < 2:
            return self._radius
        length = float(np.linalg.norm(np.diff(self.stroke, axis=0), axis=1).sum())
        return wires.wire_radius(length, self._parts.size_at(self.stroke[len(self.stroke) // 2]))

    def restore(self, _obj: Object) -> None:
        """Nothing: the stroke changes the scene at its end."""

    def _draw(self, event: Event) -> Outcome:
        step = abs(event.mouse_x - self._last[0]) + abs(event.mouse_y - self._last[1])
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE") and step >= _STEP:
            self._add(event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._add(event)
            if len(self.stroke) >= _FEWEST:
                return Outcome.CONFIRMED
            self.stage, self.stroke = Stage.WAITING, []
            self.notice = "The stroke is too short - press on the surface and draw"
        return Outcome.GO_ON

    def _add(self, event: Event) -> None:
        hit = surface_under(self._context, event.mouse_x, event.mouse_y)
        self._last = (event.mouse_x, event.mouse_y)
        if hit is not None and hit.obj.name == self._name:
            self.stroke.append(hit.place)
            self.normal = hit.normal


class SINEW_OT_wire_draw(OnTarget, ViewportTool, BindingOperator, Operator):
    """Draw a stroke on the surface. It becomes a curve that moves what lies near it"""

    bl_idname = Operators.WIRE_DRAW
    bl_label = "Draw Wire"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}
    MESHES_ONLY = True

    KEYS = _KEYS

    stroke: CollectionProperty(type=OperatorStrokeElement, options={"SKIP_SAVE", "HIDDEN"})
    points: IntProperty(**POINTS)
    radius: FloatProperty(**RADIUS)

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if context.mode == "OBJECT" else "Go to Object Mode to draw on the surface"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        if len(self.stroke) < 2:
            raise SinewError("There is no stroke - draw one in a 3D Viewport")
        self._make(context, target_of(context))
        return {"FINISHED"}

    def start(self, context: Context, _event: Event) -> set[str]:
        obj = target_of(context)
        pivot = np.array(obj.matrix_world.translation, dtype=np.float64)
        parts = ShownParts(obj, context.evaluated_depsgraph_get())
        tool = Drawing(context, obj.name, pivot, self.radius, parts)
        return self.begin(context, tool, obj, partial(_draw, tool))

    def worked_on(self, context: Context) -> Object | None:
        """The object that is drawn on, as long as it is in Object Mode."""
        return context.scene.objects.get(self.object_name) if context.mode == "OBJECT" else None

    @reports_errors
    def store_result(self, context: Context) -> set[str]:
        self.stroke.clear()
        for place in self.tool.stroke:
            self.stroke.add().location = place
        self._make(context, self.worked_on(context))
        return {"FINISHED"}

    def header(self, context: Context) -> str:
        radius = self.tool.radius
        text = f"{self.bl_label}: {self.tool.stage.value}"
        return text if not radius else f"{text}, radius {length_text(context.scene.unit_settings, radius)}"

    def _make(self, context: Context, obj: Object) -> None:
        places = np.array([point.location[:] for point in self.stroke], dtype=np.float64)
        wire = wires.wire_through(obj, [(places, False)], self.points, in_world=True)
        add_wires(self, context, obj, [wire], self.radius, owned=True, wait=True)


def _draw(tool: Drawing) -> None:
    """Draw the stroke, and how far its wire would reach, in each 3D Viewport."""
    context = bpy.context
    if context.region_data is None or len(tool.stroke) < 2:
        return
    draw_line(context.region, context.region_data, np.array(tool.stroke), _LINE)
    circle = ring(tool.stroke[-1], tool.normal, tool.radius)
    draw_line(context.region, context.region_data, circle, _RING)
