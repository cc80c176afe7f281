# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the wires of a deformer in the panel, the settings of the active one, and their menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import control_list
from ...session.targets import targets
from ..layouts import Button, ControlMenu, beside, draw_field
from ..pose import RESET, draw_reset
from .rows import draw_rows, row_name

__all__ = ("MENUS", "REST", "draw", "draw_row", "draw_settings", "row_name")

REST = (Button(Operators.ROW_REST, "New Rest of the Wire", "PIVOT_BOUNDBOX"),)
_ADDING = (
    Button(Operators.WIRE_ADD, "Wires from Selected", "CURVE_DATA", (("source", "CURVES"),)),
    Button(Operators.WIRE_ADD, "Wire along Edges", "CURVE_DATA", (("source", "EDGES"),)),
    Button(Operators.WIRE_DRAW, "Draw Wire", "GREASEPENCIL"),
)


class SINEW_MT_wires(ControlMenu, Menu):
    """What can be done with the wires of the active deformer"""

    bl_idname = Menus.WIRES
    bl_label = "Wire"
    ICON = "CURVE_DATA"
    ADDING = _ADDING
    DOING = (*REST, Button(Operators.ROW_REMOVE, "Remove Wire", "REMOVE"))


MENUS = (SINEW_MT_wires,)


def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the list of wires, and what adds and resets them."""
    draw_rows(layout, deformer, Menus.WIRES)
    pair = beside(context, layout, _ADDING[-1].looks, RESET)
    if targets.is_mesh(obj):
        _ADDING[-1].draw(pair)
    draw_reset(pair)


def draw_row(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the settings of the active wire."""
    row = control_list.active_row(deformer)
    draw_field(context, layout, row, "object", text="Curve")
    draw_field(context, layout, row, "domain")
    for parameter in deformer.definition.control_parameters:
        if parameter.id not in deformer.definition.main:
            draw_field(context, layout, row, parameter.id)


def draw_settings(_context: Context, _layout: UILayout, _obj: Object, _deformer: SinewDeformer) -> None:
    """Nothing: each wire has its own settings."""
