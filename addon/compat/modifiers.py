# SPDX-License-Identifier: GPL-3.0-or-later
"""The order of the modifier stack."""

from contextlib import suppress

import bpy
from bpy.types import Object


def move_modifier(obj: Object, name: str, index: int) -> bool:
    """Move a modifier to a place in the stack; False if Blender does not allow it there.

    Before Blender 4.0 only an operator can move modifiers.
    """
    modifiers = obj.modifiers
    at = modifiers.find(name)
    if at == index:
        return True
    if hasattr(modifiers, "move"):
        with suppress(RuntimeError):  # where it stops before the place
            modifiers.move(at, index)
    else:
        with bpy.context.temp_override(object=obj):
            bpy.ops.object.modifier_move_to_index(modifier=name, index=index)
    return modifiers.find(name) == index
