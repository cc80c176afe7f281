# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of operators that move something: the motion, and how the surface follows."""

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty
from bpy.types import Context, Event

from ...core.methods import BY_ID, DEFAULT_METHOD, METHODS, Method
from ...core.transform.motion import Mode, Motion
from ...core.transform.typed_motion import TypedMotion, View
from ...preferences import preferences
from ...session.controls import kinds
from .shell import Keys
from .view import typed_units

_METHODS = tuple(
    method for method in METHODS if kinds.marks_regions(method) and not method.is_space and not method.wraps
)
_MODES = (
    ("TRANSLATE", "Move", "Move what was grabbed", "NONE", 0),
    ("ROTATE", "Rotate", "Turn what was grabbed about its centre", "NONE", 1),
    ("RESIZE", "Scale", "Scale what was grabbed about its centre", "NONE", 2),
)
_ORIENTATIONS = (
    ("GLOBAL", "Global", "Along the axes of the world", "NONE", 0),
    ("LOCAL", "Local", "Along the axes of what is moved", "NONE", 1),
)
MOTION_KEYS: Keys = (
    (("EVENT_X", "EVENT_Y", "EVENT_Z"), "Axis"),
    (("EVENT_SHIFT", "EVENT_X", "EVENT_Y", "EVENT_Z"), "Plane"),
    (("EVENT_G",), "Move"),
    (("EVENT_R",), "Rotate"),
    (("EVENT_S",), "Scale"),
    (("EVENT_CTRL",), "Snap"),
    (("EVENT_SHIFT",), "Precision"),
)


class MotionValues:
    """Mixin for an operator that moves something: the motion as properties."""

    mode: EnumProperty(
        name="Mode",
        items=_MODES,
        default="TRANSLATE",
        options={"SKIP_SAVE"},
        description="Whether this moves, turns or scales at the start",
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
        description="What this turns about",
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

    @property
    def motion(self) -> Motion:
        """The motion that the properties describe."""
        return Motion(
            Mode(self.mode),
            self.orientation == "LOCAL",
            tuple(self.value),
            self.angle,
            tuple(self.axis),
            tuple(self.scale),
        )

    def store_motion(self, motion: Motion) -> None:
        """Describe a motion by the properties."""
        self.mode, self.orientation = motion.mode.value, "LOCAL" if motion.local else "GLOBAL"
        self.value, self.scale = motion.move, motion.scale
        self.angle, self.axis = motion.angle, motion.axis

    def typed_motion(self, context: Context, event: Event, view: View, axes: np.ndarray) -> TypedMotion:
        """The motion at its start, by the scene's settings; ``axes`` (3, 3) are local axes as columns."""
        return TypedMotion(
            Mode(self.mode),
            view,
            axes,
            (event.mouse_x, event.mouse_y),
            context.space_data.overlay.grid_scale,
            *typed_units(context.scene.unit_settings),
        )

    def draw_motion(self) -> None:
        """Draw the properties of the motion that count."""
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


class MotionProperties(MotionValues):
    """Mixin for an operator whose modal tool is a ``Moving``.

    ``LENGTHS`` are its properties that say how far the surface follows; Whole Surface switches off the last.
    """

    LENGTHS: tuple[str, ...] = ()

    method: EnumProperty(
        name="Method",
        items=tuple((row.id, row.label, row.summary, "NONE", row.number) for row in _METHODS),
        default=DEFAULT_METHOD,
        description="How the surface follows",
        options={"SKIP_SAVE"},
    )
    unlimited: BoolProperty(
        name="Whole Surface",
        description="Everything that is connected follows, at any distance, unless a region holds it",
    )

    def choose_method(self, context: Context) -> Method:
        """The method that was asked for, or else the one of the preferences."""
        if not self.properties.is_property_set("method"):
            preferred = BY_ID[preferences(context).method]
            self.method = preferred.id if preferred in _METHODS else DEFAULT_METHOD
        return BY_ID[self.method]

    def draw(self, _context: Context) -> None:
        """Draw the properties of the motion that count, and those of the surface."""
        self.draw_motion()
        layout = self.layout
        layout.separator()
        layout.prop(self, "method")
        for name in self.LENGTHS:
            row = layout.row()
            row.active = name != self.LENGTHS[-1] or not self.unlimited
            row.prop(self, name)
        layout.prop(self, "unlimited")
