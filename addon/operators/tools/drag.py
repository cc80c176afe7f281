# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew Drag: in Object Mode, make a handle where one presses on a mesh, or take one that is there."""

import math
from functools import partial

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty
from bpy.types import Context, Event, Object, Operator

from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.methods import DEFAULT_GRIP_METHOD, DEFAULT_HOLD_METHOD, DEFAULT_METHOD
from ...ids import Operators
from ...properties import PIXELS, REACH
from ...session.actions import picking
from ...session.actions.drag import Brush, Drag
from ...session.datablocks import parts, surface
from ...session.datablocks.surface import Hit
from ...session.evaluation import binding
from ...session.targets import targets
from ..arguments import REGION_METHODS, distance, given, method_choice, once
from ..handles.handle import select_control
from ..modal.motion_properties import MotionProperties
from ..modal.ring import draw_line, ring
from ..modal.view import axes_of, view_of
from ..offered import Offered
from ..reporting import reports_errors
from .dragging import Dragging, Drags
from .under_mouse import anything_under, beside_ray, is_shown, sight

_AROUND_JOINT = 1.5  # widths of the limb that a correction reaches
_OF_JOINT = 1.0 / 3.0  # the most of that reach that a new handle takes
_OF_PART = 0.25  # the most of its part that a new handle takes
HANDLE, AROUND = (1.0, 1.0, 1.0, 0.9), (1.0, 1.0, 1.0, 0.3)  # the colours of the two rings
_NOT_HELD = "Nothing holds this part, so all of it moves - click on it to make handles that stay"
NOTHING = "There is nothing to drag at this place - press on a surface, or on a curve, hair or a cloud"


class SINEW_OT_drag(Offered, MotionProperties, Drags, Operator):
    """Drag the surface: a handle is made where you press, or taken if there is one, and moves with the mouse.

    A click alone makes a handle that stays, and holds what is around it
    """

    bl_idname = Operators.DRAG
    bl_label = "Sinew Drag"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING", "INTERNAL"}  # it begins with a press

    LENGTHS = ("radius", "reach")

    method: method_choice(
        REGION_METHODS,
        "Choose the method of a new deformer; an existing one keeps its own",
        default=DEFAULT_METHOD,
        options={"SKIP_SAVE"},
    )
    origin: given(FloatVectorProperty, subtype="XYZ").named(
        "Origin", "Choose where the line of sight begins that meets the surface"
    )
    direction: given(FloatVectorProperty, subtype="XYZ", default=(0.0, 0.0, -1.0)).named(
        "Direction", "The direction of the line of sight"
    )
    pixels: IntProperty(**PIXELS, options={"HIDDEN"})
    radius: distance(
        "Radius",
        "Set how far from the place, along the surface, vertices belong to a new handle",
        default=0.25,
        soft_min=0.001,
        options={"SKIP_SAVE"},
    )
    reach: FloatProperty(**REACH)
    places: once(BoolProperty).named("Places", "Take the very place that is pressed, and no region around it")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.mode in ("OBJECT", "POSE") else "Go to Object Mode to drag a surface"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        hit = surface.first_hit(
            context.evaluated_depsgraph_get(), np.array(self.origin), np.array(self.direction), is_shown
        )
        if hit is None:
            hit = beside_ray(context, np.array(self.origin), np.array(self.direction), self.radius)
        if hit is None:
            raise SinewError(NOTHING)
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
        self.origin, self.direction = sight(context, event.mouse_x, event.mouse_y)
        hit = anything_under(context, event.mouse_x, event.mouse_y, self.pixels)
        if hit is None:
            self.tell({"INFO"}, NOTHING)
            return {"CANCELLED"}
        view = view_of(context, hit.place)
        if not self.properties.is_property_set("radius"):
            self.radius, self.reach = handle_sizes(context, hit, self.pixels, self.reach)
        drag = self._drag(context, hit, wait=False)
        axes = axes_of(drag.frame)
        typed = self.typed_motion(context, event, view, axes)
        tool = Dragging(drag, typed, hit.place, axes)
        binding.watch(drag.uid)
        rings = []
        if drag.is_new:
            rings.append(ring(hit.place, hit.normal, self.radius))
            if drag.is_region and not self.unlimited:
                rings.append(ring(hit.place, hit.normal, self.reach * self.radius))
        return self.begin(context, tool, hit.obj, partial(_draw_rings, tool, rings))

    def store_result(self, context: Context) -> None:
        self.store_motion(self.tool.typed.motion)
        self._keep(context, self.worked_on(context), self.tool.drag)

    def _leave(self, context: Context, result: set[str]) -> set[str]:
        binding.watch(self.tool.drag.uid, False)
        return super()._leave(context, result)

    def _drag(self, context: Context, hit: Hit, wait: bool) -> Drag:
        reach = math.inf if self.unlimited else self.reach * self.radius
        if not self.properties.is_property_set("method"):
            if self.places:
                self.method = DEFAULT_HOLD_METHOD
            elif not targets.is_mesh(hit.obj):
                self.method = DEFAULT_GRIP_METHOD
        brush = Brush(self.choose_method(context).id, self.radius, reach, self.places)
        drag = Drag(hit, context.evaluated_depsgraph_get(), brush, wait)
        if not drag.is_held:
            self.tell({"INFO"}, _NOT_HELD)
        return drag

    def _keep(self, context: Context, obj: Object, drag: Drag) -> None:
        """Select the control, but in Pose Mode. The handle is kept even if its control cannot be selected."""
        if context.scene.tool_settings.use_keyframe_insert_auto:
            drag.key(obj)
        if context.mode != "OBJECT":
            return
        try:
            select_control(context, obj, drag.handle_of(obj))
        except SinewError as error:
            self.tell({"WARNING"}, str(error))


def handle_sizes(context: Context, hit: Hit, pixels: int, reach: float) -> tuple[float, float]:
    """The radius of a new handle, and how many of them far the surface follows.

    Around a joint that is being corrected that is 1.5 times the width of the limb, whatever the zoom is.
    """
    radius, width = handle_radius(context, hit, pixels), picking.width_of_joint(hit.obj, hit.place)
    if width is None:
        return radius, reach
    around = _AROUND_JOINT * width
    radius = min(radius, _OF_JOINT * around)
    return radius, around / radius


def handle_radius(context: Context, hit: Hit, pixels: int) -> float:
    """How large a new handle is: so many pixels, and at most a share of the loose part that it is on."""
    size = parts.shown_parts(hit.obj, context.evaluated_depsgraph_get()).size_at(hit.place)
    return min(pixels * view_of(context, hit.place).pixel, _OF_PART * size)


def _draw_rings(tool: Dragging, rings: list[np.ndarray]) -> None:
    """Draw the ring of a new handle where it is now, and how far the surface follows, in each 3D Viewport."""
    context = bpy.context
    if context.region_data is None:
        return
    for index, shape in enumerate(rings):
        moved = shape if index else frames.transformed(tool.matrix, shape)
        draw_line(context.region, context.region_data, moved, AROUND if index else HANDLE)
