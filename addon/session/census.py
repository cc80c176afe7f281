# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects own deformers. Names are kept, never objects; a new number of objects repeats the scan."""

from dataclasses import dataclass

import bpy
from bpy.types import Object

from ..properties import deformers_of
from . import rig

_Key = str | tuple[str, str]  # how ``bpy.data.objects`` finds an object: by name, or by name and library


@dataclass
class _Census:
    """Owners by key; and whether some object shows shapes that are not its own."""

    objects: int = -1
    owners: tuple[_Key, ...] = ()
    has_copies: bool = False


_census = _Census()


def forget_owners() -> None:
    """Objects may have gained or lost deformers."""
    _census.objects = -1


def owners() -> list[Object]:
    """Objects that own deformers, without copies that still share the shapes of another."""
    if _census.objects != len(bpy.data.objects):
        _take()
    objects = bpy.data.objects
    found = [objects.get(key) for key in _census.owners]
    if not all(obj is not None and len(deformers_of(obj)) for obj in found):
        _take()  # renamed, or removed while another was added
        found = [objects[key] for key in _census.owners]
    return found


def posed_by(control: Object) -> Object | None:
    """The object that this control, one of its bones, or this cage moves."""
    for obj in owners():
        for deformer in obj.sinew.deformers:
            if deformer.cage == control or any(handle.control == control for handle in deformer.handles):
                return obj
    return None


def has_copies() -> bool:
    """Some object shares the shapes of another, or overrides linked ones: see ``upkeep``."""
    owners()
    return _census.has_copies


def _take() -> None:
    seen: set[str] = set()
    keys: list[_Key] = []
    _census.has_copies = False
    for obj in bpy.data.objects:
        uids = [deformer.uid for deformer in deformers_of(obj)]
        if len(set(uids)) < len(uids):
            _census.has_copies = True
        if any(uid in seen for uid in uids):
            _census.has_copies = True
        elif uids:
            keys.append((obj.name, obj.library.filepath) if obj.library else obj.name)
            if obj.library is None and any(rig.is_linked(deformer.proxy) for deformer in deformers_of(obj)):
                _census.has_copies = True
        seen.update(uids)
    _census.objects, _census.owners = len(bpy.data.objects), tuple(keys)
