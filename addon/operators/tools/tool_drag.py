# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew Drag on Clay: press on the surface and drag it. The path of the mouse becomes that of a tool."""

from enum import Enum
from functools import partial

import bpy
import numpy as np
from bpy.props import CollectionProperty, FloatProperty
from bpy.types import Context, Event, Object, Operator, OperatorStrokeElement
from mathutils import Vector

from ...core.errors import SinewError
from ...core.methods import DEFAULT_TOOL_METHOD
from ...core.transform.typed_motion import View
from ...ids import Operators
from ...properties import SinewControl, SinewDeformer
from ...session.actions import deformers, rigging
from ...session.actions.controls import control_list as rows
from ...session.datablocks.parts import ShownParts
from ...session.datablocks.surface import Hit
from ..arguments import distance, once
from ..modal.moving import CANCEL, NAVIGATE
from ..modal.ring import draw_line, ring
from ..modal.shell import Keys, Outcome, ViewportTool
from ..modal.view import length_text
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import target_of
from .grabbing import RESIZE
from .under_mouse import anything_under

_KEYS: Keys = (
    (("MOUSE_LMB_DRAG",), "Drag"),
    (("MOUSE_MMB_DRAG",), "Size"),
    (("MOUSE_RMB",), "Cancel"),
)
_RING = (1.0, 1.0, 1.0, 0.9)
_WAY = (1.0, 0.6, 0.1, 1.0)
_STOPS = 0.25  # the way between two stops, as a share of the radius
_INNER = 0.3  # of the outer radius
_NEAR = 30.0  # pixels: how far from the points of a curve, hair or a cloud a press may be


class Stage(Enum):
    """What the artist does at the moment."""

    WAITING = "press on the surface and drag"
    DRAGGING = "release to keep"


class FieldDragging:
    """A tool that is dragged. Call ``process`` with each event until it says that it ends."""

    job = None  # no thread works

    def __init__(
        self,
        context: Context,
        name: str,
        pivot: np.ndarray,
        radius: float,
        parts: ShownParts,
        inner: float = _INNER,
    ) -> None:
        """``name`` of the object to drag, ``radius`` in the world; 0 for one that fits the part there.

        Within ``inner`` of the radius, all moves as one.
        """
        self._context, self._name, self.pivot, self._parts = context, name, pivot, parts
        self._inner = inner
        self._fits = radius == 0.0
        self.radius = radius or rows.tool_reach(parts.size_at(pivot))
        self.notice = ""  # an error that does not end the tool
        self.stage = Stage.WAITING
        self.waits = True  # for a press, and for another one if that misses the object
        self.path: list[np.ndarray] = []  # places (3,) in the world, from where it was pressed on
        self.hit: Hit | None = None
        self.place = pivot  # (3,) in the world: where the tool is now
        self.uid = ""
        self._was_new = False
        self._from = (0.0, 0.0)

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""
        key, pressed = event.type, event.value == "PRESS"
        if key in CANCEL and pressed:
            self.restore(obj)
            return Outcome.CANCELLED
        moved = key in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE")
        if self.stage is Stage.DRAGGING:
            if moved:
                self._drag(obj, event, view)
            elif key == "LEFTMOUSE" and event.value == "RELEASE":
                self._drag(obj, event, view)
                return Outcome.CONFIRMED
            return Outcome.GO_ON
        if not self.waits:
            return Outcome.CANCELLED
        if key in NAVIGATE or key.startswith("NDOF") or event.ctrl:
            return Outcome.PASS
        if moved:
            self.hit = self._under(event)
        elif key in RESIZE and pressed:
            self.radius *= RESIZE[key]
            self._fits = False
        elif key == "LEFTMOUSE" and pressed:
            self.press(obj, event)
        return Outcome.GO_ON

    def restore(self, obj: Object) -> None:
        """Remove the tool again."""
        if not self.uid:
            return
        deformer = self.deformer(obj)
        if self._was_new:
            deformers.remove_deformer(obj, list(obj.sinew.deformers).index(deformer))
        else:
            rows.remove_row(obj, deformer, len(deformer.controls) - 1)
            rigging.try_bind(obj, deformer)
        self.uid = ""

    def deformer(self, obj: Object) -> SinewDeformer:
        """The deformer that has the tool; looked up each time, as lists move in memory."""
        return next(deformer for deformer in obj.sinew.deformers if deformer.uid == self.uid)

    def _under(self, event: Event) -> Hit | None:
        hit = anything_under(self._context, event.mouse_x, event.mouse_y, _NEAR)
        if hit is None or hit.obj.name != self._name:
            return None
        if self._fits:
            self.radius = rows.tool_reach(self._parts.size_at(hit.place))
        return hit

    def press(self, obj: Object, event: Event) -> None:
        """Make the tool at the mouse, if the object is there."""
        self.hit = self._under(event)
        if self.hit is None:
            self.notice = f"Press on {self._name}"
            return
        before = {deformer.uid for deformer in obj.sinew.deformers}
        deformer, refusal = begin(obj, self.hit.place, self.hit.normal, self.radius, self._inner)
        self.uid, self._was_new = deformer.uid, deformer.uid not in before
        if refusal is not None:  # the tool is removed again
            raise refusal
        self.pivot = self.place = self.hit.place
        self.path = [self.hit.place]
        self._from, self.stage = (event.mouse_x, event.mouse_y), Stage.DRAGGING

    def _drag(self, obj: Object, event: Event, view: View) -> None:
        x, y = event.mouse_x - self._from[0], event.mouse_y - self._from[1]
        self.place = place = self.path[0] + view.pixel * (x * view.right + y * view.up)
        deformer = self.deformer(obj)
        if lead(obj, deformer, deformer.controls[-1], place, self.path[-1], self.radius):
            self.path.append(place)


