# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes the order of deformers, with that of their modifiers, and of handles, where it has no effect."""

from bpy.types import Object

from ... import compat
from ...core.errors import SinewError
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks import animation_paths
from ..state import sessions
from ..targets import modified


@sessions.suspended()
def move_deformer(obj: Object, index: int, target: int) -> None:
    """Put a deformer at another place in the list, and Sinew's modifiers into the same order.

    These change places with each other only, so all other modifiers keep their places.
    """
    baked = [deformer.name for deformer in obj.sinew.deformers if deformer.bake.is_baked]
    if baked:
        raise SinewError(f"{baked[0]} is baked, and its cache belongs where it is - Unbake it first")
    count = len(obj.sinew.deformers)
    order = animation_paths.moved(count, index, target)
    wanted = sorted(range(count), key=order.__getitem__)
    _restack(obj, [obj.sinew.deformers[old] for old in wanted])
    obj.sinew.deformers.move(index, target)
    animation_paths.deformers_reordered(obj, order)
    obj.sinew.active_deformer = order.get(obj.sinew.active_deformer, target)
    kinds.keep_evaluated(obj)
    obj.update_tag()


def _restack(obj: Object, deformers: list[SinewDeformer]) -> None:
    """Put the modifiers of ``deformers`` into this order, in the places that they have together."""
    names = [
        modifier.name for modifier in (modified.shown_by(obj, deformer) for deformer in deformers) if modifier
    ]
    before = [modifier.name for modifier in obj.modifiers]
    after = list(before)
    places = sorted(before.index(name) for name in names)
    for place, name in zip(places, names, strict=True):
        after[place] = name
    if _arrange(obj, after):
        return
    _arrange(obj, before)
    raise SinewError("Blender does not let these modifiers change places - one between them must stay first")


def _arrange(obj: Object, names: list[str]) -> bool:
    """Put the stack into this order, from the top down; returns whether Blender allowed it."""
    for place, name in enumerate(names):
        if not compat.move_modifier(obj, name, place):
            return False
    return [modifier.name for modifier in obj.modifiers] == names


@sessions.suspended()
def move_handle(obj: Object, deformer: SinewDeformer, index: int, target: int) -> None:
    """Put a handle at another place in the list."""
    order = animation_paths.moved(len(deformer.handles), index, target)
    deformer.handles.move(index, target)
    animation_paths.rows_reordered(obj, deformer, "handles", order)
    deformer.active_handle = order.get(deformer.active_handle, target)
    kinds.keep_evaluated(obj)
    obj.update_tag()
