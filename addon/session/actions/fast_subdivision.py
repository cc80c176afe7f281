# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets Sinew refine a mesh in viewports in place of its Subdivision modifier. Main thread only."""

import bpy
from bpy.types import Modifier, Object

from ... import compat
from ...core import status
from ...core.errors import MeshError, SinewError
from ...ids import Keys
from ..datablocks import refined
from ..state import sessions
from ..targets import modified, refined_group


@sessions.suspended()
def begin(obj: Object) -> Modifier:
    """Refine the mesh as the Subdivision modifier behind its deformers says, a new one if there is none.

    That modifier is switched off in viewports, and still refines in renders. Returns it.
    """
    modifier = refined_group.of(obj)
    if modifier is not None:
        refined.make(obj, modifier)
        by = refined_group.subdivision_of(obj, modifier)
        _switch_off(obj, by)
        _evaluate(obj)
        return by
    by, is_new = _subdivision(obj)
    modifier = refined_group.new(obj)
    compat.move_modifier(obj, modifier.name, obj.modifiers.find(by.name) + 1)
    _switch_off(obj, by)
    try:
        refined.make(obj, modifier)
    except SinewError:
        end(obj)
        if is_new:
            obj.modifiers.remove(by)
        raise
    _evaluate(obj)
    return by


@sessions.suspended()
def end(obj: Object) -> bool:
    """Let the Subdivision modifier that Sinew has switched off refine in viewports again, wherever it stands
    now, and also if the modifier of Sinew was deleted; whether there was anything to end.
    """
    modifier, name = refined_group.of(obj), obj.pop(Keys.REFINED_BY, "")
    if modifier is None and not name:
        return False
    by = obj.modifiers.get(name)
    if modifier is not None:
        if name and by is None:  # it has another name
            by = refined_group.subdivision_of(obj, modifier)
        refined.remove_mesh(modifier)
        obj.modifiers.remove(modifier)
    if by is not None:
        by.show_viewport = True
    for deformer in obj.sinew.deformers:
        status.put_refined(deformer.uid, "")
    return True


def _switch_off(obj: Object, by: Modifier) -> None:
    """Switch a modifier off in viewports, and remember it if it was on."""
    if by.show_viewport:
        obj[Keys.REFINED_BY] = by.name
        by.show_viewport = False


def _evaluate(obj: Object) -> None:
    """Let Blender evaluate what has changed, which is no edit by the user."""
    obj.update_tag()
    bpy.context.view_layer.update()
    sessions.forget_edit(obj.name)


def _subdivision(obj: Object) -> tuple[Modifier, bool]:
    """The Subdivision modifier behind the deformers, and whether it is new."""
    own = [modified.shown_by(obj, deformer) for deformer in obj.sinew.deformers]
    if not any(own):
        raise MeshError("The mesh has no modifier of Sinew - Rebind, which makes one")
    last = max(obj.modifiers.find(modifier.name) for modifier in own if modifier is not None)
    for modifier in obj.modifiers[last + 1 :]:
        if modifier.type == "SUBSURF":
            return modifier, False
        if modifier.show_viewport:
            raise MeshError(
                f"{modifier.name} stands between Sinew and the Subdivision - move it, or switch it off"
            )
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 2, 3
    return modifier, True
