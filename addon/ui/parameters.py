# SPDX-License-Identifier: GPL-3.0-or-later
"""A parameter of a method, drawn by its kind."""

from bpy.types import UILayout

from .. import session
from ..core.methods import Curve, Parameter, group_property
from ..ids import Operators
from ..properties import SinewDeformer


def draw_parameter(layout: UILayout, deformer: SinewDeformer, parameter: Parameter) -> None:
    """Its value; and the vertex group that scales it, where one may."""
    if isinstance(parameter, Curve):
        _draw_curve(layout, deformer, parameter)
        return
    row = layout.row(align=True)
    row.prop(deformer.parameters, parameter.id)
    if parameter.paintable:
        obj = deformer.id_data
        row.prop_search(deformer.parameters, group_property(parameter), obj, "vertex_groups", text="")


def _draw_curve(layout: UILayout, deformer: SinewDeformer, parameter: Curve) -> None:
    """A button while the curve is the default one, then its points."""
    row = layout.row(align=True)
    node = session.curve_node(deformer, parameter)
    if node is None:
        row.operator(Operators.CURVE_EDIT, text=parameter.label, icon="FCURVE").parameter = parameter.id
        return
    row.label(text=parameter.label)
    reset = row.operator(Operators.CURVE_EDIT, text="", icon="LOOP_BACK")
    reset.parameter, reset.reset = parameter.id, True
    layout.template_curve_mapping(node, "mapping")
