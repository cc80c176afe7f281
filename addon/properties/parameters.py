# SPDX-License-Identifier: GPL-3.0-or-later
"""One property group per method, made from its registry row."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from ..core.methods import METHODS, Bool, Choice, Float, Int, Method, Parameter, group_property
from .setting import setting

_SUBTYPES = {"length": "DISTANCE", "angle": "ANGLE"}


def declare(parameter: Parameter):
    """The property of a parameter."""
    common = {"name": parameter.label, "description": parameter.description, "default": parameter.default}
    if isinstance(parameter, Choice):
        items = tuple((*item, number) for number, item in enumerate(parameter.items))
        return setting(EnumProperty, items=items, **common)
    if isinstance(parameter, Bool):
        return setting(BoolProperty, **common)
    limits = {
        "min": parameter.minimum,
        "max": parameter.maximum,
        "soft_max": min(parameter.soft_maximum, parameter.maximum),
    }
    if isinstance(parameter, Int):
        return setting(IntProperty, **limits, **common)
    if isinstance(parameter, Float):
        return setting(
            FloatProperty,
            **limits,
            precision=parameter.precision,
            step=round(100 * parameter.step),
            subtype=_SUBTYPES.get(parameter.unit, "NONE"),
            **common,
        )
    raise TypeError(f"{parameter.id}: no property for {type(parameter).__name__}")


def _group_of(method: Method) -> type:
    annotations = {parameter.id: declare(parameter) for parameter in method.parameters}
    for parameter in method.paintable:
        annotations[group_property(parameter)] = setting(
            StringProperty,
            name=f"{parameter.label} Group",
            description=f"Vertex group that scales {parameter.label} per vertex; none means the whole mesh",
        )
    names = {"__annotations__": annotations, "__doc__": method.summary, "__module__": __name__}
    return type(f"SINEW_PG_{method.id}", (PropertyGroup,), names)


GROUPS: dict[str, type] = {method.id: _group_of(method) for method in METHODS}
