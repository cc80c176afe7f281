# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds and removes deformers. Main thread only."""

import bpy
from bpy.types import Object

from ...core import status
from ...core.errors import SinewError
from ...core.methods import BY_ID, Control
from ...core.status import Level, Status
from ...preferences import preferences
from ...properties import SinewDeformer
from ..blocks import animation_paths, keeper, shapes, targets
from ..blocks.owners import forget_owners
from ..control import kinds
from ..live import binding
from ..memory import sessions
from . import cages
from .handles import empties
from .handles.handles import _release_group
from .names import unique_name


@sessions.suspended()
def add_deformer(obj: Object, method: str, name: str = "") -> SinewDeformer:
    """A new deformer at the end of the stack; it shows the rest shape until it has a handle."""
    if method not in BY_ID:
        raise SinewError(f"There is no method '{method}' - choose one of: {', '.join(BY_ID)}")
    targets.require_method(obj, BY_ID[method])
    deformer = obj.sinew.deformers.add()
    deformer.complete()
    deformer.uid = shapes.new_key()
    row = BY_ID[method]  # the coordinates of a cage are tried one after the other, so they are not its name
    label = Control.CAGE.value if row.control is Control.CAGE else row.label
    deformer.name = name or unique_name(
        label, [other.name for other in obj.sinew.deformers if other.uid != deformer.uid]
    )
    deformer.method = method
    deformer.auto_rebind = preferences(bpy.context).auto_rebind
    obj.sinew.active_deformer = len(obj.sinew.deformers) - 1
    shapes.ensure(obj, deformer, max(targets.vertex_count(obj), 0))
    forget_owners()
    status.put(deformer.uid, Status(Level.INFO, kinds.kind_in_use(deformer).MISSING))
    return deformer


@sessions.suspended()
def remove_deformer(obj: Object, index: int) -> None:
    """Take a deformer off, with the controls made for it. Vertex groups that the user made stay."""
    deformer = obj.sinew.deformers[index]
    for handle in deformer.handles:
        empties.release(handle)
        _release_group(obj, deformer, handle)
    cages.release_cage(deformer)
    forget_deformer(obj, index)


def forget_deformer(obj: Object, index: int) -> None:
    """Take a deformer off, and leave its controls and its cage."""
    deformer = obj.sinew.deformers[index]
    binding.abandon(deformer.uid)
    sessions.drop(deformer.uid)
    shapes.remove(obj, deformer)
    order = animation_paths.removed(len(obj.sinew.deformers), index)
    obj.sinew.deformers.remove(index)
    animation_paths.deformers_reordered(obj, order)
    obj.sinew.active_deformer = max(0, min(obj.sinew.active_deformer, len(obj.sinew.deformers) - 1))
    keeper.keep_evaluated(obj)
    forget_owners()
