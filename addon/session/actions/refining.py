# SPDX-License-Identifier: GPL-3.0-or-later
"""Remedies for how controls move an object: finer cells, an armature that counts once. Main thread only."""

from bpy.types import Object

from ...core.methods import Int
from ...core.status import Remedy
from ...properties import SinewDeformer
from ..controls.twice import moved_twice
from .companions import sharing_handles
from .rigging import try_bind


def refine(deformer: SinewDeformer) -> tuple[str, int]:
    """Double the parameter that ``Method.finer`` names until the bind is accepted, also that of objects that
    share handles; its label and value then. Raises what still refuses a bind.
    """
    method = deformer.definition
    finer = next(row for row in method.parameters if isinstance(row, Int) and row.id == method.finer)
    value = getattr(deformer.parameters, finer.id)
    while True:
        value = min(2 * value, finer.span.maximum)
        group = list(sharing_handles(deformer))
        for other in group:
            setattr(other.parameters, finer.id, value)
        for other in group:  # each is built around those that are bound
            try_bind(other.id_data, other)
        refusals = [refusal for other in group if (refusal := try_bind(other.id_data, other)) is not None]
        if not refusals:
            return finer.label, value
        if value == finer.span.maximum or any(refusal.remedy is not Remedy.REFINE for refusal in refusals):
            raise refusals[0]


def turn_off_armatures(obj: Object, deformer: SinewDeformer) -> list[str]:
    """Turn off the modifiers whose armature also moves a control; their names."""
    modifiers = list(dict.fromkeys(modifier for _control, modifier in moved_twice(obj, deformer)))
    for modifier in modifiers:
        modifier.show_viewport = modifier.show_render = False
    return [modifier.name for modifier in modifiers]
