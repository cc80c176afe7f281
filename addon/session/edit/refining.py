# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes what moves an object finer, until each handle has a place of its own in it. Main thread only."""

from bpy.types import Object

from ...core.status import Remedy
from ...properties import SinewDeformer
from .companions import sharing_handles
from .rigging import try_bind


def refine(obj: Object, deformer: SinewDeformer) -> tuple[str, int]:
    """Double the parameter that ``Method.finer`` names until the bind is accepted; its label and value then.

    Raises what still refuses the bind.
    """
    finer = next(p for p in deformer.definition.parameters if p.id == deformer.definition.finer)
    value = getattr(deformer.parameters, finer.id)
    while True:
        value = min(2 * value, finer.maximum)
        others = [other for other in sharing_handles(deformer) if other.uid != deformer.uid]
        for other in (deformer, *others):
            setattr(other.parameters, finer.id, value)
        refusal = try_bind(obj, deformer)
        if refusal is None:
            break
        if refusal.remedy is not Remedy.REFINE or value == finer.maximum:
            raise refusal
    for other in others:
        if not other.is_bound:
            try_bind(other.id_data, other)
    return finer.label, value
