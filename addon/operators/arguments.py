# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties that several operators have, as functions: an operator states only what is its own."""

from collections.abc import Callable, Iterable
from typing import Any

from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from ..compat import beside_the_file
from ..core.labels import items_of
from ..core.methods import BY_ID, METHODS, Method
from ..properties import field
from ..session.controls import kinds

# The methods that regions steer.
REGION_METHODS = tuple(method for method in METHODS if kinds.marks_regions(method) and not method.wraps)


def once(kind: Callable, **details: Any) -> field:
    """A property of this ``kind`` that later calls do not take over: each begins with the default."""
    return field(kind, options={"SKIP_SAVE"}, **details)


def given(kind: Callable, **details: Any) -> field:
    """The same, for what only buttons and scripts say: it is not shown."""
    return field(kind, options={"HIDDEN", "SKIP_SAVE"}, **details)


def file_path(name: str, description: str) -> Any:
    """A file, from the root of a disk or, after ``//``, from the folder of the .blend file."""
    options = {"SKIP_SAVE"} | beside_the_file()
    return field(StringProperty, subtype="FILE_PATH", options=options).named(name, description)


def row_index(description: str, **details: Any) -> Any:
    """Which row of a list, where -1 means the active one or all."""
    return field(IntProperty, default=-1, min=-1, **details).named("Index", description)


def distance(name: str, description: str, **details: Any) -> Any:
    """A distance that is not negative, shown in the units of the scene."""
    return field(FloatProperty, subtype="DISTANCE", min=0.0, **details).named(name, description)


def method_choice(
    methods: Iterable[Method], description: str, default: str, name: str = "Method", **details: Any
) -> Any:
    """One of these methods. ``default`` is the id of one."""
    items = items_of(tuple(methods))
    return field(EnumProperty, items=items, default=BY_ID[default].number, **details).named(name, description)
