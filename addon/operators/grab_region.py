# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Region: a pose of the moment, in Edit Mode."""

import math

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty
from bpy.types import Context, Event, Object, Operator, UILayout
from gpu_extras.presets import draw_circle_2d

from .. import session
from ..core.errors import SinewError
from ..core.methods import BY_ID, DEFAULT_METHOD, METHODS, Control
from ..core.transform.motion import Mode, Motion
from ..core.transform.typed_motion import TypedMotion, View
from ..ids import Operators
from ..preferences import preferences
from .grabbing import Grabbing, Outcome
from .refusing import refusing

_METHODS = tuple(method for method in METHODS if method.control is Control.HANDLES and not method.wraps)
_MODES = (
    ("TRANSLATE", "Move", "Move the selection", "NONE", 0),
    ("ROTATE", "Rotate", "Turn the selection about its centre", "NONE", 1),
    ("RESIZE", "Scale", "Scale the selection about its centre", "NONE", 2),
)
_ORIENTATIONS = (
    ("GLOBAL", "Global", "Along the axes of the world", "NONE", 0),
    ("LOCAL", "Local", "Along the axes of the object", "NONE", 1),
)
_UNITS = {  # metres of a unit, and how it is written
    "KILOMETERS": (1000.0, " km"),
    "METERS": (1.0, " m"),
    "CENTIMETERS": (0.01, " cm"),
    "MILLIMETERS": (0.001, " mm"),
    "MICROMETERS": (1e-6, " µm"),
    "MILES": (1609.344, " mi"),
    "FEET": (0.3048, "'"),
    "INCHES": (0.0254, '"'),
    "THOU": (0.0000254, " thou"),
}
_KEYS = (
    (("MOUSE_LMB",), "Confirm"),
    (("MOUSE_RMB",), "Cancel"),
    (("EVENT_X", "EVENT_Y", "EVENT_Z"), "Axis"),
    (("EVENT_SHIFT", "EVENT_X", "EVENT_Y", "EVENT_Z"), "Plane"),
    (("EVENT_G",), "Move"),
    (("EVENT_R",), "Rotate"),
    (("EVENT_S",), "Scale"),
    (("EVENT_CTRL",), "Snap"),
    (("EVENT_SHIFT",), "Precision"),
    (("MOUSE_MMB_DRAG",), "Radius"),
    (("EVENT_A",), "Whole Surface"),
)
_CIRCLE = (1.0, 1.0, 1.0, 0.6)


