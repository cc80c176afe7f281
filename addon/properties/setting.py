# SPDX-License-Identifier: GPL-3.0-or-later
"""How properties are declared. Library overrides may change all of them."""

from collections.abc import Callable

from bpy.props import CollectionProperty
from bpy.types import Context, PropertyGroup

OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def evaluate_again(values: PropertyGroup, _context: Context) -> None:
    """Let Blender evaluate the object again, since its shape may have changed."""
    values.id_data.update_tag(refresh={"OBJECT"})


def setting(declare: Callable, update: Callable | None = evaluate_again, **keywords):
    """A property that an artist sets. ``declare`` is a function of bpy.props.

    ``update`` is None if the property does not affect the shape.
    """
    return declare(override=OVERRIDABLE, update=update, **keywords)


def record(declare: Callable, **keywords):
    """A property that the add-on sets, hidden from the artist."""
    if declare is CollectionProperty:
        return setting_list(options={"HIDDEN"}, **keywords)
    return declare(override=OVERRIDABLE, options={"HIDDEN"}, **keywords)


def row_at(rows, index: int):
    """The row of a list at an index; None where a file or a script names one that is not there."""
    return rows[index] if 0 <= index < len(rows) else None


def setting_list(**keywords):
    """A list to which library overrides may also add items."""
    return CollectionProperty(override={*OVERRIDABLE, "USE_INSERTION"}, **keywords)
