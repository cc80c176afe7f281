# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the tools of a deformer in the panel, the settings of the active one, and their menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import control_list
from ..layouts import Button, ControlMenu, beside, draw_field, draw_pair
from ..pose import RESET, draw_drag, draw_reset
from ..text import draw_text
from .rows import draw_rows, parameter_text, row_name

__all__ = ("MENUS", "REST", "draw", "draw_row", "draw_settings", "row_name")

REST = (Button(Operators.ROW_REST, "New Rest of the Tool", "PIVOT_BOUNDBOX"),)
_ADDING = tuple(
    Button(Operators.TOOL_ADD, text, "EMPTY_AXIS", (("tool", tool),))
    for tool, text in (("drag", "Add Drag"), ("twist", "Add Twist"), ("bend", "Add Bend"))
)
_STOPS = (
    Button(Operators.TOOL_STOP, "Add Stop", "KEYFRAME", (("clear", False),)),
    Button(Operators.TOOL_STOP, "Remove Stops", "X", (("clear", True),)),
)


class SINEW_MT_tools(ControlMenu, Menu):
    """What can be done with the tools of the active deformer"""

    bl_idname = Menus.TOOLS
    bl_label = "Tool"
    ICON = "TOOL_SETTINGS"
    ADDING = _ADDING
    DOING = (*_STOPS, *REST, Button(Operators.ROW_REMOVE, "Remove Tool", "REMOVE"))


MENUS = (SINEW_MT_tools,)


def draw(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the list of tools, and what adds and resets them."""
    draw_rows(layout, deformer, Menus.TOOLS)
    pair = beside(context, layout, ("Drag Clay", "VIEW_PAN"), RESET)
    draw_drag(pair, "CLAY")
    draw_reset(pair)


def draw_row(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the settings of the active tool, and the stops on its path."""
    row = control_list.active_row(deformer)
    draw_field(context, layout, row, "object")
    for parameter in deformer.definition.control_parameters:
        is_main = parameter.id in deformer.definition.main
        if not is_main and (parameter.id != "width" or row.tools != "drag"):
            draw_field(context, layout, row, parameter.id, text=parameter_text(row, parameter))
    count = control_list.stop_count(row)
    if count:
        draw_text(context, layout, f"Its path has {count} stops", "CURVE_PATH")
    draw_pair(context, layout, _STOPS)


def draw_settings(_context: Context, _layout: UILayout, _obj: Object, _deformer: SinewDeformer) -> None:
    """Nothing: each tool has its own settings."""
