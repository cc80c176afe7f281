# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a bake may write: beside the .blend file, or at a path that the user chose."""

import os
from collections.abc import Sequence
from pathlib import Path

import bpy
from bpy.types import Object

from ..core.errors import SinewError
from ..properties import SinewDeformer, deformers_of
from .files import SUFFIXES

FOLDER = "sinew_cache"
_LONGEST = 120  # bytes that names in Blender may contribute to a file name, which may have 255
UNSAVED = "Save the file first, or choose a path - caches are written beside the .blend"


def absolute(filepath: str) -> Path:
    """A path as Blender writes it (``//`` is the folder of the .blend) for the operating system."""
    return Path(os.path.abspath(bpy.path.abspath(filepath)))


def _home() -> Path:
    """The folder of the .blend file, after symbolic links are followed."""
    return Path(os.path.realpath(bpy.path.abspath("//")))


def is_beside(filepath: str) -> bool:
    """Whether a path lies in the folder of the .blend file, after symbolic links are followed."""
    return Path(os.path.realpath(absolute(filepath))).is_relative_to(_home())


def below(folder: Path, *names: str) -> Path:
    """The path of these names below a folder. Raises an error if a link there leads outside the folder."""
    path = folder.joinpath(*names)
    if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder)):
        raise SinewError(f"{path} is a link that leads outside {folder} - remove the link")
    return path


def default(obj: Object, deformer: SinewDeformer, target: str, taken: Sequence[str] = ()) -> str:
    """``//sinew_cache/<file>/<object>-<deformer>.pc2``, or with the key of the deformer if that is taken.

    Each .blend file has a folder of its own, since versions of a file often lie in one folder.
    """
    name = obj.name if target == "ALEMBIC" else f"{obj.name}-{deformer.name}"
    path = _beside(name, target)
    return path if is_free(path, deformer, taken) else _beside(name, target, f"-{deformer.uid}")


def _beside(name: str, target: str, key: str = "") -> str:
    file = bpy.path.clean_name(Path(bpy.data.filepath).stem)
    short = bpy.path.clean_name(name).encode()[:_LONGEST].decode(errors="ignore")
    return f"//{FOLDER}/{file}/{short}{key}{SUFFIXES[target]}"


def is_free(path: str, deformer: SinewDeformer, taken: Sequence[str] = ()) -> bool:
    """Whether no other baked deformer plays this file, and the file is none of those that are ``taken``."""
    played = (
        other.bake.filepath
        for obj in bpy.data.objects
        if obj.library is None
        for other in deformers_of(obj)
        if other.uid != deformer.uid and other.bake.is_baked
    )
    return not any(_same(path, other) for other in (*taken, *played))


def _same(a: str, b: str) -> bool:
    return bool(a) and os.path.normcase(absolute(a)) == os.path.normcase(absolute(b))


def choose(obj: Object, deformer: SinewDeformer, target: str, chosen: str, taken: Sequence[str] = ()) -> str:
    """The path of a bake, as it is stored: ``chosen`` by the user, that of the last bake, or the default.

    The last two are none of those that are ``taken``, which other deformers of the same bake are written to.
    A path that comes from the .blend file itself is used only if it lies beside the file, since the file may
    come from someone else.
    """
    last = deformer.bake.filepath
    if _is_given(chosen):
        return _stored(_with_suffix(chosen, target))
    if last and last.lower().endswith(SUFFIXES[target]) and is_free(last, deformer, taken):
        if not is_beside(last):
            raise SinewError(
                f"The last bake was written to {last}, outside the folder of this file - choose a path"
            )
        return last
    return _checked(default(obj, deformer, target, taken))


def choose_for_transfer(source: Object, target: Object, chosen: str) -> str:
    """The path of a transfer between two meshes, as it is stored: ``chosen`` by the user, or the default."""
    if _is_given(chosen):
        return _stored(_with_suffix(chosen, "PC2"))
    return _checked(_beside(f"{target.name}-from-{source.name}", "PC2"))


def _is_given(chosen: str) -> bool:
    """Whether the user chose a path. Raises an error if there is no .blend file to write beside."""
    if not bpy.data.filepath and (not chosen or chosen.startswith("//")):
        raise SinewError(UNSAVED)
    return bool(chosen)


def _checked(path: str) -> str:
    if not is_beside(path):
        raise SinewError(
            f"The folder {FOLDER} is a link that leads outside the folder of this file - choose a path"
        )
    return path


def offered_path(obj: Object, deformer: SinewDeformer, target: str) -> str:
    """The path that a file browser starts with. The user confirms it, so it may lie anywhere."""
    last = deformer.bake.filepath
    if last.lower().endswith(SUFFIXES[target]):
        return str(absolute(last))
    if not bpy.data.filepath:
        return f"{bpy.path.clean_name(obj.name)}{SUFFIXES[target]}"
    return str(absolute(default(obj, deformer, target)))


def _with_suffix(path: str, target: str) -> str:
    """The path with the suffix of the target, so that a bake never replaces a file of another format."""
    stem, suffix = os.path.splitext(path)
    if suffix.lower() == SUFFIXES[target]:
        return path
    return (stem if suffix.lower() in SUFFIXES.values() else path) + SUFFIXES[target]


def _stored(path: str) -> str:
    """The path relative to the .blend file if it lies beside it, so that both can be moved together.

    It has the slashes that every system reads. Links and drive letters are followed first: on Windows no
    relative path leads to another drive.
    """
    if not path.startswith("//"):
        if not bpy.data.filepath or not is_beside(path):
            return str(absolute(path))
        path = "//" + os.path.relpath(os.path.realpath(absolute(path)), _home())
    return path.replace(os.sep, "/")
