# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the wires of a deformer in the panel, the settings of the active one, and their menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import control_list as edit_rows
from ...session.targets import targets
from ..layouts import invoking, split

ABOVE_PARAMETERS = True
PANELS = ()


class SINEW_MT_wires(Menu):
    """What can be done with the wires of the active deformer"""

    bl_idname = Menus.WIRES
    bl_label = "Wire"
    ICON = "CURVE_DATA"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        for source, text in (("CURVES", "Wires from Selected"), ("EDGES", "Wire along Edges")):
            layout.operator(Operators.WIRE_ADD, text=text, icon="CURVE_DATA").source = source
        layout.operator(Operators.WIRE_DRAW, icon="GREASEPENCIL")
        layout.separator()
        layout.operator(Operators.ROW_REST, text="New Rest", icon="PIVOT_BOUNDBOX")
        layout.operator(Operators.ROW_REMOVE, text="Remove Wire", icon="REMOVE")


MENUS = (SINEW_MT_wires,)


def draw_start(_context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the buttons that add a wire."""
    _draw_add(layout, obj)


def draw(_context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the list of wires, and the settings of the active one."""
    draw_rows(layout, deformer, Menus.WIRES)
    _draw_add(layout, obj)
    row = edit_rows.active_row(deformer)
    if row is None:
        return
    column = split(layout.column())
    column.prop(row, "object", text="Curve")
    column.prop(row, "domain")
    for parameter in deformer.definition.control_parameters:
        column.prop(row, parameter.id)
    layout.operator(Operators.ROW_REST, text="New Rest", icon="PIVOT_BOUNDBOX")


def _draw_add(layout: UILayout, obj: Object) -> None:
    column = layout.column(align=True)
    along = obj.mode == "EDIT" and targets.is_mesh(obj)
    text = "Wire along Edges" if along else "Wires from Selected"
    column.operator(Operators.WIRE_ADD, text=text, icon="CURVE_DATA").source = "AUTO"
    if targets.is_mesh(obj):
        column.operator(Operators.WIRE_DRAW, icon="GREASEPENCIL")


def draw_rows(layout: UILayout, deformer: SinewDeformer, menu: str) -> None:
    """Draw the list of the objects that control a deformer together."""
    row = layout.row()
    several = len(edit_rows.rows_of(deformer)) > 1
    row.template_list(
        "SINEW_UL_controls",
        "",
        deformer,
        "controls",
        deformer,
        "active_control",
        rows=4 if several else 2,
    )
    side = row.column(align=True)
    side.operator(Operators.ROW_REMOVE, text="", icon="REMOVE")
    side.menu(menu, text="", icon="DOWNARROW_HLT")
