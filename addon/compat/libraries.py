# SPDX-License-Identifier: GPL-3.0-or-later
"""Datablocks of libraries that Blender did not find."""

import os

import bpy
from bpy.types import ID, Object
from mathutils import Matrix

_NOWHERE = Matrix()


def is_placeholder(linked: ID) -> bool:
    """Whether Blender made an empty datablock in place of a linked one that it did not find.

    Since 4.0, Blender tells. Before, it is one that looks like new, from a file that is not there.
    """
    if hasattr(linked, "is_missing"):
        return linked.is_missing
    if isinstance(linked, Object):
        looks_new = linked.type == "EMPTY" and linked.parent is None and linked.matrix_basis == _NOWHERE
    else:
        looks_new = not len(getattr(linked, "vertices", ()))
    library = linked.library
    return looks_new and not os.path.isfile(bpy.path.abspath(library.filepath, library=library.parent))
