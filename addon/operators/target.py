# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the object that an operator works on: the active one, or the one that the active control moves."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import Context, Object

from ..core.errors import SinewError
from ..core.memory import remember
from ..properties import SinewDeformer, deformers_of
from ..session.controls import kinds
from ..session.targets import targets
from . import entering

LINKED = "This object is linked - make a library override first"
_CONVERTIBLE = ("SURFACE", "META")
_came_from: dict[str, str] = remember({})  # the object that the artist worked on, by control


def target_of(context: Context) -> Object | None:
    """The object to work on, mostly a mesh; None if there is none."""
    obj = context.object
    if obj is None:
        return None
    can_be_moved = targets.can_be_moved(obj)
    if can_be_moved and deformers_of(obj):
        return obj
    posed = kinds.posed_by(obj, preferred=_came_from.get(obj.name, ""))
    return posed or (obj if can_be_moved else _posed_with(context, obj))


def selected_targets(context: Context, active: Object) -> list[Object]:
    """The active object, then the other selected ones that can be moved and move nothing themselves."""
    others = [
        obj
        for obj in context.selected_objects
        if obj != active and targets.can_be_moved(obj) and obj.library is None and kinds.posed_by(obj) is None
    ]
    return [active, *others]


def show_control(context: Context, obj: Object, control: Object) -> None:
    """Make the control of an object active. If it moves others too, the panel stays with this object.

    The Modifiers tab shows the active object only. Where that was used, the object stays active.
    """
    _came_from[control.name] = obj.name
    if context.area is None or context.area.type != "PROPERTIES" or control.type == "ARMATURE":
        context.view_layer.objects.active = control


def _posed_with(context: Context, armature: Object) -> Object | None:
    """The only object to move that is selected together with an armature in Pose Mode."""
    if armature.mode != "POSE":
        return None
    movable = [other for other in context.selected_objects if targets.can_be_moved(other)]
    return movable[0] if len(movable) == 1 else None


def explain_no_target(context: Context) -> tuple[str, bool]:
    """What an artist can do if there is no object to work on, and whether Convert to Mesh does it."""
    obj = context.object
    if obj is None or obj.type not in _CONVERTIBLE:
        return "Select a mesh object, or a control of one", False
    return (
        f"{obj.name} is a {targets.label(obj)} object, which Sinew cannot move - convert it to a mesh",
        True,
    )


def object_named(context: Context, name: str) -> Object:
    """The object of this name in the scene."""
    found = context.scene.objects.get(name)
    if found is None:
        raise SinewError(f"There is no object '{name}' in the scene")
    return found


def deformer_index(obj: Object, index: int) -> int:
    """The index of a deformer; -1 means the active one."""
    count = len(obj.sinew.deformers)
    if index >= count:
        raise SinewError(f"{obj.name} has {count} deformers, counted from 0 - there is no number {index}")
    return min(max(obj.sinew.active_deformer, 0), count - 1) if index < 0 else index


def handle_index(deformer: SinewDeformer, index: int) -> int:
    """The index of a handle; -1 means the active one."""
    count = len(deformer.handles)
    chosen = min(deformer.active_handle, count - 1) if index < 0 else index
    if not 0 <= chosen < count:
        raise SinewError(f"{deformer.name} has {count} handles, counted from 0 - there is no number {chosen}")
    return chosen


@contextmanager
def object_mode(context: Context, obj: Object) -> Iterator[None]:
    """Leave Edit Mode, since objects can be changed in Object Mode only, and return to it afterwards."""
    mode = obj.mode
    if mode != "EDIT" or context.object is None or context.object.mode != mode:
        yield  # in Edit Mode beside an active object that is not: this would leave that of the other one
        return
    active, noted = context.view_layer.objects.active, entering.take(obj)
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        shown = context.view_layer.objects.active
        context.view_layer.objects.active = active
        bpy.ops.object.mode_set(mode=mode)
        if shown not in (None, active):
            noted = shown.name
        entering.note(obj, noted)
