# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw Outline: draw the outline of a mesh anew, and its surface follows."""

import math
from functools import partial

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)
from bpy.types import Context, Event, Object, Operator, OperatorStrokeElement
from mathutils import Vector

from ...core.errors import SinewError
from ...core.geometry import frames
from ...ids import Operators
from ...properties import field
from ...session.edit_mode import sketch as tools_sketch
from ...session.edit_mode.sketch import Sight, Sketch
from ..arguments import distance, given, once
from ..modal.ring import draw_line
from ..modal.shell import Keys, ViewportTool
from ..modal.view import axes_of, length_text
from ..offered import Offered
from ..reporting import reports_errors
from .sketching import Sketching, Stage

_KEYS: Keys = (
    (("MOUSE_LMB_DRAG",), "Draw"),
    (("MOUSE_LMB",), "Confirm"),
    (("MOUSE_RMB",), "Cancel"),
    (("MOUSE_MMB_DRAG",), "Reach"),
    (("EVENT_SHIFT", "MOUSE_MMB_DRAG"), "Sharpness"),
    (("EVENT_A",), "Whole Surface"),
)
_LINES = (
    ("SILHOUETTE", "Silhouette", "The outline or contour of the mesh that is nearest", "NONE", 0),
    ("EDGES", "Selected Edges", "The line of edges that are selected in Edit Mode", "NONE", 1),
)
_STROKE = (1.0, 0.6, 0.1, 1.0)
_LINE = (1.0, 1.0, 1.0, 0.6)
_NAME = "Silhouette Stroke"


