# SPDX-License-Identifier: GPL-3.0-or-later
"""One property group per method, made from its registry row."""

from collections.abc import Callable

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import NodeTree, Object, PropertyGroup

from ..core.labels import items_of
from ..core.methods import (
    METHODS,
    Bool,
    Choice,
    Curve,
    Float,
    Int,
    Method,
    Parameter,
    Pointer,
    UvMap,
    group_property,
    wrapped,
)
from ..ids import Keys
from .setting import field, setting

BASE = "base"  # the property, and the native keyword, for the method that another method is put around
_SUBTYPES = {"length": "DISTANCE", "angle": "ANGLE"}


def _holds_curve(_values: PropertyGroup, tree: NodeTree) -> bool:
    return Keys.CURVE in tree


def _poll_for(types: tuple[str, ...]) -> Callable[[PropertyGroup, Object], bool]:
    def poll(values: PropertyGroup, obj: Object) -> bool:
        return obj != values.id_data and (not types or obj.type in types)

    return poll


def declare(parameter: Parameter):
    """The Blender property of a parameter."""
    return _undescribed(parameter).named(parameter.label, parameter.description)


def _undescribed(parameter: Parameter) -> field:
    if isinstance(parameter, Curve):
        return setting(PointerProperty, type=NodeTree, poll=_holds_curve)
    if isinstance(parameter, Pointer):
        return setting(PointerProperty, type=Object, poll=_poll_for(parameter.types))
    if isinstance(parameter, UvMap):
        return setting(StringProperty)
    default = parameter.default
    if isinstance(parameter, Choice):
        items = tuple((*item, number) for number, item in enumerate(parameter.items))
        return setting(EnumProperty, items=items, default=default)
    if isinstance(parameter, Bool):
        return setting(BoolProperty, default=default)
    if isinstance(parameter, Int | Float):
        span = parameter.span
        limits = {"min": span.minimum, "max": span.maximum, "soft_max": min(span.soft, span.maximum)}
    if isinstance(parameter, Int):
        return setting(IntProperty, default=default, **limits)
    if isinstance(parameter, Float):
        look = {"precision": span.digits, "step": round(100 * span.step)}
        look["subtype"] = _SUBTYPES.get(parameter.unit, "NONE")
        return setting(FloatProperty, default=default, **limits, **look)
    raise TypeError(f"{parameter.id}: no property for {type(parameter).__name__}")


def _group_of(method: Method) -> type:
    annotations = {parameter.id: declare(parameter) for parameter in method.parameters}
    for parameter in method.paintable:
        annotations[group_property(parameter)] = setting(StringProperty).named(
            f"{parameter.label} Group",
            f"Paint {parameter.label} by a vertex group; if empty, it is the same everywhere",
        )
    if method.wraps:
        annotations[BASE] = setting(
            EnumProperty, items=items_of(wrapped(method)), default=wrapped(method)[0].number
        ).named("Base Method", "Choose the method that moves the surface before this method adds to it")
    names = {"__annotations__": annotations, "__doc__": method.summary, "__module__": __name__}
    return type(f"SINEW_PG_{method.id}", (PropertyGroup,), names)


GROUPS: dict[str, type] = {method.id: _group_of(method) for method in METHODS}
