# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds what moves a mesh twice: its own Armature modifier, and a control whose shape that armature moves."""

from bpy.types import ArmatureModifier, Object

from ...properties import SinewDeformer
from ..blocks import capture, targets
from . import kinds


def moved_twice(obj: Object, deformer: SinewDeformer) -> list[tuple[Object, ArmatureModifier]]:
    """Controls whose shape an armature moves, each with the modifier before the deformer by which the same
    armature moves the target.

    Such a control carries the target along with the skin that it has been given already.
    """
    if not targets.is_mesh(obj):
        return []
    own = [row for row in list(obj.modifiers)[: capture.position(obj, deformer)] if _moves(row)]
    links = kinds.kind_in_use(deformer).links(deformer)
    controls = dict.fromkeys(link.object for link in links if link.by_shape and link.object != obj)
    return [(control, row) for control in controls for row in own if row.object in _armatures_of(control)]


def _moves(modifier: object) -> bool:
    return (
        isinstance(modifier, ArmatureModifier)
        and modifier.object is not None
        and (modifier.show_viewport or modifier.show_render)
    )


def _armatures_of(control: Object) -> set[Object]:
    """The armatures that move the points of an object."""
    found = {modifier.object for modifier in control.modifiers if _moves(modifier)}
    if control.parent is not None and control.parent.type == "ARMATURE" and control.parent_type == "ARMATURE":
        found.add(control.parent)
    return found


def explain(obj: Object, deformer: SinewDeformer) -> tuple[str, ...]:
    """A line per control and modifier."""
    return tuple(
        f"{control.name} and the modifier {modifier.name} both follow {modifier.object.name}: "
        "this mesh moves twice as far - Turn Off Armature"
        for control, modifier in moved_twice(obj, deformer)
    )
