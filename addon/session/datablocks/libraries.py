# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of libraries that are missing. In their place Blender puts empty objects at the origin.

This only reads Blender's data.
"""

from bpy.types import Object

from ...compat import is_placeholder


def is_lost(obj: Object) -> bool:
    """Whether an object, or what it consists of, is missing with its library."""
    data = obj.data
    return (obj.library is not None and is_placeholder(obj)) or (
        data is not None and data.library is not None and is_placeholder(data)
    )


def explain(control: Object) -> str:
    """What to say about the control of a deformer that is missing with its library."""
    library = (control if control.library is not None else control.data).library
    return (
        f"{control.name} was not found in {library.filepath}, and what it moves stays where it was - put the "
        "file there and load this one again, or pick another control"
    )
