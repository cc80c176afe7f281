# SPDX-License-Identifier: GPL-3.0-or-later
"""Take a bake back."""

from bpy.types import Object

from .. import session
from ..core.errors import SinewError
from ..properties import SinewDeformer
from . import paths, record
from .files import SUFFIXES


@session.suspended()
def unbake(obj: Object, deformer: SinewDeformer, delete_file: bool = False) -> list[str]:
    """Make the deformer live again, without what the bake added; what the user should know about it.

    The cache file stays, so that undo finds it, unless ``delete_file``.
    """
    if not deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is not baked")
    filepath = deformer.bake.filepath if deformer.bake.result in ("PC2", "MDD") else ""
    said = record.remove(obj, deformer)
    if delete_file and filepath:
        said += _delete(deformer, filepath)
    return said


def _delete(deformer: SinewDeformer, filepath: str) -> list[str]:
    """A file that the .blend names is deleted only beside it, and only where nothing else plays it."""
    path = paths.absolute(filepath)
    if path.suffix.lower() not in SUFFIXES.values() or not paths.is_beside(filepath):
        return [f"{path} is no cache in the file's folder, and stays"]
    if not paths.is_free(filepath, deformer):
        return [f"{path} stays: another deformer plays it"]
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        return [f"{path} stays: {error.strerror}"]
    return []
