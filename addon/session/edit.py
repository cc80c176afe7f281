# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators and scripts call: deformers and handles, bind and unbind. Main thread only."""

from collections.abc import Iterable

import bmesh
import bpy
import numpy as np
from bpy.types import Mesh, Object

from ..backend import Progress
from ..core import status
from ..core.errors import ConstraintError, SinewError
from ..core.geometry import frames
from ..core.methods import BY_ID, Control
from ..core.status import Level, Status
from ..mesh_io import RestShape, group_names, group_weights, read_rest
from ..preferences import preferences
from ..properties import SinewDeformer, SinewHandle
from . import binding, cages, capture, census, controls, curves, kinds, poses, regions, rig, state, steering


@state.suspended()
def add_deformer(obj: Object, method: str, name: str = "") -> SinewDeformer:
    """A new deformer at the end of the stack; it shows the rest shape until it has a handle."""
    if method not in BY_ID:
        raise SinewError(f"There is no method '{method}' - choose one of: {', '.join(BY_ID)}")
    kinds.require_method(obj, BY_ID[method])
    deformer = obj.sinew.deformers.add()
    deformer.complete()
    deformer.uid = rig.new_key()
    row = BY_ID[method]  # the coordinates of a cage are tried one after the other, so they are not its name
    label = Control.CAGE.value if row.control is Control.CAGE else row.label
    deformer.name = name or _unique(
        label, [other.name for other in obj.sinew.deformers if other.uid != deformer.uid]
    )
    deformer.method = method
    deformer.auto_rebind = preferences(bpy.context).auto_rebind
    obj.sinew.active_deformer = len(obj.sinew.deformers) - 1
    rig.ensure(obj, deformer, max(kinds.vertex_count(obj), 0))
    census.forget_owners()
    status.put(deformer.uid, Status(Level.INFO, steering.of(deformer).MISSING))
    return deformer


def _unique(name: str, taken: list[str]) -> str:
    if name not in taken:
        return name
    return next(f"{name}.{number:03}" for number in range(1, 1000) if f"{name}.{number:03}" not in taken)


@state.suspended()
def remove_deformer(obj: Object, index: int) -> None:
    """Take a deformer off, with the controls made for it. Vertex groups that the user made stay."""
    deformer = obj.sinew.deformers[index]
    for handle in deformer.handles:
        controls.release(handle)
        _release_group(obj, deformer, handle)
    cages.release_cage(deformer)
    forget(obj, index)


def forget(obj: Object, index: int) -> None:
    """Take a deformer off, and leave its controls and its cage."""
    deformer = obj.sinew.deformers[index]
    binding.abandon(deformer.uid)
    state.drop(deformer.uid)
    rig.remove(obj, deformer)
    order = curves.removed(len(obj.sinew.deformers), index)
    obj.sinew.deformers.remove(index)
    curves.deformers_reordered(obj, order)
    obj.sinew.active_deformer = max(0, min(obj.sinew.active_deformer, len(obj.sinew.deformers) - 1))
    rig.keep_evaluated(obj)
    census.forget_owners()


def group_from_selection(obj: Object, name: str) -> str:
    """A new vertex group of the vertices selected in Edit Mode."""
    edit = bmesh.from_edit_mesh(obj.data)
    if not any(vertex.select for vertex in edit.verts):
        raise ConstraintError("Nothing is selected - select the vertices of the region first")
    group = obj.vertex_groups.new(name=name)
    layer = edit.verts.layers.deform.verify()
    for vertex in edit.verts:
        if vertex.select:
            vertex[layer][group.index] = 1.0
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    return group.name


def select_group(obj: Object, vertex_group: str) -> None:
    """Select the vertices of a group, in Edit Mode."""
    group = obj.vertex_groups.get(vertex_group)
    if group is None:
        raise SinewError(f"{obj.name} has no vertex group '{vertex_group}'")
    edit = bmesh.from_edit_mesh(obj.data)
    layer = edit.verts.layers.deform.active
    members = [] if layer is None else [v.index for v in edit.verts if v[layer].get(group.index, 0.0) > 0.0]
    select_elements(obj, members, "vertex")


def select_elements(obj: Object, elements: Iterable[int], kind: str) -> int:
    """Select vertices or faces by index, in Edit Mode; how many there were."""
    edit = bmesh.from_edit_mesh(obj.data)
    for vertex in edit.verts:
        vertex.select = False
    edit.select_flush(False)
    sequence = edit.faces if kind == "face" else edit.verts
    sequence.ensure_lookup_table()
    wanted = [index for index in elements if index < len(sequence)]
    for index in wanted:
        sequence[index].select = True
    edit.select_flush(True)
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    return len(wanted)


@state.suspended()
def add_handle(
    obj: Object,
    deformer: SinewDeformer,
    kind: str,
    vertex_group: str,
    control: Object | None = None,
    bone: str = "",
    owns_group: bool = False,
) -> SinewHandle:
    """A region of the named vertex group; a handle gets ``control`` (and ``bone``), or an empty of its own.

    The region is not bound yet: see ``bind``. Where the deformer is posed already, the control stands at
    the posed region and nothing jumps.
    """
    if vertex_group not in obj.vertex_groups:
        raise ConstraintError(f"{obj.name} has no vertex group '{vertex_group}' - choose one of its groups")
    handle = deformer.handles.add()
    handle.uid = rig.new_key()
    handle.kind = kind
    handle.vertex_group = vertex_group
    handle.owns_group = owns_group
    handle.name = _unique(vertex_group, [other.name for other in deformer.handles if other.uid != handle.uid])
    handle.colour = controls.colour(len(deformer.handles) - 1)
    deformer.active_handle = len(deformer.handles) - 1
    if kind != "HANDLE":
        return handle
    try:
        _give_control(obj, deformer, handle, control, bone)
    except SinewError:
        deformer.handles.remove(len(deformer.handles) - 1)
        obj.update_tag()  # the evaluated copy still has it
        raise
    return handle


