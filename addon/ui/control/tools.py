# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the tools of a deformer in the panel, the settings of the active one, and their menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import control_list as rows
from ..layouts import invoking, split
from ..text import draw_text
from .curves import draw_rows

ABOVE_PARAMETERS = True
PANELS = ()
_ALONG = {"inner": "Bottom", "outer": "Top"}  # what the reach of a twist or a bend is called
_TOOLS = (("drag", "Add Drag"), ("twist", "Add Twist"), ("bend", "Add Bend"))


class SINEW_MT_tools(Menu):
    """What can be done with the tools of the active deformer"""

    bl_idname = Menus.TOOLS
    bl_label = "Tool"
    ICON = "TOOL_SETTINGS"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        for tool, text in _TOOLS:
            layout.operator(Operators.TOOL_ADD, text=text, icon="EMPTY_AXIS").tool = tool
        layout.operator(Operators.DRAG_START, text="Sinew Drag: Clay", icon="VIEW_PAN").mode = "CLAY"
        layout.separator()
        layout.operator(Operators.TOOL_STOP, icon="KEYFRAME").clear = False
        layout.operator(Operators.TOOL_STOP, text="Remove Stops", icon="X").clear = True
        layout.operator(Operators.ROW_REST, text="New Rest", icon="PIVOT_BOUNDBOX")
        layout.operator(Operators.ROW_REMOVE, text="Remove Tool", icon="REMOVE")


MENUS = (SINEW_MT_tools,)


def draw_start(_context: Context, layout: UILayout, _obj: Object) -> None:
    """Draw the buttons that add a tool."""
    _draw_add(layout)


def draw(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the list of tools, and the settings of the active one."""
    draw_rows(layout, deformer, Menus.TOOLS)
    _draw_add(layout)
    row = rows.active_row(deformer)
    if row is None:
        return
    column = split(layout.column())
    column.prop(row, "object", text="Object")
    for parameter in deformer.definition.control_parameters:
        if parameter.id != "width" or row.tools != "drag":
            text = parameter.label if row.tools == "drag" else _ALONG.get(parameter.id, parameter.label)
            column.prop(row, parameter.id, text=text)
    count = rows.stop_count(row)
    if count:
        draw_text(context, layout, f"Its path has {count} stops", "CURVE_PATH")
    stops = layout.row(align=True)
    stops.operator(Operators.TOOL_STOP, icon="KEYFRAME").clear = False
    stops.operator(Operators.TOOL_STOP, text="Remove Stops", icon="X").clear = True


def _draw_add(layout: UILayout) -> None:
    row = layout.row(align=True)
    for tool, text in _TOOLS:
        row.operator(Operators.TOOL_ADD, text=text).tool = tool
    layout.operator(Operators.DRAG_START, text="Sinew Drag: Clay", icon="VIEW_PAN").mode = "CLAY"
