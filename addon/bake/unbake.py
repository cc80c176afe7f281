# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo a bake."""

from bpy.types import Object

from ..core.errors import SinewError
from ..properties import SinewDeformer
from ..session.state import sessions
from . import paths, record
from .files import SUFFIXES


@sessions.suspended()
def unbake(obj: Object, deformer: SinewDeformer, delete_file: bool = False) -> list[str]:
    """Make the deformer live again and remove what the bake added. Returns warnings for the user.

    The cache file stays, so that undo can use it again, unless ``delete_file``.
    """
    if not deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is not baked")
    filepath = deformer.bake.filepath if deformer.bake.result in ("PC2", "MDD") else ""
    warnings = record.remove(obj, deformer)
    if delete_file and filepath:
        warnings += _delete(deformer, filepath)
    return warnings


def _delete(deformer: SinewDeformer, filepath: str) -> list[str]:
    """Delete the cache file if it lies beside the .blend file and no other deformer plays it."""
    path = paths.absolute(filepath)
    if path.suffix.lower() not in SUFFIXES.values() or not paths.is_beside(filepath):
        return [f"{path} was not deleted: it is not a cache file in the folder of this .blend file"]
    if not paths.is_free(filepath, deformer):
        return [f"{path} was not deleted: another deformer plays it"]
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        return [f"{path} was not deleted: {error.strerror}"]
    return []