def _give_control(
    obj: Object, deformer: SinewDeformer, handle: SinewHandle, control: Object | None, bone: str
) -> None:
    mesh = capture.rest_mesh(obj, deformer)
    try:
        rest = read_rest(mesh)
        members = _members(mesh, handle)
    finally:
        bpy.data.meshes.remove(mesh)
    pose = _current_pose(deformer, rest, members)
    if control is not None:
        controls.assign(obj, handle, control, bone, pose)
        return
    handle.control, frame = controls.make_empty(obj, rest, members, f"{obj.name} {handle.name}", pose)
    handle.owns_control = True
    poses.set_rest(handle, frame)


def _members(mesh: Mesh, handle: SinewHandle) -> np.ndarray:
    groups = group_weights(mesh, group_names(mesh), {handle.vertex_group})
    members = np.flatnonzero(groups[handle.vertex_group] > 0.0)
    if len(members) == 0:
        raise ConstraintError(f"Vertex group '{handle.vertex_group}' has no vertices - assign some first")
    return members


def _current_pose(deformer: SinewDeformer, rest: RestShape, members: np.ndarray) -> np.ndarray:
    """How the region is moved at present, as a rigid pose."""
    session = state.find(deformer.uid)
    shown = session.view("VIEWPORT") if session else None
    if shown is None or shown.positions is None or len(shown.positions) != len(rest.points):
        return poses.IDENTITY
    before = session.bound.rest.points if shown.incoming is None else shown.incoming.astype(np.float64)
    after = shown.positions + (before if shown.displacement else 0.0)
    return frames.fit(before[members], after[members], rigid=True)


@state.suspended()
def remove_handle(obj: Object, deformer: SinewDeformer, index: int) -> None:
    """Let a region go, with the control and the group made for it."""
    handle = deformer.handles[index]
    controls.release(handle)
    _release_group(obj, deformer, handle)
    order = curves.removed(len(deformer.handles), index)
    deformer.handles.remove(index)
    curves.handles_reordered(obj, deformer, order)
    deformer.active_handle = max(0, min(deformer.active_handle, len(deformer.handles) - 1))
    rig.keep_evaluated(obj)
    obj.update_tag()
    kind = steering.of(deformer)
    if not kind.is_set(deformer):
        unbind(obj, deformer)
        status.put(deformer.uid, Status(Level.INFO, kind.MISSING))


def _release_group(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> None:
    if not handle.owns_group:
        return
    shared = any(
        other.vertex_group == handle.vertex_group and other.uid != handle.uid
        for any_deformer in obj.sinew.deformers
        for other in any_deformer.handles
    )
    group = obj.vertex_groups.get(handle.vertex_group)
    if group is not None and not shared:
        obj.vertex_groups.remove(group)


@state.suspended()
def bind(obj: Object, deformer: SinewDeformer, wait: bool = True, progress: Progress | None = None) -> None:
    """Take what enters the modifier now as the rest shape and factorise.

    Without ``wait`` a heavy mesh is bound by a thread (``session.job``). On a refusal the deformer is
    unbound, shows the rest shape and keeps every setting.
    """
    try:
        binding.require_backend()
    except SinewError as error:
        status.fail(deformer.uid, error)
        raise
    if deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is baked - Unbake it first")
    try:
        kinds.require_method(obj, deformer.definition)
        kind = steering.of(deformer)
        if not kind.is_set(deformer):
            raise ConstraintError(kind.MISSING)
        regions.follow_renamed_groups(obj, deformer)
        meshes = capture.rest_meshes(obj, deformer)
        sizes = [len(mesh.vertices) for mesh in meshes if mesh is not None]
        rig.hold_rest(deformer, meshes)
        deformer.topology_changed = False
        kind.set_rest(obj, deformer)
        rig.ensure(obj, deformer, *sizes)
        rig.keep_evaluated(obj)
        bpy.context.scene.render.use_lock_interface = True  # renders write shapes while the window draws
        census.forget_owners()
        session = state.of(deformer.uid)
        session.failed = None
        with session.lock:  # a render may be solving
            binding.ensure(session, deformer, deformer, wait, progress)
    except SinewError as error:
        _let_go(deformer)
        status.fail(deformer.uid, error)
        raise
    finally:
        obj.update_tag()
        bpy.context.view_layer.update()  # new shapes enter
        state.forget_edit(obj.name)  # which was no edit of the user's


def _let_go(deformer: SinewDeformer) -> None:
    binding.abandon(deformer.uid)
    rig.show_rest(deformer, "VIEWPORT")
    rig.show_rest(deformer, "RENDER")
    rig.release_rest(deformer)
    status.put_notes(deformer.uid, ())


@state.suspended()
def unbind(obj: Object, deformer: SinewDeformer) -> None:
    """Show the rest shape and forget where the controls rested: the next bind starts where they are."""
    _let_go(deformer)
    state.drop(deformer.uid)
    for handle in deformer.handles:
        handle.has_rest = handle.has_last_pose = False
    rig.release_cage(deformer)
    status.put(deformer.uid, Status(Level.INFO, "Not bound - press Bind"))
    obj.update_tag()
