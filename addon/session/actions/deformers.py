# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds and removes deformers. Main thread only."""

import bpy
from bpy.types import Object

from ... import compat
from ...core import status
from ...core.errors import SinewError
from ...core.methods import BY_ID, DEFAULTS
from ...core.names import numbered
from ...core.status import Level, Status
from ...core.tasks import task_of
from ...preferences import preferences
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks import animation_paths, movers
from ..datablocks.owners import forget_owners, owners
from ..datablocks.shapes import shapes
from ..evaluation import binding
from ..state import sessions
from ..targets import modified, targets
from . import fast_subdivision
from .controls import grids


@sessions.suspended()
def add_deformer(obj: Object, method: str, name: str = "") -> SinewDeformer:
    """A new deformer at the end of the stack. It shows the rest shape until something moves it."""
    if method not in BY_ID:
        raise SinewError(f"There is no method '{method}' - choose one of: {', '.join(BY_ID)}")
    targets.require_method(obj, BY_ID[method])
    deformer = obj.sinew.deformers.add()
    deformer.complete()
    deformer.uid = shapes.new_key()
    deformer.sizes, deformer.defaults = "SURFACE", DEFAULTS
    taken = [other.name for other in obj.sinew.deformers if other.uid != deformer.uid]
    deformer.method = method
    deformer.name = name or numbered(task_of(BY_ID[method]).deformer, taken)
    deformer.auto_rebind = preferences(bpy.context).auto_rebind
    obj.sinew.active_deformer = len(obj.sinew.deformers) - 1
    shapes.ensure(obj, deformer, max(targets.vertex_count(obj), 0))
    forget_owners()
    status.put(deformer.uid, Status(Level.INFO, kinds.kind_in_use(deformer).MISSING))
    return deformer


def put_before_subdivision(obj: Object, deformer: SinewDeformer) -> SinewDeformer:
    """A new deformer of a surface behind all that moves the mesh, and before what only divides its faces.

    There it has few vertices to bind, as many in renders as in viewports, and what it does becomes smooth.
    Methods that need more than a surface, such as levels of subdivision, take the mesh as it is shown.
    """
    if not deformer.definition.is_space and not deformer.definition.also_needs:
        own = modified.shown_by(obj, deformer)
        place = movers.place_behind(other for other in obj.modifiers if other != own)
        compat.move_modifier(obj, own.name, place)
    return deformer


def keep_earlier_defaults() -> None:
    """Write out the parameters that an earlier build left at a default which has changed since.

    For a file that was just opened.
    """
    changed = [
        (method.id, parameter.id, *parameter.earlier)
        for method in BY_ID.values()
        for parameter in method.parameters
        if parameter.earlier is not None
    ]
    for obj in owners():
        for deformer in obj.sinew.deformers:
            known = max(deformer.defaults, int(deformer.sizes == "SURFACE"))
            for method, name, former, since in changed:
                values = getattr(deformer, method)
                if known < since and not values.is_property_set(name):
                    setattr(values, name, former)


@sessions.suspended()
def remove_deformer(obj: Object, index: int) -> None:
    """Remove a deformer, with the controls and vertex groups that were made for it."""
    deformer = obj.sinew.deformers[index]
    for kind in kinds.every_kind():
        kind.release(obj, deformer)
    grids.release_grids(obj, deformer)
    forget_deformer(obj, index)


def forget_deformer(obj: Object, index: int) -> None:
    """Remove a deformer, but leave its controls and vertex groups."""
    deformer = obj.sinew.deformers[index]
    binding.abandon(deformer.uid)
    sessions.drop(deformer.uid)
    for kind in kinds.every_kind():
        kind.forget_rest(deformer)
    shapes.remove(obj, deformer)
    order = animation_paths.removed(len(obj.sinew.deformers), index)
    obj.sinew.deformers.remove(index)
    animation_paths.deformers_reordered(obj, order)
    obj.sinew.active_deformer = max(0, min(obj.sinew.active_deformer, len(obj.sinew.deformers) - 1))
    if not obj.sinew.deformers:
        fast_subdivision.end(obj)
    kinds.keep_evaluated(obj)
    forget_owners()
