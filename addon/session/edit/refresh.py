# SPDX-License-Identifier: GPL-3.0-or-later
"""After an edit of a mesh or a control, uses painted weights, and notices new or removed points.

Main thread only, as this makes datablocks. It runs when the user pauses, never during an edit.
"""

from contextlib import suppress

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...core.errors import SinewError
from ...ids import Keys
from ...mesh_io import group_names, keep_lost_groups, keep_shape, read_rest, same_topology
from ...properties import SinewDeformer
from ..blocks import capture, shapes, vertex_groups
from ..control import kinds
from ..memory import sessions
from . import bind

_BUSY_MODES = ("EDIT", "SCULPT", "SCULPT_CURVES")  # meshes in these modes are looked at afterwards


def refresh() -> bool:
    """Look at the meshes that were edited; returns whether one of them must be solved again."""
    edited, waiting = [], []
    for name in sessions.take_edited():
        obj = bpy.data.objects.get(name)
        if obj is None or obj.library is not None:
            continue
        if _is_busy(obj):
            waiting.append(name)
        else:
            edited.append(obj)
    changed = _look_at(edited)
    sessions.take_edited()  # Blender takes the above for edits, of every object that shares the mesh
    for name in waiting:
        sessions.note_edit(name)
    return changed


def _is_busy(obj: Object) -> bool:
    rebinding = [deformer for deformer in obj.sinew.deformers if deformer.auto_rebind]
    links = [link for deformer in rebinding for link in kinds.kind_in_use(deformer).links(deformer)]
    edited = (obj, *(link.object for link in links if link.by_shape))
    return any(other.mode in _BUSY_MODES for other in edited)


@sessions.suspended()
def _look_at(edited: list[Object]) -> bool:
    """Compare what enters the deformers of objects now with what entered at bind."""
    compared, changed = [], False
    for obj in edited:
        for deformer in obj.sinew.deformers:
            if not deformer.is_bound or deformer.bake.is_baked or shapes.is_linked(deformer.proxy):
                continue
            kind = kinds.kind_in_use(deformer)
            depsgraph = bpy.context.evaluated_depsgraph_get()
            if deformer.auto_rebind and kind.is_stale(deformer, depsgraph):
                with suppress(SinewError):  # the panel says why
                    bind.bind(obj, deformer, wait=False, renew=True)
                changed = True
            else:
                vertex_groups.follow_renamed_groups(obj, deformer)
                compared.append((obj, deformer))
    for (obj, deformer), meshes in zip(compared, capture.all_rest_meshes(compared), strict=True):
        if not isinstance(meshes, SinewError):  # without vertices: the evaluation shows the error
            changed |= _take(obj, deformer, meshes)
    return changed


def _take(obj: Object, deformer: SinewDeformer, meshes: tuple[Mesh, Mesh | None]) -> bool:
    """Use the painted weights of meshes that enter now, or note their topology, if it is another one.

    Vertex groups that were deleted count as they were until the next bind, which leaves them out. Returns
    whether there is anything to solve again. The meshes are used up.
    """
    held = (deformer.rest_in("VIEWPORT"), deformer.rest_in("RENDER") if deformer.renders_differ else None)
    if not same_topology(held[0], meshes[0]):
        _discard(meshes)
        _change_topology(obj, deformer)
        return True
    fits = _fits(held[1], meshes[1])
    pairs = [(old, new) for old, new in zip(held, meshes if fits else meshes[:1]) if old is not None]
    for old, new in pairs:
        keep_lost_groups(new, old, vertex_groups.groups_in_use(deformer))
    same = fits and all(_same_weights(old, new, deformer) for old, new in pairs)
    is_known = all(group_names(old) == group_names(new) for old, new in pairs)
    changed = not same or deformer.topology_changed
    if not changed and is_known:
        _discard(meshes)
        return False
    for old, new in pairs:
        keep_shape(new, old)
        if same:
            new[Keys.REST_TOKEN] = old.get(Keys.REST_TOKEN, "")  # no factor depends on what has changed
    sizes = [len(mesh.vertices) for mesh in meshes if mesh is not None]
    shapes.hold_rest(deformer, meshes)
    shapes.ensure(obj, deformer, *sizes)
    deformer.topology_changed = False
    if changed:
        obj.update_tag(refresh={"OBJECT"})
    return changed


def _fits(old: Mesh | None, new: Mesh | None) -> bool:
    """Whether the rest mesh for renders still has the same vertices, or there still is none."""
    if old is None or new is None:
        return old is new
    return same_topology(old, new)


def _same_weights(old: Mesh, new: Mesh, deformer: SinewDeformer) -> bool:
    before, after = read_rest(old), read_rest(new)
    vertex_groups.read_weights(before, old, deformer)
    vertex_groups.read_weights(after, new, deformer)
    return all(
        old.keys() == new.keys() and all(np.array_equal(old[name], new[name], equal_nan=True) for name in old)
        for old, new in ((before.weights, after.weights), (before.uv_maps, after.uv_maps))
    )


def _discard(meshes: tuple[Mesh | None, ...]) -> None:
    for mesh in meshes:
        if mesh is not None:
            bpy.data.meshes.remove(mesh)


def _change_topology(obj: Object, deformer: SinewDeformer) -> None:
    if deformer.auto_rebind:
        with suppress(SinewError):  # the panel says why
            bind.bind(obj, deformer, wait=False)
    elif not deformer.topology_changed:
        deformer.topology_changed = True
        obj.update_tag(refresh={"OBJECT"})
