# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag Surface: in Object Mode, make a handle where one presses on a mesh, or take one that is there."""

import math
from collections.abc import Callable
from functools import partial

import bpy
import numpy as np
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty
from bpy.types import Context, Event, Object, Operator, SpaceView3D
from bpy_extras import view3d_utils

from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.methods import DEFAULT_GRIP_METHOD, DEFAULT_METHOD
from ...ids import Operators
from ...session.actions.drag import Brush, Drag
from ...session.controls import kinds
from ...session.datablocks import parts, surface
from ...session.datablocks.surface import Hit
from ...session.evaluation import binding
from ...session.targets import targets
from ..arguments import REGION_METHODS, distance, method_choice
from ..handles.handle import select_control
from ..modal.motion_properties import MOTION_KEYS, MotionProperties
from ..modal.ring import draw_line, ring
from ..modal.shell import Keys, ViewportTool
from ..modal.view import axes_of, length_text, view_of
from ..offered import Offered
from ..reporting import reports_errors
from .dragging import Dragging

_KEYS: Keys = ((("MOUSE_LMB",), "Release to Keep"), (("MOUSE_RMB",), "Cancel"), *MOTION_KEYS)
_OF_PART = 0.25  # the most of its part that a new handle takes
HANDLE, REACH = (1.0, 1.0, 1.0, 0.9), (1.0, 1.0, 1.0, 0.3)  # the colours of the two rings
_NOT_HELD = "Nothing holds this part, so all of it moves - click on it to make handles that stay"
_NOTHING = "There is nothing to drag at this place - press on a surface, or on a curve, hair or a cloud"


