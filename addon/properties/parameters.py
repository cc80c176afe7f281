# SPDX-License-Identifier: GPL-3.0-or-later
"""One property group a method, made from its registry row."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Context, PropertyGroup

from ..core.methods import METHODS, Bool, Choice, Float, Int, Method, Parameter, group_property

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}


def _changed(values: PropertyGroup, _context: Context) -> None:
    values.id_data.update_tag(refresh={"OBJECT"})


def _declare(parameter: Parameter):
    common = {
        "name": parameter.label or parameter.id.replace("_", " ").title(),
        "description": parameter.description,
        "override": _OVERRIDE,
        "update": _changed,
        "default": parameter.default,
    }
    if isinstance(parameter, Choice):
        items = tuple((*item, number) for number, item in enumerate(parameter.items))
        return EnumProperty(items=items, **common)
    if isinstance(parameter, Bool):
        return BoolProperty(**common)
    limits = {
        "min": parameter.minimum,
        "max": parameter.maximum,
        "soft_max": min(parameter.soft_maximum, parameter.maximum),
    }
    if isinstance(parameter, Int):
        return IntProperty(**limits, **common)
    if isinstance(parameter, Float):
        return FloatProperty(**limits, precision=parameter.precision, step=1, **common)
    raise TypeError(f"{parameter.id}: no property for {type(parameter).__name__}")


def _group_of(method: Method) -> type:
    annotations = {parameter.id: _declare(parameter) for parameter in method.parameters}
    for parameter in method.paintable:
        annotations[group_property(parameter)] = StringProperty(
            name=f"{parameter.label} Group",
            description=f"Vertex group that scales {parameter.label} per vertex; none means the whole mesh",
            update=_changed,
            override=_OVERRIDE,
        )
    names = {"__annotations__": annotations, "__doc__": method.summary, "__module__": __name__}
    return type(f"SINEW_PG_{method.id}", (PropertyGroup,), names)


GROUPS: dict[str, type] = {method.id: _group_of(method) for method in METHODS}