def begin(
    obj: Object, place: np.ndarray, normal: np.ndarray, radius: float, inner: float
) -> tuple[SinewDeformer, SinewError | None]:
    """A new tool that drags ``obj`` at a ``place`` (3,) of the world; and the error if it is not bound.

    It is rigid within ``inner`` of the ``radius``.
    """
    scale = max(obj.matrix_world.median_scale, 1e-12)
    outer = radius / scale
    tool = rows.new_tool(obj, place, normal, outer, "Drag")
    values = {"tools": "drag", "outer": outer, "inner": inner * outer}
    return rows.add_to(obj, {tool: values}, DEFAULT_TOOL_METHOD, True)


def lead(
    obj: Object,
    deformer: SinewDeformer,
    row: SinewControl,
    place: np.ndarray,
    last: np.ndarray,
    radius: float,
) -> bool:
    """Move a tool to a ``place`` (3,) of the world; whether that is a stop, far enough from the ``last``."""
    matrix = row.object.matrix_world.copy()
    matrix.translation = Vector(place)
    row.object.matrix_world = matrix
    bpy.context.view_layer.update()
    if np.linalg.norm(place - last) < _STOPS * radius:
        return False
    rows.stop_here(obj, deformer, row)
    return True


class SINEW_OT_tool_drag(OnTarget, ViewportTool, Operator):
    """Drag the surface like clay: its volume stays, and it never cuts itself. The path is kept"""

    bl_idname = Operators.TOOL_DRAG
    bl_label = "Sinew Drag: Clay"
    bl_options = {"REGISTER", "UNDO", "BLOCKING", "INTERNAL"}  # buttons start the tool that calls this

    KEYS = _KEYS

    path: CollectionProperty(type=OperatorStrokeElement, options={"SKIP_SAVE", "HIDDEN"})
    radius: distance(
        "Radius",
        "Set how far the drag reaches; 0 for a third of the size of the part that is pressed",
        options={"SKIP_SAVE"},
    )
    inner: once(FloatProperty, default=_INNER, min=0.0, max=0.99, subtype="FACTOR").named(
        "Inner", "Set the share of the radius within which all moves as one"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if context.mode in ("OBJECT", "POSE") else "Go to Object Mode to drag the surface"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        if len(self.path) < 2:
            raise SinewError("There is no path - drag in a 3D Viewport")
        obj, places = target_of(context), [np.array(point.location, dtype=float) for point in self.path]
        radius = self.radius or rows.tool_reach(_parts(context, obj).size_at(places[0]))
        deformer, refusal = begin(obj, places[0], np.array((0.0, 0.0, 1.0)), radius, self.inner)
        if refusal is not None:
            raise refusal
        last = places[0]
        for place in places[1:]:
            if lead(obj, deformer, deformer.controls[-1], place, last, radius):
                last = place
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        """Wait for a press, unless one has called this."""
        obj = target_of(context)
        pivot = np.array(obj.matrix_world.translation, dtype=np.float64)
        tool = FieldDragging(context, obj.name, pivot, self.radius, _parts(context, obj), self.inner)
        if (event.type, event.value) == ("LEFTMOUSE", "PRESS"):
            tool.press(obj, event)
            tool.waits = False
        return self.begin(context, tool, obj, partial(_draw, tool))

    def worked_on(self, context: Context) -> Object | None:
        """The object that is dragged, as long as it is in the scene."""
        return context.scene.objects.get(self.object_name)

    def store_result(self, context: Context) -> None:
        self.radius = self.tool.radius
        self.path.clear()
        row = self.tool.deformer(self.worked_on(context)).controls[-1]
        for place in (*self.tool.path, np.array(row.object.matrix_world.translation)):
            self.path.add().location = place

    def header(self, context: Context) -> str:
        length = length_text(context.scene.unit_settings, self.tool.radius)
        return f"{self.bl_label}: {self.tool.stage.value}, radius {length}"


def _parts(context: Context, obj: Object) -> ShownParts:
    return ShownParts(obj, context.evaluated_depsgraph_get())


def _draw(tool: FieldDragging) -> None:
    """Draw the reach under the mouse or around the tool, and the way so far, in each 3D Viewport."""
    context = bpy.context
    if context.region_data is None:
        return
    if tool.hit is not None:
        place = tool.hit.place if tool.stage is Stage.WAITING else tool.place
        circle = ring(place, tool.hit.normal, tool.radius)
        draw_line(context.region, context.region_data, circle, _RING)
    if len(tool.path) > 1:
        draw_line(context.region, context.region_data, np.array(tool.path), _WAY)
