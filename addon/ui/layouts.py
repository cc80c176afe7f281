# SPDX-License-Identifier: GPL-3.0-or-later
"""Layouts that several panels and menus have in common."""

from bpy.types import UILayout


def split(layout: UILayout) -> UILayout:
    """Labels to the left, as in Blender's own panels; without the dots of animation, as in its sidebar."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def invoking(layout: UILayout) -> UILayout:
    """Entries run with the mouse over the viewport, from whichever editor the menu was opened."""
    layout.operator_context = "INVOKE_REGION_WIN"
    return layout


def draw_move_buttons(side: UILayout, operator: str) -> None:
    """Beside a list."""
    side.separator()
    side.operator(operator, text="", icon="TRIA_UP").direction = "UP"
    side.operator(operator, text="", icon="TRIA_DOWN").direction = "DOWN"


def draw_move_entries(layout: UILayout, operator: str) -> None:
    """In a menu."""
    layout.operator(operator, text="Move Up", icon="TRIA_UP").direction = "UP"
    layout.operator(operator, text="Move Down", icon="TRIA_DOWN").direction = "DOWN"
