# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that have deformers. Their names are kept, never the objects themselves.

All objects are looked at again when their number has changed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
from bpy.types import Object

from ...core.memory import remember
from ...properties import deformers_of
from .shapes import shapes

_Key = str | tuple[str, str]  # what ``bpy.data.objects`` finds an object by: its name, or name and library


@dataclass
class _Found:
    """The keys of the owners; and whether some object shows shape meshes that belong to another."""

    objects: int = -1
    owners: tuple[_Key, ...] = ()
    has_copies: bool = False

    def clear(self) -> None:
        """Look at all objects again at the next call."""
        self.objects = -1


_found = remember(_Found())


def forget_owners() -> None:
    """Call when objects may have gained or lost deformers."""
    _found.clear()


def owners() -> list[Object]:
    """The objects with deformers, without copies that still share the shape meshes of another object."""
    if _found.objects != len(bpy.data.objects):
        _take()
    objects = bpy.data.objects
    found = [objects.get(key) for key in _found.owners]
    if not all(obj is not None and len(deformers_of(obj)) for obj in found):
        _take()  # renamed, or removed while another was added
        found = [objects[key] for key in _found.owners]
    return found


def has_copies() -> bool:
    """Whether some object shares the shape meshes of another, or overrides linked ones."""
    if _found.objects != len(bpy.data.objects):
        _take()
    return _found.has_copies


def copies() -> list[Object]:
    """The objects with a deformer that has the key of another, or that shows shapes linked from a library."""
    return [obj for obj, is_owner, is_whole in _scan() if not (is_owner and is_whole)]


def _take() -> None:
    scanned = list(_scan())
    _found.owners = tuple(
        (obj.name, obj.library.filepath) if obj.library else obj.name
        for obj, is_owner, _is_whole in scanned
        if is_owner
    )
    _found.has_copies = not all(is_owner and is_whole for _obj, is_owner, is_whole in scanned)
    _found.objects = len(bpy.data.objects)


def _scan() -> Iterator[tuple[Object, bool, bool]]:
    """Each object with deformers; whether no earlier object has deformers with these keys; and whether each
    deformer has a key and shapes of its own.
    """
    known: set[str] = set()
    for obj in bpy.data.objects:
        deformers = deformers_of(obj)
        keys = [deformer.uid for deformer in deformers]
        if keys:
            linked = obj.library is None and any(shapes.is_linked(deformer.proxy) for deformer in deformers)
            yield obj, known.isdisjoint(keys), not linked and len(set(keys)) == len(keys)
        known.update(keys)
