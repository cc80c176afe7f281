# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons that pose all controls of a deformer at once."""

from bpy.types import Context, UILayout

from ..ids import Operators
from .layouts import Button

RESET = ("Reset Pose", "LOOP_BACK")


def draw_reset(layout: UILayout) -> None:
    """Draw the button that puts all controls back to rest."""
    text, icon = RESET
    layout.operator(Operators.POSE_RESET, text=text, icon=icon)


_DRAGS = {"SURFACE": "Drag the Surface", "POINTS": "Drag Points", "CLAY": "Drag Clay", "BONES": "Drag Bones"}


def draw_drag(layout: UILayout, mode: str) -> None:
    """Draw the button that takes the tool Sinew Drag, in one of its modes."""
    layout.operator(Operators.DRAG_START, text=_DRAGS[mode], icon="VIEW_PAN").mode = mode


def draw_pose(context: Context, layout: UILayout, begin: Button) -> None:
    """Draw the large button that begins to pose a control by its points, and the one that resets it."""
    if context.object.mode != "EDIT":
        large = layout.column()
        large.scale_y = 1.3
        begin.draw(large)
    draw_reset(layout)
