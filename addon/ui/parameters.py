# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the settings of a method, each by its type: the main ones, and all others."""

from collections.abc import Iterator

from bpy.types import Context, PropertyGroup, UILayout

from ..core.methods import Curve, Float, GridPoints, Parameter, UvMap, group_property
from ..ids import Operators
from ..properties import SinewDeformer
from ..session.actions.controls import control_list
from ..session.datablocks import references
from .control import rows
from .layouts import draw_field
from .text import is_wide

_GROUP = 1.6  # the width of the picker of a group in a narrow region, in units of a button


def draw_main(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw the main settings of the method, and how much of the deformation is shown."""
    row = control_list.active_row(deformer)
    of_row = {parameter.id: parameter for parameter in deformer.definition.control_parameters}
    for method, values in deformer.methods:
        known = {parameter.id: parameter for parameter in method.parameters}
        for name in method.main:
            if name in known:
                draw_parameter(context, layout, values, known[name])
            elif name not in of_row:
                draw_field(context, layout, deformer, name)
            elif row is not None:
                draw_field(context, layout, row, name, text=rows.parameter_text(row, of_row[name]))
    draw_field(context, layout, deformer, "factor", slider=True)


def draw_others(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw the other settings that the method uses with its present choices, the least changed ones last."""
    for values, parameter in sorted(_others(deformer), key=lambda pair: pair[1].advanced):
        draw_parameter(context, layout, values, parameter)


def _others(deformer: SinewDeformer) -> Iterator[tuple[PropertyGroup, Parameter]]:
    for method, values in deformer.methods:
        for parameter in method.parameters:
            if parameter.id not in method.main and parameter.is_used(values):
                yield values, parameter


def draw_parameter(context: Context, layout: UILayout, values: PropertyGroup, parameter: Parameter) -> None:
    """Draw the value of a parameter, and the vertex group that scales it if it can be painted."""
    if isinstance(parameter, Curve):
        _draw_curve(layout, values, parameter)
        return
    if isinstance(parameter, UvMap):
        among = (values.id_data.data, "uv_layers")
        draw_field(context, layout, values, parameter.id, among=among, icon="GROUP_UVS")
        return
    looks = {"slider": True} if _has_ends(parameter) else {}
    row = draw_field(context, layout, values, parameter.id, **looks)
    if isinstance(parameter, GridPoints):
        row.operator(Operators.GRID_NEW, text="", icon="ADD")
    if parameter.paintable:
        group = row.row(align=True)
        if not is_wide(context):
            group.ui_units_x = _GROUP
        group.prop_search(values, group_property(parameter), values.id_data, "vertex_groups", text="")


def _has_ends(parameter: Parameter) -> bool:
    """Whether a slider shows all values of a number: it ends where the parameter ends."""
    return isinstance(parameter, Float) and parameter.span.soft >= parameter.span.maximum


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
