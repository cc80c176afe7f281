# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Once: pose vertices once, in Edit Mode."""

import math
from functools import partial

import bpy
from bpy.types import Context, Event, Object, Operator
from gpu_extras.presets import draw_circle_2d

from ...core.labels import label_of
from ...core.methods import BY_ID
from ...ids import Operators
from ...session.edit_mode.grab import NOTHING_FREE, Grab
from ..arguments import distance
from ..modal.motion_properties import MOTION_KEYS, MotionProperties
from ..modal.shell import Keys, ViewportTool
from ..modal.view import axes_of, length_text, pivot_of, view_of
from ..offered import Offered
from ..reporting import reports_errors
from .grabbing import Grabbing

_KEYS: Keys = (
    (("MOUSE_LMB",), "Confirm"),
    (("MOUSE_RMB",), "Cancel"),
    *MOTION_KEYS,
    (("MOUSE_MMB_DRAG",), "Radius"),
    (("EVENT_A",), "Whole Surface"),
)
_CIRCLE = (1.0, 1.0, 1.0, 0.6)


class SINEW_OT_grab_region(Offered, MotionProperties, ViewportTool, Operator):
    """Move, rotate or scale the selected vertices; the surface around them follows by a Sinew method.

    It works like proportional editing, but the surface keeps its details. Use it for single poses
    """

    bl_idname = Operators.GRAB_REGION
    bl_label = "Grab Once"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING"}

    KEYS = _KEYS
    LENGTHS = ("radius",)

    radius: distance(
        "Radius",
        "Set how far from the selection, along the surface, vertices follow; the others stay",
        default=1.0,
        soft_min=0.001,
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        if context.mode == "EDIT_MESH":
            return ""
        return "Go to Edit Mode of a mesh and select the vertices to grab"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = context.edit_object
        grab = self._grab(context, obj)
        grab.follow(math.inf if self.unlimited else self.radius)
        grab.show(obj, self.motion.matrix(axes_of(obj.matrix_world), pivot_of(context, grab.selection)))
        self._report_limits(obj, grab)
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        obj = context.edit_object
        grab = self._grab(context, obj)
        pivot, axes = pivot_of(context, grab.selection), axes_of(obj.matrix_world)
        typed = self.typed_motion(context, event, view_of(context, pivot), axes)
        tool = Grabbing(grab, typed, pivot, axes, math.inf if self.unlimited else self.radius)
        self._report_limits(obj, grab)
        return self.begin(context, tool, obj, partial(_draw_circle, tool))

    def _grab(self, context: Context, obj: Object) -> Grab:
        return Grab(obj, self.choose_method(context))

    def store_result(self, _context: Context) -> None:
        tool = self.tool
        self.store_motion(tool.typed.motion)
        self.unlimited = math.isinf(tool.radius)
        if not self.unlimited:
            self.radius = tool.radius

    def _report_limits(self, obj: Object, grab: Grab) -> None:
        """Report what an artist may not expect."""
        if obj.data.use_mirror_x or obj.data.use_mirror_y or obj.data.use_mirror_z:
            self.tell(
                {"INFO"}, "Grab Once ignores the Mirror option of the mesh - the other side stays as it is"
            )
        if grab.lost:
            count = "1 vertex has" if grab.lost == 1 else f"{grab.lost:,} vertices have"
            self.tell(
                {"WARNING"}, f"{count} invalid coordinates (NaN or infinite) and will not move - use Repair"
            )
        if grab.moves_alone:
            self.tell({"WARNING"}, NOTHING_FREE)

    def header(self, context: Context) -> str:
        tool, settings = self.tool, context.scene.unit_settings
        reach = "whole surface" if math.isinf(tool.radius) else f"radius {length_text(settings, tool.radius)}"
        motion = tool.typed.header(lambda value: length_text(settings, value))
        return f"{motion}   {label_of(BY_ID[self.method])}, {reach}"


def _draw_circle(tool: Grabbing) -> None:
    """Draw the radius around the selection, in each 3D Viewport."""
    context = bpy.context
    if math.isinf(tool.radius) or context.region is None:
        return
    view = view_of(context, tool.pivot)
    centre = (view.centre[0] - context.region.x, view.centre[1] - context.region.y)
    draw_circle_2d(centre, _CIRCLE, tool.radius / view.pixel)
