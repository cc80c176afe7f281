# SPDX-License-Identifier: GPL-3.0-or-later
"""How properties are declared. Library overrides may change all of them."""

from collections.abc import Callable

from bpy.props import CollectionProperty, FloatVectorProperty
from bpy.types import Context, PropertyGroup

from ..core.field import field

SHARE = {"default": 1.0, "min": 0.0, "max": 1.0, "subtype": "FACTOR"}
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
LIST_OVERRIDABLE = {*OVERRIDABLE, "USE_INSERTION"}


def evaluate_again(values: PropertyGroup, _context: Context) -> None:
    """Let Blender evaluate the object again, since its shape may have changed."""
    values.id_data.update_tag(refresh={"OBJECT"})


def setting(declare: Callable, **keywords) -> field:
    """A property of a deformer that an artist sets, and that affects the shape."""
    return field(declare, **{"override": OVERRIDABLE, "update": evaluate_again, **keywords})


def option(declare: Callable, **keywords) -> field:
    """A property of a deformer that an artist sets, and that does not affect the shape."""
    return field(declare, override=OVERRIDABLE, **keywords)


def record(declare: Callable, **keywords):
    """A property that the add-on sets, hidden from the artist."""
    override = LIST_OVERRIDABLE if declare is CollectionProperty else OVERRIDABLE
    return declare(override=override, options={"HIDDEN"}, **keywords)


def matrix(name: str, description: str):
    """A record of a matrix of four rows."""
    return record(FloatVectorProperty, name=name, size=16, subtype="MATRIX", description=description)


def affine_map(name: str, description: str):
    """A record of the three rows of an affine map."""
    return record(FloatVectorProperty, name=name, size=12, description=description)


def row_at(rows, index: int):
    """The row of a list at an index; None where a file or a script names one that is not there."""
    return rows[index] if 0 <= index < len(rows) else None


def setting_list(**keywords):
    """A list to which library overrides may also add items."""
    return CollectionProperty(override=LIST_OVERRIDABLE, **keywords)