class SINEW_OT_grab_region(Operator):
    """Move, turn or scale the selected vertices, and let the surface around follow by a Sinew method.

    Like proportional editing, with a surface that keeps its details; use it for one-off poses
    """

    bl_idname = Operators.GRAB_REGION
    bl_label = "Grab Region"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING"}

    mode: EnumProperty(
        name="Mode",
        items=_MODES,
        default="TRANSLATE",
        options={"SKIP_SAVE"},
        description="Whether the selection is moved, turned or scaled at the start",
    )
    value: FloatVectorProperty(
        name="Move", subtype="TRANSLATION", description="How far along each axis", options={"SKIP_SAVE"}
    )
    angle: FloatProperty(
        name="Angle", subtype="ANGLE", description="The turn about the axis", options={"SKIP_SAVE"}
    )
    axis: FloatVectorProperty(
        name="Axis",
        subtype="XYZ",
        default=(0.0, 0.0, 1.0),
        description="What the selection turns about",
        options={"SKIP_SAVE"},
    )
    scale: FloatVectorProperty(
        name="Scale",
        subtype="XYZ",
        default=(1.0, 1.0, 1.0),
        description="The factor along each axis",
        options={"SKIP_SAVE"},
    )
    orientation: EnumProperty(
        name="Orientation",
        items=_ORIENTATIONS,
        default="GLOBAL",
        options={"SKIP_SAVE"},
        description="Which axes X, Y and Z mean",
    )
    radius: FloatProperty(
        name="Radius",
        subtype="DISTANCE",
        default=1.0,
        min=0.0,
        soft_min=0.001,
        description="How far over the surface it follows; the rest stays",
    )
    unlimited: BoolProperty(
        name="Whole Surface", description="Everything connected with the selection follows, without a radius"
    )
    method: EnumProperty(
        name="Method",
        items=tuple((row.id, row.label, row.summary, "NONE", row.number) for row in _METHODS),
        default=DEFAULT_METHOD,
        description="How the surface follows",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "EDIT_MESH":
            cls.poll_message_set("Go to Edit Mode of a mesh and select the vertices to grab")
            return False
        return True

    @refusing
    def execute(self, context: Context) -> set[str]:
        obj = context.edit_object
        grab = self._grab(context, obj)
        grab.follow(math.inf if self.unlimited else self.radius)
        grab.show(obj, self._motion().matrix(_axes(obj), _pivot(context, grab)))
        self._mention(obj, grab)
        return {"FINISHED"}

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        return self._begin(context, event)

    @refusing
    def _begin(self, context: Context, event: Event) -> set[str]:
        obj = context.edit_object
        grab = self._grab(context, obj)
        pivot, axes = _pivot(context, grab), _axes(obj)
        typed = TypedMotion(
            Mode(self.mode),
            view_of(context, pivot),
            axes,
            (event.mouse_x, event.mouse_y),
            context.space_data.overlay.grid_scale,
            *_typed_units(context.scene.unit_settings),
        )
        self._tool = Grabbing(grab, typed, pivot, axes, math.inf if self.unlimited else self.radius)
        self._name = obj.name
        self._mention(obj, grab)
        window_manager = context.window_manager
        self._timer = window_manager.event_timer_add(0.05, window=context.window)
        self._circle = bpy.types.SpaceView3D.draw_handler_add(
            _draw_circle, (self._tool,), "WINDOW", "POST_PIXEL"
        )
        window_manager.modal_handler_add(self)
        context.workspace.status_text_set(_draw_keys)
        self._say(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        obj = context.edit_object
        if obj is None or obj.name != self._name:
            return self._leave(context, {"CANCELLED"})
        if context.area is None or context.area.type != "VIEW_3D":
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        view = view_of(context, self._tool.pivot)
        try:
            outcome = self._tool.handle(obj, event, view)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        if self._tool.notice:
            self.report({"WARNING"}, self._tool.notice)
            self._tool.notice = ""
        if outcome is Outcome.CONFIRMED:
            self._keep(self._tool)
            return self._leave(context, {"FINISHED"})
        if outcome is Outcome.CANCELLED:
            return self._leave(context, {"CANCELLED"})
        self._say(context)
        return {"PASS_THROUGH"} if outcome is Outcome.PASS else {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        """Blender ends the tool, as with its window."""
        obj = context.edit_object
        if obj is not None and obj.name == self._name:
            self._restore(obj)
        self._leave(context, {"CANCELLED"})

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(self, "mode")
        if self.mode == "ROTATE":
            layout.prop(self, "angle")
            layout.prop(self, "axis")
        else:
            layout.prop(self, "value" if self.mode == "TRANSLATE" else "scale")
        layout.prop(self, "orientation")
        layout.separator()
        layout.prop(self, "method")
        row = layout.row()
        row.active = not self.unlimited
        row.prop(self, "radius")
        layout.prop(self, "unlimited")

    def _grab(self, context: Context, obj: Object) -> session.Grab:
        if not self.properties.is_property_set("method"):
            preferred = BY_ID[preferences(context).method]
            self.method = preferred.id if preferred in _METHODS else DEFAULT_METHOD
        return session.Grab(obj, BY_ID[self.method])

    def _motion(self) -> Motion:
        return Motion(
            Mode(self.mode),
            self.orientation == "LOCAL",
            tuple(self.value),
            self.angle,
            tuple(self.axis),
            tuple(self.scale),
        )

    def _keep(self, tool: Grabbing) -> None:
        """The motion as properties, for Adjust Last Operation and for scripts."""
        motion = tool.typed.motion
        self.mode, self.orientation = motion.mode.value, "LOCAL" if motion.local else "GLOBAL"
        self.value, self.scale = motion.move, motion.scale
        self.angle, self.axis = motion.angle, motion.axis
        self.unlimited = math.isinf(tool.radius)
        if not self.unlimited:
            self.radius = tool.radius

    def _mention(self, obj: Object, grab: session.Grab) -> None:
        """What an artist might have expected otherwise."""
        if obj.data.use_mirror_x or obj.data.use_mirror_y or obj.data.use_mirror_z:
            self.report({"INFO"}, "Mirror is not followed by Grab Region - the other side stays")
        if grab.lost:
            count = "1 vertex has" if grab.lost == 1 else f"{grab.lost:,} vertices have"
            self.report({"WARNING"}, f"{count} coordinates that are no numbers, and stay - Repair the mesh")
        if grab.moves_alone:
            self.report({"WARNING"}, session.NOTHING_FREE)

    def _say(self, context: Context) -> None:
        """The header, as Blender's own transforms write it."""
        tool, settings = self._tool, context.scene.unit_settings
        if context.area is None:
            return
        job = tool.grab.job
        if job is not None:
            context.area.header_text_set(f"Sinew is working: {job.fraction:.0%} {job.stage}   (Esc cancels)")
            return
        reach = "whole surface" if math.isinf(tool.radius) else f"radius {length_text(settings, tool.radius)}"
        said = tool.typed.header(lambda value: length_text(settings, value))
        context.area.header_text_set(f"{said}   {BY_ID[self.method].label}, {reach}")
        context.area.tag_redraw()

    def _restore(self, obj: Object) -> None:
        """After an error: what can be put back is put back."""
        try:
            self._tool.grab.restore(obj)
        except SinewError as error:
            self.report({"WARNING"}, str(error))

    def _leave(self, context: Context, result: set[str]) -> set[str]:
        context.window_manager.event_timer_remove(self._timer)
        bpy.types.SpaceView3D.draw_handler_remove(self._circle, "WINDOW")
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        if context.area is not None:
            context.area.header_text_set(None)
            context.area.tag_redraw()
        return result


def view_of(context: Context, pivot: np.ndarray) -> View:
    """How a 3D Viewport sees a world point (3,); pixels are those of the window."""
    region = context.region
    if region is None or region.type != "WINDOW":
        region = next(other for other in context.area.regions if other.type == "WINDOW")
    seen = context.space_data.region_3d if context.region_data is None else context.region_data
    to_view = np.array(seen.view_matrix, dtype=np.float64)
    right, up, toward = to_view[:3, :3] / np.linalg.norm(to_view[:3, :3], axis=1, keepdims=True)
    x, y, _z, w = np.array(seen.perspective_matrix, dtype=np.float64) @ (*pivot, 1.0)
    depth = max(abs(w), 1e-6)
    eye = np.linalg.inv(to_view)[:3, 3] - pivot if seen.is_perspective else None
    return View(
        right,
        up,
        toward,
        pixel=2.0 * depth / (abs(seen.window_matrix[0][0]) * region.width),
        centre=(
            region.x + 0.5 * region.width * (1.0 + x / depth),
            region.y + 0.5 * region.height * (1.0 + y / depth),
        ),
        eye=eye,
    )


def length_text(settings: bpy.types.UnitSettings, value: float) -> str:
    """A length of the world in the scene's units."""
    if settings.system == "NONE":
        return _plain(value)
    value *= settings.scale_length
    if settings.length_unit in _UNITS:
        size, symbol = _UNITS[settings.length_unit]
        return _plain(value / size) + symbol
    return bpy.utils.units.to_string(
        settings.system, "LENGTH", value, precision=4, split_unit=settings.use_separate
    )


def _plain(value: float) -> str:
    """Four decimals at most, and never a negative nothing."""
    return f"{round(value, 4) + 0.0:.4f}".rstrip("0").rstrip(".")


def _typed_units(settings: bpy.types.UnitSettings) -> tuple[float, float]:
    """World units, and radians, of a typed 1."""
    turn = 1.0 if settings.system_rotation == "RADIANS" else math.pi / 180.0
    if settings.system == "NONE":
        return 1.0, turn
    natural = "FEET" if settings.system == "IMPERIAL" else "METERS"
    size, _symbol = _UNITS.get(settings.length_unit, _UNITS[natural])
    return size / settings.scale_length, turn


def _axes(obj: Object) -> np.ndarray:
    """The object's axes as orthonormal columns, (3, 3)."""
    linear = np.array(obj.matrix_world, dtype=np.float64)[:3, :3]
    q, r = np.linalg.qr(linear)
    return q * np.where(np.diag(r) < 0.0, -1.0, 1.0)


def _pivot(context: Context, grab: session.Grab) -> np.ndarray:
    """The point about which the selection turns, (3,), by the scene's pivot setting."""
    choice = context.scene.tool_settings.transform_pivot_point
    if choice == "CURSOR":
        return np.array(context.scene.cursor.location, dtype=np.float64)
    selection = grab.selection
    if choice == "BOUNDING_BOX_CENTER":
        return 0.5 * (selection.min(axis=0) + selection.max(axis=0))
    return selection.mean(axis=0)


def _draw_keys(header: bpy.types.Header, _context: Context) -> None:
    """The status bar while the tool runs."""
    layout: UILayout = header.layout
    for icons, text in _KEYS:
        row = layout.row(align=True)
        for icon in icons[:-1]:
            row.label(text="", icon=icon)
        row.label(text=text, icon=icons[-1])


def _draw_circle(tool: Grabbing) -> None:
    """The radius around the selection, in each 3D Viewport."""
    context = bpy.context
    if math.isinf(tool.radius) or context.region is None:
        return
    view = view_of(context, tool.pivot)
    centre = (view.centre[0] - context.region.x, view.centre[1] - context.region.y)
    draw_circle_2d(centre, _CIRCLE, tool.radius / view.pixel)
