# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of the tool Sinew Drag. They are stored on the scene, so that keys can change them."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup

from .setting import field

DRAG_MODES = (
    ("AUTO", "Automatic", "Drag what lies under the mouse: a bone, a control of the mesh, or its surface", 0),
    ("SURFACE", "Surface", "Take the handle under the mouse, or make one, and bend the surface around it", 1),
    ("CLAY", "Clay", "Push the surface like clay: its volume stays, and the path is kept", 2),
    ("POINTS", "Points", "Hold the very place, on text, curves, hair and loose parts as well", 3),
    ("BONES", "Bones", "Drag a bone, and let the figure follow within its limits; a click pins the bone", 4),
)


def _reach_in_pixels(drag: "SinewDrag") -> int:
    return round(drag.pixels * drag.reach)


def _set_reach_in_pixels(drag: "SinewDrag", pixels: int) -> None:
    drag.reach = pixels / drag.pixels


# What the operators that this tool starts can be told, too. With a smaller radius or reach, a first drag on
# the arm of a whole figure draws a web out of it instead of bending it.
PIXELS = {
    "name": "Radius",
    "subtype": "PIXEL",
    "default": 40,
    "min": 1,
    "soft_max": 300,
    "description": "Set how large a new handle is on the screen; what is within it moves as one piece",
}
REACH = {
    "name": "Reach",
    "default": 4.0,
    "min": 1.0,
    "soft_max": 20.0,
    "description": "Set how many radii far the surface follows a new handle, unless other regions hold it",
}
UNLIMITED = {
    "name": "Whole Surface",
    "description": "Move everything that is connected, at any distance, unless a region holds it",
}
BALANCE = {
    "name": "Keep in Balance",
    "description": "Keep the centre of mass over what is pinned, for example two feet",
}


class SinewDrag(PropertyGroup):
    """The settings of the tool Sinew Drag"""

    mode: field(EnumProperty, items=DRAG_MODES).named("Drag", "Choose what pressing and dragging does")
    pixels: IntProperty(**PIXELS)
    reach: FloatProperty(**REACH)
    reach_in_pixels: field(
        IntProperty,
        subtype="PIXEL",
        min=1,
        soft_max=2000,
        get=_reach_in_pixels,
        set=_set_reach_in_pixels,
        options={"HIDDEN", "SKIP_SAVE"},
    ).named("Reach", "Set how far the surface follows, on the screen")
    unlimited: BoolProperty(**UNLIMITED)
    balance: BoolProperty(**BALANCE)
