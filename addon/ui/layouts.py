# SPDX-License-Identifier: GPL-3.0-or-later
"""Layouts that several panels and menus have in common."""

from bpy.types import UILayout

from ..properties import SinewDeformer


def split(layout: UILayout) -> UILayout:
    """Draw labels to the left as in Blender's own panels, without animation dots as in its sidebar."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def unless_baked(layout: UILayout, deformer: SinewDeformer) -> UILayout:
    """For settings and rows, which are greyed out while a bake plays in place of the deformer."""
    column = layout.column()
    column.enabled = not deformer.bake.is_baked
    return column


def invoking(layout: UILayout) -> UILayout:
    """Let the entries of a menu run as if the mouse were over the viewport, in whichever editor it opens."""
    layout.operator_context = "INVOKE_REGION_WIN"
    return layout


def draw_move_buttons(side: UILayout, operator: str) -> None:
    """Draw the buttons beside a list that move its active row."""
    side.separator()
    side.operator(operator, text="", icon="TRIA_UP").direction = "UP"
    side.operator(operator, text="", icon="TRIA_DOWN").direction = "DOWN"


def draw_move_entries(layout: UILayout, operator: str, row: str) -> None:
    """Draw the entries of a menu that move the active row of a list, which is called a ``row``."""
    layout.operator(operator, text=f"Move {row} Up", icon="TRIA_UP").direction = "UP"
    layout.operator(operator, text=f"Move {row} Down", icon="TRIA_DOWN").direction = "DOWN"
