# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties that several operators have, as functions: an operator states only what is its own."""

from collections.abc import Callable, Iterable
from typing import Any

from bpy.props import EnumProperty, FloatProperty, IntProperty

from ..core.labels import items_of
from ..core.methods import BY_ID, METHODS, Method
from ..session.controls import kinds

# The methods that regions steer.
REGION_METHODS = tuple(method for method in METHODS if kinds.marks_regions(method) and not method.wraps)


def once(kind: Callable, name: str, description: str, **details: Any) -> Any:
    """A property of this ``kind`` that later calls do not take over: each begins with the default."""
    return kind(name=name, description=description, options={"SKIP_SAVE"}, **details)


def row_index(description: str, **details: Any) -> Any:
    """Which row of a list, where -1 means the active one or all."""
    return IntProperty(name="Index", default=-1, min=-1, description=description, **details)


def distance(name: str, description: str, **details: Any) -> Any:
    """A distance that is not negative, shown in the units of the scene."""
    return FloatProperty(name=name, description=description, subtype="DISTANCE", min=0.0, **details)


def method_choice(
    methods: Iterable[Method], description: str, default: str, name: str = "Method", **details: Any
) -> Any:
    """One of these methods. ``default`` is the id of one."""
    items = items_of(tuple(methods))
    return EnumProperty(
        name=name, items=items, default=BY_ID[default].number, description=description, **details
    )
