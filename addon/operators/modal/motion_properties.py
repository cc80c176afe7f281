# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of operators that move something: the motion, and how the surface follows."""

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty
from bpy.types import Context, Event

from ...core.methods import BY_ID, DEFAULT_METHOD, Method
from ...core.transform.motion import Mode, Motion
from ...core.transform.typed_motion import TypedMotion, View
from ...preferences import preferences
from ...properties import UNLIMITED
from ..arguments import REGION_METHODS, method_choice, once
from .shell import Keys
from .view import typed_units

_METHODS = tuple(method for method in REGION_METHODS if not method.is_space)
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

    mode: once(EnumProperty, items=_MODES, default="TRANSLATE").named(
        "Mode", "Choose whether this moves, turns or scales at the start"
    )
    value: once(FloatVectorProperty, subtype="TRANSLATION").named("Move", "Set how far along each axis")
    angle: once(FloatProperty, subtype="ANGLE").named("Angle", "Set the turn about the axis")
    axis: once(FloatVectorProperty, subtype="XYZ", default=(0.0, 0.0, 1.0)).named(
        "Axis", "Choose what to turn about"
    )
    scale: once(FloatVectorProperty, subtype="XYZ", default=(1.0, 1.0, 1.0)).named(
        "Scale", "Scale along each axis"
    )
    orientation: once(EnumProperty, items=_ORIENTATIONS, default="GLOBAL").named(
        "Orientation", "Choose which axes X, Y and Z mean"
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

    method: method_choice(
        _METHODS, "Set how the surface follows", default=DEFAULT_METHOD, options={"SKIP_SAVE"}
    )
    unlimited: BoolProperty(**UNLIMITED)

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
