# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked deformers, which rest while their bake plays: the modifier that plays it, and the line in the panel.

This only reads Blender's data.
"""

import os

import bpy
from bpy.types import Modifier, Object, ShapeKey

from ....core import status
from ....core.status import Level, Remedy, Status
from ....properties import SinewDeformer
from ...targets import modified

_LOST = "The Mesh Cache modifier of the bake was removed - press Unbake"


def find_cache(obj: Object, deformer: SinewDeformer) -> Modifier | None:
    """The modifier that plays the file of a deformer, also after renames, moves and saves in another folder.

    It is found by the path of the file, by the name of the file, or by its own name. If several modifiers
    fit, the one just after the modifier of the deformer is taken.
    """
    bake = deformer.bake
    if bake.result not in ("PC2", "MDD"):
        return None
    replaced = modified.shown_by(obj, deformer)
    best, most = None, (False, False, False, False)
    previous = None
    for modifier in obj.modifiers:
        if modifier.type == "MESH_CACHE":
            same_file = _name(modifier.filepath) == _name(bake.filepath)
            fits = (modifier.filepath == bake.filepath, same_file, modifier.name == bake.modifier)
            rank = (*fits, previous is not None and previous == replaced)
            if any(fits) and rank > most:
                best, most = modifier, rank
        previous = modifier
    return best


def _name(path: str) -> str:
    """The file name in a path of any operating system."""
    return os.path.basename(path.replace("\\", "/"))


def overwrites(modifier: Modifier | ShapeKey) -> bool:
    """Whether nothing of the shape before a modifier is left after it."""
    if isinstance(modifier, ShapeKey) or modifier.type != "MESH_CACHE" or modifier.deform_mode != "OVERWRITE":
        return False
    return modifier.factor == 1.0 and not modifier.vertex_group


def report(obj: Object) -> None:
    """Tell in the panel which deformers are baked, or that the file of a bake is missing."""
    for deformer in obj.sinew.deformers:
        replaced = modified.shown_by(obj, deformer) if deformer.bake.is_baked else None
        if replaced is not None and not replaced.show_viewport:
            status.put(deformer.uid, _status(obj, deformer))


def _status(obj: Object, deformer: SinewDeformer) -> Status:
    if deformer.bake.result == "SHAPE_KEYS":
        return Status(Level.INFO, deformer.bake.summary)
    playing = find_cache(obj, deformer)
    if playing is None:
        return Status(Level.ERROR, _LOST, remedy=Remedy.UNBAKE)
    if not os.path.isfile(bpy.path.abspath(playing.filepath)):
        text = f"The cache file {playing.filepath} is missing - put it there, bake again, or Unbake"
        return Status(Level.ERROR, text, remedy=Remedy.BAKE | Remedy.UNBAKE)
    return Status(Level.INFO, deformer.bake.summary)
