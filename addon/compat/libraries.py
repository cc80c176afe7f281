# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells datablocks apart, and those of libraries that Blender did not find."""

import os
from collections.abc import Hashable

import bpy
from bpy.types import ID, Object
from mathutils import Matrix

_NOWHERE = Matrix()


def session_key(datablock: ID) -> Hashable:
    """What only this datablock has until another file is opened.

    Newer releases number them. In others it changes with the name: an address alone is used again.
    """
    return getattr(datablock, "session_uid", None) or (datablock.name, datablock.as_pointer())


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
