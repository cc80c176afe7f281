# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts all controls of a deformer back to rest, and keys them. Main thread only."""

from collections.abc import Callable

import bpy
from bpy.types import Object

from ... import compat
from ...core.errors import ConstraintError
from ...properties import SinewDeformer
from ..controls import kinds, movers
from ..datablocks import own_shape
from ..datablocks.evaluation_driver import Link
from ..state import sessions

_NONE_AT_REST = "There is no control that has a rest - make one, or press Rebind"


def reset(obj: Object, deformer: SinewDeformer, selected: bool, key: bool) -> tuple[int, list[str]]:
    """Put the controls back to rest, all or the ``selected`` ones, and ``key`` them there.

    Returns how many these are, and the names of those that something else keeps posed. Stops on the paths of
    tools go.
    """
    wanted: Callable[[Link], bool] = is_selected if selected else lambda _link: True
    bpy.context.view_layer.update()
    with sessions.suspended():
        found = kinds.kind_in_use(deformer).reset(obj, deformer, wanted)
        for link in found if key else ():
            movers.insert_keyframes(link.object, link.bone)
        obj.update_tag()
    if not found:
        raise ConstraintError("No control is selected" if selected else _NONE_AT_REST)
    bpy.context.view_layer.update()
    posed = kinds.kind_in_use(deformer).not_at_rest(obj, deformer, bpy.context.evaluated_depsgraph_get())
    return len(found), [name_of(link) for link in posed if link in found]


def key_all(obj: Object, deformer: SinewDeformer) -> tuple[int, list[str]]:
    """Key the controls where they are in this frame.

    Returns how many these are, and the names of those whose points are moved, which only shape keys can key.
    """
    kind = kinds.kind_in_use(deformer)
    found = [link for link in dict.fromkeys(kind.links(deformer)) if link.object.library is None]
    if not found:
        raise ConstraintError("There is no control to key")
    for link in found:
        movers.insert_keyframes(link.object, link.bone)
    objects = {link.object for link in found if link.by_shape}
    rows = [(row.object, row.rest) for row in deformer.all_controls]
    rows += [(handle.control, handle.rest) for handle in deformer.handles]
    edited = [control for control, rest in rows if control in objects and own_shape.is_edited(control, rest)]
    return len(found), [control.name for control in edited]


def is_selected(link: Link) -> bool:
    """Whether the object, or the bone, is selected."""
    if link.bone:
        return compat.is_bone_selected(link.object, link.bone)
    return link.object.select_get()


def name_of(link: Link) -> str:
    """The bone, or else the object."""
    return link.bone or link.object.name
