# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw a parameter of a method, by its type."""

from bpy.types import PropertyGroup, UILayout

from ..core.methods import Curve, Float, GridPoints, Parameter, UvMap, group_property
from ..ids import Operators
from ..session.datablocks import references


def draw_parameter(layout: UILayout, values: PropertyGroup, parameter: Parameter) -> None:
    """Draw the value of a parameter, and the vertex group that scales it if it can be painted."""
    if isinstance(parameter, Curve):
        _draw_curve(layout, values, parameter)
        return
    row = layout.row(align=True)
    if isinstance(parameter, UvMap):
        row.prop_search(values, parameter.id, values.id_data.data, "uv_layers", icon="GROUP_UVS")
        return
    row.prop(values, parameter.id, slider=_has_ends(parameter))
    if isinstance(parameter, GridPoints):
        row.operator(Operators.GRID_NEW, text="", icon="ADD")
    if parameter.paintable:
        obj = values.id_data
        row.prop_search(values, group_property(parameter), obj, "vertex_groups", text="")


def _has_ends(parameter: Parameter) -> bool:
    """Whether a slider shows all values of a number: it ends where the parameter ends."""
    return isinstance(parameter, Float) and parameter.soft_maximum >= parameter.maximum


def _draw_curve(layout: UILayout, values: PropertyGroup, parameter: Curve) -> None:
    """Draw a button while the curve is the default one, and its points once it is drawn."""
    row = layout.row(align=True)
    node = references.curve_node(values, parameter)
    if node is None:
        row.operator(Operators.CURVE_EDIT, text=parameter.label, icon="FCURVE").parameter = parameter.id
        return
    row.label(text=parameter.label)
    reset = row.operator(Operators.CURVE_EDIT, text="", icon="LOOP_BACK")
    reset.parameter, reset.reset = parameter.id, True
    layout.template_curve_mapping(node, "mapping")
