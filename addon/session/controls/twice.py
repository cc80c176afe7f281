# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds what moves a mesh twice: its own Armature modifier, and a control whose shape that armature moves."""

from bpy.types import ArmatureModifier, HookModifier, Object

from ...properties import SinewDeformer
from ..targets import targets
from ..targets.kinds import kind_of
from . import kinds


def moved_twice(obj: Object, deformer: SinewDeformer) -> list[tuple[Object, ArmatureModifier]]:
    """Controls whose shape an armature moves, each with the modifier before the deformer by which the same
    armature moves the target.

    Such a control carries the target along with the skin that it has been given already.
    """
    if not targets.is_mesh(obj):
        return []
    before = kind_of(obj).modifiers_before(obj, deformer)
    own = [row for row in before if isinstance(row, ArmatureModifier) and _moves(row)]
    controls = [control for control in _shapes(deformer) if control != obj] if own else []
    return [(control, row) for control in controls for row in own if row.object in _movers(control, {obj})]


def _moves(modifier: ArmatureModifier | HookModifier) -> bool:
    return modifier.object is not None and (modifier.show_viewport or modifier.show_render)


def _shapes(deformer: SinewDeformer) -> list[Object]:
    """The objects whose points count for a deformer."""
    links = kinds.kind_in_use(deformer).links(deformer)
    return list(dict.fromkeys(link.object for link in links if link.by_shape))


def _movers(obj: Object, seen: set[Object]) -> set[Object]:
    """The objects that move the points of an object: by modifiers, as a parent, by Sinew, or by another
    object that it follows. ``seen``: those that were asked already.
    """
    found = {
        row.object
        for row in obj.modifiers
        if isinstance(row, (ArmatureModifier, HookModifier)) and _moves(row)
    }
    if obj.parent is not None and obj.parent_type == "ARMATURE":
        found.add(obj.parent)
    for deformer in obj.sinew.deformers:
        found |= {link.object for link in kinds.kind_in_use(deformer).links(deformer)}
        for other in _shapes(deformer):
            if other not in seen:
                found |= _movers(other, {*seen, obj})
    return found


def explain(obj: Object, deformer: SinewDeformer) -> tuple[str, ...]:
    """A line per control and modifier."""
    return tuple(
        f"{control.name} and the modifier {modifier.name} both follow {modifier.object.name}: "
        "this mesh moves twice as far - Turn Off Armature"
        for control, modifier in moved_twice(obj, deformer)
    )
