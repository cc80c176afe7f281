# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons that pose all controls of a deformer at once."""

from bpy.types import Context, UILayout

from ..ids import Operators
from .layouts import Button, later

_TOOL = (("name", Operators.DRAG), ("space_type", "VIEW_3D"))
RESET = ("Reset Pose", "LOOP_BACK")


def draw_reset(layout: UILayout) -> None:
    """Draw the button that puts all controls back to rest."""
    text, icon = RESET
    if later("POSE_RESET"):
        layout.operator(later("POSE_RESET"), text=text, icon=icon)


def draw_drag(
    layout: UILayout, text: str, mode: str, otherwise: str = "wm.tool_set_by_id", more: tuple = _TOOL
) -> None:
    """Draw the button that takes the tool Sinew Drag, in one of its modes."""
    start = later("DRAG_START")
    button = Button(start, text, "VIEW_PAN", (("mode", mode),)) if start else None
    (button or Button(otherwise, text, "VIEW_PAN", more)).draw(layout)


def draw_pose(context: Context, layout: UILayout, begin: Button) -> None:
    """Draw the large button that begins to pose a control by its points, and the one that resets it."""
    if context.object.mode != "EDIT":
        large = layout.column()
        large.scale_y = 1.3
        begin.draw(large)
    draw_reset(layout)
