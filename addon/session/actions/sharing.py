# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects that one control moves: finds them, and gives them the same settings, or another rest.

Main thread only.
"""

from bpy.types import Object

from ...core.errors import CageError
from ...core.methods import Choice
from ...core.status import Level
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks import rest_frame
from ..datablocks.owners import owners
from ..evaluation import binding
from ..state import sessions

REFUSE = "error"  # the choice of "Outside" that moves nothing outside the cage


def sharing(deformer: SinewDeformer) -> list[tuple[Object, SinewDeformer]]:
    """The other deformers that the same cage, lattice, wires or tools move, with their objects."""
    controls = _controls(deformer)
    if not controls:
        return []
    return [
        (obj, other)
        for obj in owners()
        for other in obj.sinew.deformers
        if obj.library is None and other.uid != deformer.uid and _controls(other) == controls
    ]


def _controls(deformer: SinewDeformer) -> set[tuple[str, Object]]:
    """The whole objects that control the deformer, each with its kind."""
    if kinds.marks_regions(deformer.definition):
        return set()
    control = deformer.definition.control.name
    return {(control, link.object) for link in kinds.kind_in_use(deformer).links(deformer)}


@sessions.suspended()
def set_rest(obj: Object, deformer: SinewDeformer) -> list[tuple[Object, SinewDeformer]]:
    """Let the controls of a deformer rest as they are now. So all that they move is at rest, too.

    ``bind`` must follow, also for the others, which are returned with their objects. A baked one stays as it
    is, and so does one that was never bound.
    """
    others = [
        (other, row)
        for other, row in sharing(deformer)
        if not row.bake.is_baked and (row.is_bound or row.status_level == Level.ERROR.value)
    ]
    for target, row in ((obj, deformer), *others):
        rest_frame.absorb(row)
        kinds.kind_in_use(row).take_rest(target, row)
        binding.abandon(row.uid)
    return others


def share_settings(deformer: SinewDeformer) -> list[tuple[Object, SinewDeformer]]:
    """Give the others that its controls move the same settings; these others, with their objects."""
    others = sharing(deformer)
    for _obj, other in others:
        copy_settings(deformer, other)
    return others


def copy_settings(deformer: SinewDeformer, other: SinewDeformer) -> None:
    """Give another deformer the same method, parameters and Factor, and those of each control they share.

    Masks, painted groups, curves and objects of parameters stay: they belong to one target.
    """
    other.method, other.factor, other.sizes = deformer.method, deformer.factor, deformer.sizes
    other.defaults = deformer.defaults
    for method, name in deformer.plain_parameters:
        setattr(getattr(other, method), name, getattr(getattr(deformer, method), name))
    for row in deformer.controls:
        for twin in other.controls:
            if (twin.kind, twin.object) == (row.kind, row.object):
                for parameter in deformer.definition.control_parameters:
                    setattr(twin, parameter.id, getattr(row, parameter.id))


def refuses_outside(deformer: SinewDeformer) -> bool:
    """Whether its method moves nothing while a point lies outside the cage, by its choice of Outside."""
    return getattr(deformer.parameters, "outside", "") == REFUSE


def let_outside_follow(deformer: SinewDeformer) -> None:
    """Choose what Outside offers for points outside the cage beside refusing them."""
    if not refuses_outside(deformer):
        raise CageError("Points outside the cage follow already")
    for parameter in deformer.definition.parameters:
        if parameter.id == "outside" and isinstance(parameter, Choice):
            deformer.parameters.outside = next(item[0] for item in parameter.items if item[0] != REFUSE)
