# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects own deformers. Names are kept, never objects; a new number of objects repeats the scan."""

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
from bpy.types import Object

from ...core.memory import remember
from ...properties import deformers_of
from . import shapes

_Key = str | tuple[str, str]  # how ``bpy.data.objects`` finds an object: by name, or by name and library


@dataclass
class _Found:
    """Owners by key; and whether some object shows shapes that are not its own."""

    objects: int = -1
    owners: tuple[_Key, ...] = ()
    has_copies: bool = False

    def clear(self) -> None:
        """Look for them again."""
        self.objects = -1


_found = remember(_Found())


def forget_owners() -> None:
    """Objects may have gained or lost deformers."""
    _found.clear()


def owners() -> list[Object]:
    """Objects that own deformers, without copies that still share the shapes of another."""
    if _found.objects != len(bpy.data.objects):
        _take()
    objects = bpy.data.objects
    found = [objects.get(key) for key in _found.owners]
    if not all(obj is not None and len(deformers_of(obj)) for obj in found):
        _take()  # renamed, or removed while another was added
        found = [objects[key] for key in _found.owners]
    return found


def has_copies() -> bool:
    """Some object shares the shapes of another, or overrides linked ones: see ``upkeep``."""
    owners()
    return _found.has_copies


def copies() -> list[Object]:
    """Objects with a deformer that shares its key with another, or shows shapes linked from a library."""
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
    """Each object with deformers; whether no earlier one has their keys; and whether each deformer has a key
    and shapes of its own.
    """
    known: set[str] = set()
    for obj in bpy.data.objects:
        deformers = deformers_of(obj)
        keys = [deformer.uid for deformer in deformers]
        if keys:
            linked = obj.library is None and any(shapes.is_linked(deformer.proxy) for deformer in deformers)
            yield obj, known.isdisjoint(keys), not linked and len(set(keys)) == len(keys)
        known.update(keys)
