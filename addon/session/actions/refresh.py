# SPDX-License-Identifier: GPL-3.0-or-later
"""After an edit of a mesh or a control, uses painted weights, and notices new or removed points.

Main thread only, as this makes datablocks. It runs when the user pauses, never during an edit.
"""

from contextlib import suppress

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...compat import read_positions, write_positions
from ...core.errors import SinewError
from ...ids import Keys
from ...mesh_io import group_names, keep_lost_groups, keep_shape, read_rest, renumbered, same_topology
from ...properties import SinewDeformer
from ..controls import kinds, placement
from ..datablocks import libraries, refined, rest_frame, vertex_groups
from ..datablocks.owners import owners
from ..datablocks.shapes import capture, shapes
from ..state import sessions
from ..targets import refined_group, targets
from ..targets.kinds import kind_of
from . import bind, fast_subdivision

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


def bind_renders() -> None:
    """Do all deferred edits, and bind renders for the vertices that enter in them. Main thread only."""
    look_at_renders()
    if refresh():
        bpy.context.view_layer.update()


def look_at_renders() -> None:
    """Note the objects whose settings for renders have changed since they were last looked at.

    Blender calls nobody then, as no viewport changes.
    """
    for obj in owners():
        if obj.library is not None:
            continue
        for deformer in obj.sinew.deformers:
            if not _is_compared(deformer):
                continue
            for link in kinds.kind_in_use(deformer).links(deformer):
                if link.by_shape and not libraries.is_lost(link.object):
                    placement.look_at_renders(link.object)
            session, now = sessions.open_session(deformer.uid), capture.render_signature(obj, deformer)
            last, session.render_settings = session.render_settings, now
            if last is None:  # since the file was opened
                changed = deformer.renders_differ or capture.differs_in_renders(obj, deformer)
            else:
                changed = last != now
            if changed:
                sessions.note_count(obj.name)


def _is_compared(deformer: SinewDeformer) -> bool:
    return deformer.is_bound and not deformer.bake.is_baked and not shapes.is_linked(deformer.proxy)


def _is_busy(obj: Object) -> bool:
    rebinding = [deformer for deformer in obj.sinew.deformers if deformer.auto_rebind]
    links = [link for deformer in rebinding for link in kinds.kind_in_use(deformer).links(deformer)]
    edited = (obj, *(link.object for link in links if link.by_shape))
    return any(other.mode in _BUSY_MODES for other in edited)


@sessions.suspended()
def _look_at(edited: list[Object]) -> bool:
    """Compare what enters the deformers of objects now with what entered at bind."""
    compared, changed = [], False
    if edited:
        bpy.context.view_layer.update()  # in a render of another frame, settings that are keyed are behind
    for obj in edited:
        for deformer in obj.sinew.deformers:
            if not _is_compared(deformer):
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
        sessions.open_session(deformer.uid).render_settings = capture.render_signature(obj, deformer)
        if not isinstance(meshes, SinewError):  # without vertices: the evaluation shows the error
            changed |= _take(obj, deformer, meshes)
    for obj in edited:
        modifier = refined_group.of(obj) if targets.is_mesh(obj) else None
        if modifier is None:
            fast_subdivision.end(obj)  # if it was deleted
        else:
            with suppress(SinewError):  # the control mesh is shown
                refined.make(obj, modifier)
            changed = True
    return changed


