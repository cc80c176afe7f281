# SPDX-License-Identifier: GPL-3.0-or-later
"""Which object an operator works on: the active one, or the one that the active control poses."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import Context, Object

from .. import session
from ..core.errors import SinewError
from ..properties import SinewDeformer, deformers_of

_CONVERTIBLE = ("SURFACE", "META")


def target_of(context: Context) -> Object | None:
    """The object at hand, a mesh mostly."""
    obj = context.object
    if obj is None:
        return None
    can_be_moved = session.can_be_moved(obj)
    if can_be_moved and deformers_of(obj):
        return obj
    return session.posed_by(obj) or (obj if can_be_moved else _posed_with(context, obj))


def _posed_with(context: Context, armature: Object) -> Object | None:
    """In Pose Mode: the one mesh that is selected with the armature."""
    if armature.mode != "POSE":
        return None
    meshes = [other for other in context.selected_objects if other.type == "MESH"]
    return meshes[0] if len(meshes) == 1 else None


def no_mesh(context: Context) -> tuple[str, bool]:
    """What to do where there is no mesh object at hand, and whether Convert to Mesh does it."""
    obj = context.object
    if obj is not None and obj.type == "LATTICE":
        return f"{obj.name} is a lattice, which Sinew cannot move - put a cage around what it moves", False
    if obj is None or obj.type not in _CONVERTIBLE:
        return "Select a mesh object, or a control of one", False
    return (
        f"{obj.name} is a {session.label(obj)} object, which Sinew cannot move - convert it to a mesh",
        True,
    )


def has_target(operator: type, context: Context, mesh: bool = False) -> bool:
    """A poll: an editable object is at hand, a ``mesh`` where no other will do."""
    obj = target_of(context)
    if obj is None:
        operator.poll_message_set(no_mesh(context)[0])
        return False
    if obj.library is not None:
        operator.poll_message_set("This object is linked - make a library override first")
        return False
    if mesh and not session.is_mesh(obj):
        kind = session.label(obj)
        operator.poll_message_set(f"{obj.name} is a {kind} object, which cages move - convert it to a mesh")
        return False
    return True


def has_deformer(operator: type, context: Context, mesh: bool = False) -> bool:
    """A poll: an editable object with a deformer is at hand, a ``mesh`` where no other will do."""
    if not has_target(operator, context, mesh):
        return False
    if not deformers_of(target_of(context)):
        operator.poll_message_set("Add a deformer first")
        return False
    return True


def deformer_index(obj: Object, index: int) -> int:
    """A deformer's index, the active one's for -1."""
    count = len(obj.sinew.deformers)
    if index >= count:
        raise SinewError(f"{obj.name} has {count} deformers, counted from 0 - there is no number {index}")
    return min(max(obj.sinew.active_deformer, 0), count - 1) if index < 0 else index


def handle_index(deformer: SinewDeformer, index: int) -> int:
    """A handle's index, the active one's for -1."""
    count = len(deformer.handles)
    chosen = min(deformer.active_handle, count - 1) if index < 0 else index
    if not 0 <= chosen < count:
        raise SinewError(f"{deformer.name} has {count} handles, counted from 0 - there is no number {chosen}")
    return chosen


@contextmanager
def object_mode(context: Context, obj: Object) -> Iterator[None]:
    """Edits of objects happen in Object Mode; the user's mode comes back."""
    mode = obj.mode
    if mode != "EDIT":
        yield
        return
    bpy.ops.object.mode_set(mode="OBJECT")
    active = context.view_layer.objects.active
    try:
        yield
    finally:
        context.view_layer.objects.active = active
        bpy.ops.object.mode_set(mode=mode)
