# SPDX-License-Identifier: GPL-3.0-or-later
"""How a property is declared: library overrides may change all of them, and a change redraws the shape."""

from collections.abc import Callable

from bpy.props import CollectionProperty
from bpy.types import Context, PropertyGroup

OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def reshape(values: PropertyGroup, _context: Context) -> None:
    """The object is evaluated again, since its shape may be another."""
    values.id_data.update_tag(refresh={"OBJECT"})


def setting(declare: Callable, update: Callable | None = reshape, **keywords):
    """What an artist sets. ``declare`` is a function of bpy.props, ``update`` None where no shape changes."""
    return declare(override=OVERRIDABLE, update=update, **keywords)


def record(declare: Callable, **keywords):
    """What the add-on notes for itself, unseen by the artist."""
    if declare is CollectionProperty:
        return setting_list(options={"HIDDEN"}, **keywords)
    return declare(override=OVERRIDABLE, options={"HIDDEN"}, **keywords)


def setting_list(**keywords):
    """A list that library overrides may also add to."""
    return CollectionProperty(override={*OVERRIDABLE, "USE_INSERTION"}, **keywords)
