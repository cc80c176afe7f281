# SPDX-License-Identifier: GPL-3.0-or-later
"""A parameter of a method, drawn by its kind."""

from bpy.types import PropertyGroup, UILayout

from .. import session
from ..core.methods import Curve, Parameter, group_property
from ..ids import Operators


def draw_parameter(layout: UILayout, values: PropertyGroup, parameter: Parameter) -> None:
    """Its value; and the vertex group that scales it, where one may."""
    if isinstance(parameter, Curve):
        _draw_curve(layout, values, parameter)
        return
    row = layout.row(align=True)
    row.prop(values, parameter.id)
    if parameter.paintable:
        obj = values.id_data
        row.prop_search(values, group_property(parameter), obj, "vertex_groups", text="")


def _draw_curve(layout: UILayout, values: PropertyGroup, parameter: Curve) -> None:
    """A button while the curve is the default one, then its points."""
    row = layout.row(align=True)
    node = session.curve_node(values, parameter)
    if node is None:
        row.operator(Operators.CURVE_EDIT, text=parameter.label, icon="FCURVE").parameter = parameter.id
        return
    row.label(text=parameter.label)
    reset = row.operator(Operators.CURVE_EDIT, text="", icon="LOOP_BACK")
    reset.parameter, reset.reset = parameter.id, True
    layout.template_curve_mapping(node, "mapping")
