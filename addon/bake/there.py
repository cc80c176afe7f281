# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks, in pauses, for the files that deformers play or edit, and lets their panels say which are missing.

Panels are drawn often, and disks may be slow.
"""

from collections.abc import Iterator

import bpy
from bpy.types import Object

from ..core import status
from ..core.errors import SinewError
from ..core.status import Level, Remedy, Status
from ..properties import SinewDeformer
from ..session.datablocks import owners
from ..session.datablocks.shapes import baked
from . import paths, sequences

_FILES = ("PC2", "MDD")
_REMEDY = Remedy.BAKE | Remedy.FIND_FILE | Remedy.UNBAKE


def has_files() -> bool:
    """Whether there is something to look for."""
    return any(deformer.definition.keyed or _is_played(deformer) for _obj, deformer in _deformers())


def look() -> None:
    """Look for all files now."""
    scene = bpy.context.scene
    frames = range(scene.frame_start, scene.frame_end + 1)
    for obj, deformer in _deformers():
        missing = sequences.missing_frames(scene, obj, deformer, frames)
        lines = [Status(Level.INFO, text) for text in missing]
        path = paths.absolute(deformer.bake.filepath) if _is_played(deformer) else None
        if path is not None and not path.is_file():
            text = f"The baked file {path.name} is missing"
            lines.insert(0, Status(Level.WARNING, text, remedy=_REMEDY))
        status.put_files(deformer.uid, tuple(lines))


def play_instead(obj: Object, deformer: SinewDeformer, filepath: str) -> None:
    """Play another file, which holds the same frames."""
    modifier = baked.find_cache(obj, deformer)
    if modifier is None:
        raise SinewError(f"{deformer.name} has lost its Mesh Cache modifier - Unbake, then bake again")
    modifier.filepath = deformer.bake.filepath = filepath
    look()


def _is_played(deformer: SinewDeformer) -> bool:
    return deformer.bake.result in _FILES


def _deformers() -> Iterator[tuple[Object, SinewDeformer]]:
    return ((obj, deformer) for obj in owners.owners() for deformer in obj.sinew.deformers)