class SINEW_OT_drag(Offered, MotionProperties, ViewportTool, Operator):
    """Drag the surface: a handle is made where you press, or taken if there is one, and moves with the mouse.

    A click alone makes a handle that stays, and holds what is around it
    """

    bl_idname = Operators.DRAG
    bl_label = "Drag Surface"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING", "INTERNAL"}  # it begins with a press

    KEYS = _KEYS
    LENGTHS = ("radius", "reach")
    running = False  # while the mouse drags, nothing else needs to be drawn at it

    method: method_choice(
        REGION_METHODS,
        "Method of a new deformer; an existing deformer keeps its own",
        default=DEFAULT_METHOD,
        options={"SKIP_SAVE"},
    )
    origin: FloatVectorProperty(
        name="Origin",
        subtype="XYZ",
        options={"SKIP_SAVE", "HIDDEN"},
        description="Where the line of sight begins that meets the surface",
    )
    direction: FloatVectorProperty(
        name="Direction",
        subtype="XYZ",
        default=(0.0, 0.0, -1.0),
        options={"SKIP_SAVE", "HIDDEN"},
        description="The direction of the line of sight",
    )
    pixels: IntProperty(
        name="Radius",
        subtype="PIXEL",
        default=30,
        min=1,
        soft_max=300,
        options={"HIDDEN"},
        description="How large a new handle is on the screen; vertices within it move as one piece",
    )
    radius: distance(
        "Radius",
        "How far from the place, along the surface, vertices belong to a new handle",
        default=0.25,
        soft_min=0.001,
        options={"SKIP_SAVE"},
    )
    reach: FloatProperty(
        name="Reach",
        default=3.0,
        min=1.0,
        soft_max=20.0,
        description="How many radii far the surface follows a new handle, unless other regions hold it",
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.mode == "OBJECT" else "Go to Object Mode to drag a surface"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        hit = surface.first_hit(
            context.evaluated_depsgraph_get(), np.array(self.origin), np.array(self.direction), _is_shown
        )
        if hit is None:
            hit = _beside_ray(context, np.array(self.origin), np.array(self.direction), self.radius)
        if hit is None:
            raise SinewError(_NOTHING)
        drag = self._drag(context, hit, wait=True)
        try:
            drag.move(hit.obj, self.motion.matrix(axes_of(drag.frame), hit.place))
        except SinewError:
            drag.restore(hit.obj)
            raise
        context.view_layer.update()
        self._keep(context, hit.obj, drag)
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        self.origin, self.direction = _sight(context, event.mouse_x, event.mouse_y)
        hit = surface_under(context, event.mouse_x, event.mouse_y)
        if hit is None:
            hit = _beside_mouse(context, event.mouse_x, event.mouse_y, self.direction, self.pixels)
        if hit is None:
            self.report({"INFO"}, _NOTHING)
            return {"CANCELLED"}
        view = view_of(context, hit.place)
        if not self.properties.is_property_set("radius"):
            self.radius = handle_radius(context, hit, self.pixels)
        drag = self._drag(context, hit, wait=False)
        axes = axes_of(drag.frame)
        typed = self.typed_motion(context, event, view, axes)
        tool = Dragging(drag, typed, hit.place, axes)
        binding.watch(drag.uid)
        SINEW_OT_drag.running = True
        rings = []
        if drag.is_new:
            rings.append(ring(hit.place, hit.normal, self.radius))
            if drag.is_region and not self.unlimited:
                rings.append(ring(hit.place, hit.normal, self.reach * self.radius))
        return self.begin(context, tool, hit.obj, partial(_draw_rings, tool, rings))

    def worked_on(self, context: Context) -> Object | None:
        """The object that was met, as long as it is in the scene."""
        return context.scene.objects.get(self.object_name)

    def store_result(self, context: Context) -> None:
        self.store_motion(self.tool.typed.motion)
        self._keep(context, self.worked_on(context), self.tool.drag)

    def header(self, context: Context) -> str:
        settings = context.scene.unit_settings
        motion = self.tool.typed.header(lambda value: length_text(settings, value))
        return f"{motion}   {self.tool.drag.name}"

    def _leave(self, context: Context, result: set[str]) -> set[str]:
        binding.watch(self.tool.drag.uid, False)
        SINEW_OT_drag.running = False
        return super()._leave(context, result)

    def _drag(self, context: Context, hit: Hit, wait: bool) -> Drag:
        reach = math.inf if self.unlimited else self.reach * self.radius
        if not (targets.is_mesh(hit.obj) or self.properties.is_property_set("method")):
            self.method = DEFAULT_GRIP_METHOD
        brush = Brush(self.choose_method(context).id, self.radius, reach)
        drag = Drag(hit, context.evaluated_depsgraph_get(), brush, wait)
        if not drag.is_held:
            self.report({"INFO"}, _NOT_HELD)
        return drag

    def _keep(self, context: Context, obj: Object, drag: Drag) -> None:
        """Select the control. The handle is kept even if its control cannot be selected."""
        if context.scene.tool_settings.use_keyframe_insert_auto:
            drag.key(obj)
        try:
            select_control(context, obj, drag.handle_of(obj))
        except SinewError as error:
            self.report({"WARNING"}, str(error))


def handle_radius(context: Context, hit: Hit, pixels: int) -> float:
    """How large a new handle is: so many pixels, and at most a share of the loose part that it is on."""
    size = parts.shown_parts(hit.obj, context.evaluated_depsgraph_get()).size_at(hit.place)
    return min(pixels * view_of(context, hit.place).pixel, _OF_PART * size)


def surface_under(context: Context, x: float, y: float) -> Hit | None:
    """The surface that a 3D Viewport shows at a pixel of the window; None if there is none."""
    origin, direction = _sight(context, x, y)
    shows = partial(_is_shown_in, context.space_data)
    return surface.first_hit(context.evaluated_depsgraph_get(), np.array(origin), np.array(direction), shows)


def _beside_ray(context: Context, origin: np.ndarray, direction: np.ndarray, radius: float) -> Hit | None:
    """The point of a curve, text, hair or cloud that is nearest to a line of sight, within a radius."""
    along = direction / np.linalg.norm(direction)

    def apart(places: np.ndarray) -> np.ndarray:
        away = places - origin
        depth = away @ along
        return np.where(depth > 0.0, np.linalg.norm(away - depth[:, None] * along, axis=1), np.inf)

    return _nearest(context, along, _is_shown, apart, radius)


def _beside_mouse(context: Context, x: float, y: float, direction: tuple, pixels: int) -> Hit | None:
    """The point of a curve, text, hair or cloud that the viewport shows nearest to a pixel of the window."""
    region, matrix = context.region, np.array(context.region_data.perspective_matrix)

    def apart(places: np.ndarray) -> np.ndarray:
        seen = np.column_stack((places, np.ones(len(places)))) @ matrix.T
        with np.errstate(divide="ignore", invalid="ignore"):
            at = (0.5 + 0.5 * seen[:, :2] / seen[:, 3:]) * (region.width, region.height)
        far = np.linalg.norm(at - (x - region.x, y - region.y), axis=1)
        return np.where(seen[:, 3] > 0.0, far, np.inf)

    return _nearest(
        context, np.array(direction), partial(_is_shown_in, context.space_data), apart, float(pixels)
    )


def _nearest(
    context: Context,
    direction: np.ndarray,
    shows: Callable[[Object], bool],
    apart: Callable[[np.ndarray], np.ndarray],
    limit: float,
) -> Hit | None:
    """As ``session.nearest_point``; what controls a deformer, such as a wire, is no target."""
    return surface.nearest_point(
        context.evaluated_depsgraph_get(),
        direction,
        lambda obj: shows(obj) and kinds.posed_by(obj) is None,
        apart,
        limit,
    )


def _is_shown(obj: Object) -> bool:
    return obj.visible_get()


def _is_shown_in(space: SpaceView3D, obj: Object) -> bool:
    return obj.visible_in_viewport_get(space)


def _sight(context: Context, x: float, y: float) -> tuple[tuple, tuple]:
    """The line of sight at a pixel of the window: its origin and its direction."""
    region, view = context.region, context.region_data
    pixel = (x - region.x, y - region.y)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, pixel)
    return tuple(view3d_utils.region_2d_to_origin_3d(region, view, pixel)), tuple(direction)


def _draw_rings(tool: Dragging, rings: list[np.ndarray]) -> None:
    """Draw the ring of a new handle where it is now, and how far the surface follows, in each 3D Viewport."""
    context = bpy.context
    if context.region_data is None:
        return
    for index, shape in enumerate(rings):
        moved = shape if index else frames.transformed(tool.matrix, shape)
        draw_line(context.region, context.region_data, moved, REACH if index else HANDLE)