class SINEW_OT_silhouette_sketch(Offered, ViewportTool, Operator):
    """Draw the outline of the mesh anew with a stroke; the surface around follows and keeps its details.

    Begin and end on the outline. The result is a shape key
    """

    bl_idname = Operators.SILHOUETTE_SKETCH
    bl_label = "Draw Outline"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    KEYS = _KEYS

    stroke: once(StringProperty).named("Stroke", "Give the name of a curve object to take as the stroke")
    points: CollectionProperty(type=OperatorStrokeElement, options={"SKIP_SAVE", "HIDDEN"})
    view: given(FloatVectorProperty, size=(4, 4), subtype="MATRIX").named(
        "View",
        "Choose where the viewer is and how turned, as the matrix of a camera in the world; if "
        "it is not given, the view is that of the camera",
    )
    perspective: given(BoolProperty).named(
        "Perspective", "Choose whether the view by a matrix is that of a near eye rather than orthographic"
    )
    shape_key: once(StringProperty).named(
        "Shape Key",
        "Give the name of a shape key to redraw, for example after its stroke was edited; if empty, a new "
        "one is made",
    )
    line: field(EnumProperty, items=_LINES).named("Line", "Choose what the stroke redraws")
    reach: distance(
        "Reach",
        "Set how far from the line, along the surface, vertices follow; the others stay",
        default=1.0,
        soft_min=0.001,
        options={"SKIP_SAVE"},
    )
    unlimited: once(BoolProperty).named(
        "Whole Surface", "Move everything that is connected with the line, at any distance"
    )
    use_hidden: field(BoolProperty).named(
        "Hidden Lines", "Redraw silhouettes, too, that the mesh itself hides in this view"
    )
    sharpness: once(FloatProperty, min=-1.0, soft_min=0.0, soft_max=3.0).named(
        "Sharpness",
        "Set how much curvature is added along the line, as a multiple of its own: a crease above 0, a "
        "softer line below",
    )
    keep_stroke: once(BoolProperty).named(
        "Keep Stroke", "Leave the stroke in the scene as a curve, which can be edited and sketched with again"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        if context.mode == "OBJECT" and context.object is not None and context.object.type == "MESH":
            return ""
        return "Go to Object Mode and make the mesh active whose outline you want to redraw"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = context.object
        stroke, sight = self._stroke(context), self._sight(context)
        sketch = Sketch(obj, self.line == "EDGES", self.shape_key, self.use_hidden)
        radius = sketch.draw(stroke, sight)
        if not self.properties.is_property_set("reach"):
            self.reach = radius
        try:
            sketch.follow(obj, math.inf if self.unlimited else self.reach, self.sharpness)
        except SinewError:
            sketch.restore(obj)
            raise
        self._keep(context, stroke)
        return {"FINISHED"}

    def invoke(self, context: Context, event: Event) -> set[str]:
        return self.execute(context) if self.stroke else super().invoke(context, event)

    def start(self, context: Context, _event: Event) -> set[str]:
        obj = context.object
        sketch = Sketch(obj, self.line == "EDGES", self.shape_key, self.use_hidden)
        tool = Sketching(sketch, _pivot(context, obj), self.sharpness)
        return self.begin(context, tool, obj, partial(_draw, tool))

    def worked_on(self, context: Context) -> Object | None:
        """The active object, as long as it is in Object Mode."""
        return context.object if context.mode == "OBJECT" else None

    def store_result(self, context: Context) -> None:
        tool = self.tool
        self.unlimited, self.reach, self.sharpness = tool.unlimited, tool.radius, tool.sharpness
        self.points.clear()
        for place in tool.stroke:
            self.points.add().location = place
        matrix = np.eye(4)
        matrix[:3, :3] = tool.sight.axes.T
        if tool.sight.eye is not None:
            matrix[:3, 3] = tool.sight.eye
        self.view = matrix.tolist()
        self.perspective = tool.sight.eye is not None
        self._keep(context, np.array(tool.stroke))

    def header(self, context: Context) -> str:
        tool = self.tool
        if tool.stage is not Stage.ADJUSTING:
            return f"{self.bl_label}: {tool.stage.value}"
        length = length_text(context.scene.unit_settings, tool.radius)
        reach = "whole surface" if tool.unlimited else f"reach {length}"
        return f"{self.bl_label}: {reach}, sharpness {tool.sharpness:g}"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if not self.points:
            layout.prop_search(self, "stroke", bpy.data, "objects")
        layout.prop(self, "line")
        hidden = layout.row()
        hidden.active = self.line == "SILHOUETTE"
        hidden.prop(self, "use_hidden")
        row = layout.row()
        row.active = not self.unlimited
        row.prop(self, "reach")
        layout.prop(self, "unlimited")
        layout.prop(self, "sharpness")
        layout.prop(self, "keep_stroke")

    def _stroke(self, context: Context) -> np.ndarray:
        """The stroke (s, 3) in the world: of a curve object, or what was drawn."""
        if not self.stroke:
            if not self.points:
                raise SinewError("There is no stroke - draw one, or name a curve object as the stroke")
            return np.array([point.location[:] for point in self.points], dtype=np.float64)
        curve = bpy.data.objects.get(self.stroke)
        if curve is None:
            raise SinewError(f"There is no object {self.stroke}")
        return tools_sketch.stroke_of(curve, context.evaluated_depsgraph_get())

    def _sight(self, context: Context) -> Sight:
        if self.properties.is_property_set("view"):
            found, perspective, name = self.view, self.perspective, "The view"
        else:
            camera = context.scene.camera
            if camera is None or camera.type != "CAMERA":
                raise SinewError("The scene has no camera - add one, or give the matrix of a view")
            if camera.data.type == "PANO":
                raise SinewError(f"{camera.name} is panoramic - make it perspective or orthographic")
            found, perspective, name = camera.matrix_world, camera.data.type == "PERSP", camera.name
        matrix = np.array(found, dtype=np.float64)
        frames.inverse(matrix, name)  # refused if it has none
        return Sight(axes_of(matrix).T, matrix[:3, 3] if perspective else None)

    def _keep(self, context: Context, stroke: np.ndarray) -> None:
        if self.keep_stroke and not self.stroke:
            tools_sketch.keep_stroke(_NAME, stroke, context.collection)


def _pivot(context: Context, obj: Object) -> np.ndarray:
    """The middle of the mesh in the world, or the centre of the view where that is behind the viewer."""
    box = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
    middle = 0.5 * (box.min(axis=0) + box.max(axis=0))
    view = context.region_data
    before = view is None or (view.perspective_matrix @ Vector((*middle, 1.0))).w > 0.0
    return middle if before and np.isfinite(middle).all() else np.array(view.view_location, dtype=np.float64)


def _draw(tool: Sketching) -> None:
    """Draw the stroke, and the line that it redraws, in each 3D Viewport."""
    context = bpy.context
    if context.region_data is None:
        return
    if tool.stage is Stage.ADJUSTING:
        draw_line(context.region, context.region_data, tool.sketch.line, _LINE)
    if len(tool.stroke) > 1:
        draw_line(context.region, context.region_data, np.array(tool.stroke), _STROKE)
