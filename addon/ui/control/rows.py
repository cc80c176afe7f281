# SPDX-License-Identifier: GPL-3.0-or-later
"""What wires and tools have in common: their list, and the active row of it."""

from bpy.types import UILayout

from ...core.methods import Parameter
from ...ids import Operators
from ...properties import SinewControl, SinewDeformer
from ...session.actions.controls import control_list

_ALONG = {"inner": "Bottom", "outer": "Top"}  # what the reach of a twist or a bend is called


def draw_rows(layout: UILayout, deformer: SinewDeformer, menu: str) -> None:
    """Draw the list of the objects that control a deformer together, beside what can be done with them."""
    row = layout.row()
    several = len(control_list.rows_of(deformer)) > 1
    row.template_list(
        "SINEW_UL_controls", "", deformer, "controls", deformer, "chosen_control", rows=4 if several else 2
    )
    side = row.column(align=True)
    side.menu(menu, text="", icon="ADD")
    side.operator(Operators.ROW_REMOVE, text="", icon="REMOVE")


def row_name(deformer: SinewDeformer) -> str:
    """The name of the active object."""
    row = control_list.active_row(deformer)
    if row is None:
        return ""
    return row.name if row.object is None else row.object.name


def parameter_text(row: SinewControl, parameter: Parameter) -> str:
    """What a parameter is called for a control."""
    return parameter.label if row.tools == "drag" else _ALONG.get(parameter.id, parameter.label)