def _take(obj: Object, deformer: SinewDeformer, meshes: tuple[Mesh, Mesh | None]) -> bool:
    """Use the painted weights of meshes that enter now, or note their topology, if it is another one.

    Vertex groups that were deleted count as they were until the next bind, which leaves them out. Renders
    are bound for the vertices that enter there, whatever enters in the viewport. Returns whether there is
    anything to solve again. The meshes are used up.
    """
    held, held_in_renders = deformer.rest_in("VIEWPORT"), deformer.rest_in("RENDER")
    shown, rendered = meshes
    is_renumbered = not same_topology(held, shown) and _renumber(obj, deformer, shown, rendered)
    if is_renumbered:
        held, held_in_renders = deformer.rest_in("VIEWPORT"), deformer.rest_in("RENDER")
    if not same_topology(held, shown):
        changed = _change_topology(obj, deformer)
        if deformer.topology_changed:
            changed |= _hold_rendered(obj, deformer, shown if rendered is None else rendered)
        _discard(meshes)
        return changed
    was_stale, deformer.topology_changed = deformer.topology_changed, False
    fits = same_topology(held_in_renders, shown if rendered is None else rendered)
    pairs = [(held, shown)]
    if rendered is not None and fits:
        pairs.append((held_in_renders, rendered))
    for old, new in pairs:
        keep_lost_groups(new, old, vertex_groups.groups_in_use(deformer))
    same = [_same_weights(old, new, deformer) for old, new in pairs]
    changed = was_stale or is_renumbered or not fits or not all(same)
    if fits and all(same) and all(group_names(old) == group_names(new) for old, new in pairs):
        _discard(meshes)
    else:
        if rendered is not None and not fits:
            capture.carry_lost_groups(rendered, shown, vertex_groups.groups_in_use(deformer))
            write_positions(rendered, capture.carried(rendered, shown, read_positions(held)))
        for (old, new), is_same in zip(pairs, same, strict=True):
            keep_shape(new, old)
            if is_same:
                new[Keys.REST_TOKEN] = old.get(Keys.REST_TOKEN, "")  # no factor depends on what has changed
        sizes = [len(mesh.vertices) for mesh in meshes if mesh is not None]
        shapes.hold_rest(deformer, meshes)
        shapes.ensure(obj, deformer, *sizes)
    if changed:
        obj.update_tag(refresh={"OBJECT"})
    return changed


def _renumber(obj: Object, deformer: SinewDeformer, shown: Mesh, rendered: Mesh | None) -> bool:
    """Let the rest have its vertices and faces in the order in which they enter; False if they are others.

    The points of the object itself have their order, but modifiers have made theirs anew for turned faces.
    """
    if not targets.is_mesh(obj):
        return False
    wanted = vertex_groups.groups_in_use(deformer)
    mesh = renumbered(deformer.rest_in("VIEWPORT"), shown, obj.data, wanted)
    if mesh is None:
        return False
    for mode in ("VIEWPORT", "RENDER"):
        shapes.show_rest(deformer, mode)
    in_renders = None
    if deformer.renders_differ and rendered is not None:
        in_renders = renumbered(deformer.rest_in("RENDER"), rendered, obj.data, wanted)
    if in_renders is not None:
        deformer.rest_render = shapes.put_mesh(deformer.rest_render, in_renders)
    deformer.rest = shapes.put_mesh(deformer.rest, mesh)
    return True


def _hold_rendered(obj: Object, deformer: SinewDeformer, rendered: Mesh) -> bool:
    """Bind renders anew, while the viewport waits for a Rebind: to other vertices, or to painted weights."""
    held, before = deformer.rest_in("VIEWPORT"), deformer.rest_in("RENDER")
    same_type = held.get(Keys.REST_POINT_TYPE) == rendered.get(Keys.REST_POINT_TYPE)
    if not (same_type and kind_of(obj).RENDERS_MAY_DIFFER):
        return False  # what shows the deformer shows such points only
    mesh: Mesh | None = rendered.copy()
    wanted = vertex_groups.groups_in_use(deformer)
    fitting = next((rest for rest in (before, held) if same_topology(rest, rendered)), None)
    if fitting is None:
        rest_frame.put_back(deformer, mesh)
        capture.carry_lost_groups(mesh, held, wanted)
    else:
        keep_lost_groups(mesh, fitting, wanted)
        keep_shape(mesh, fitting)
        if _same_weights(fitting, mesh, deformer):
            bpy.data.meshes.remove(mesh)
            if fitting == before:
                return False
            mesh = None
    shapes.hold_rendered_rest(deformer, mesh)
    shapes.ensure(obj, deformer, len(held.vertices), len(deformer.rest_in("RENDER").vertices))
    obj.update_tag(refresh={"OBJECT"})
    return True


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


def _change_topology(obj: Object, deformer: SinewDeformer) -> bool:
    """Bind anew, or note that other vertices enter; whether there is anything to solve again."""
    if deformer.auto_rebind:
        with suppress(SinewError):  # the panel says why
            bind.bind(obj, deformer, wait=False)
        return True
    changed = not deformer.topology_changed
    if changed:
        deformer.topology_changed = True
        obj.update_tag(refresh={"OBJECT"})
    return changed
