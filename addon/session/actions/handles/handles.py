# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds and removes handles. Main thread only."""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ....core import status
from ....core.errors import ConstraintError, SinewError
from ....core.geometry import frames
from ....core.names import unique_name
from ....core.status import Level, Status
from ....mesh_io import RestShape, group_names, group_weights, read_rest
from ....properties import SinewDeformer, SinewHandle
from ...controls import kinds
from ...controls.handles import poses, riding
from ...controls.handles.release import release_control, release_group
from ...controls.objects import forget_row_rest
from ...datablocks import animation_paths
from ...datablocks.shapes import capture, shapes
from ...state import sessions
from ..bind import unbind
from . import empties


@dataclass(frozen=True)
class NewRegion:
    """A region to be added: the vertices of a vertex group.

    A handle follows ``control``, or its ``bone``, or else gets an empty of its own. If the deformer is posed
    already, the control is placed at the posed region, so nothing jumps.
    """

    role: str  # HANDLE, FIXED or SUPPORT
    vertex_group: str
    control: Object | None = None
    bone: str = ""
    owns_group: bool = False  # the group was made for the region, and goes with it
    name: str = ""  # else that of the group
    weight: float = 1.0


@sessions.suspended()
def add_handle(obj: Object, deformer: SinewDeformer, region: NewRegion) -> SinewHandle:
    """Add a region. ``bind`` must follow."""
    handle, entered = add_captured_handle(obj, deformer, region)
    if entered is not None:
        bpy.data.meshes.remove(entered)
    return handle


@sessions.suspended()
def add_captured_handle(
    obj: Object, deformer: SinewDeformer, region: NewRegion
) -> tuple[SinewHandle, Mesh | None]:
    """As ``add_handle``; and what enters the modifier, if it was captured for the control: a new mesh."""
    handle = add_region(obj, deformer, region)
    entered = None
    if region.role == "HANDLE":
        try:
            entered = _give_control(obj, deformer, handle, region.control, region.bone)
        except SinewError:
            deformer.handles.remove(len(deformer.handles) - 1)
            obj.update_tag()  # the evaluated copy still has it
            raise
    handle.weight = region.weight
    handle.name = region.name or handle.name
    return handle, entered


@sessions.suspended()
def add_region(obj: Object, deformer: SinewDeformer, region: NewRegion) -> SinewHandle:
    """Add a region without a control. ``bind`` must follow."""
    vertex_group = region.vertex_group
    if vertex_group not in obj.vertex_groups:
        raise ConstraintError(f"{obj.name} has no vertex group '{vertex_group}' - choose one of its groups")
    handle = deformer.handles.add()
    handle.uid = shapes.new_key()
    handle.kind = region.role
    handle.vertex_group = vertex_group
    handle.owns_group = region.owns_group
    taken = [other.name for other in deformer.handles if other.uid != handle.uid]
    handle.named = unique_name(vertex_group, taken)  # so that the name below renames nothing
    handle.name = handle.named
    handle.colour = empties.colour(len(deformer.handles) - 1)
    deformer.active_handle = len(deformer.handles) - 1
    return handle


def _give_control(
    obj: Object, deformer: SinewDeformer, handle: SinewHandle, control: Object | None, bone: str
) -> Mesh:
    """Let ``control`` or a new empty move a handle; a new mesh, what enters the modifier."""
    mesh = capture.rest_mesh(obj, deformer)
    try:
        rest = read_rest(mesh)
        members = _members(mesh, handle)
        pose = _current_pose(deformer, rest, members)
        if control is not None:
            empties.assign(obj, handle, control, bone, pose)
            return mesh
        control, frame = empties.make_empty(obj, rest, members, f"{obj.name} {handle.name}", pose)
    except SinewError:
        bpy.data.meshes.remove(mesh)
        raise
    empties.own(obj, deformer, handle, control, frame)
    return mesh


def _members(mesh: Mesh, handle: SinewHandle) -> np.ndarray:
    groups = group_weights(mesh, group_names(mesh), {handle.vertex_group})
    members = np.flatnonzero(groups[handle.vertex_group] > 0.0)
    if len(members) == 0:
        raise ConstraintError(f"Vertex group '{handle.vertex_group}' has no vertices - assign some first")
    return members


def _current_pose(deformer: SinewDeformer, rest: RestShape, members: np.ndarray) -> np.ndarray:
    """How the region is moved now, as a rigid pose."""
    session = sessions.find(deformer.uid)
    shown = session.view("VIEWPORT") if session else None
    if shown is None or shown.positions is None or len(shown.positions) != len(rest.points):
        return poses.IDENTITY
    before = session.bound.rest.points if shown.incoming is None else shown.incoming.astype(np.float64)
    after = shown.positions + (before if shown.displacement else 0.0)
    return frames.fit(before[members], after[members], rigid=True)


@sessions.suspended()
def new_control(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> None:
    """Give a handle that has lost its control an empty of its own, where its region is now. Nothing jumps.

    One without a region acts as a place from now on.
    """
    pose, name = poses.kept_pose(deformer, handle), f"{obj.name} {handle.name}"
    surface = riding.surface_of(deformer, handle)
    now = surface @ riding.square(pose) @ np.linalg.inv(surface)
    if handle.vertex_group:
        mesh = capture.rest_mesh(obj, deformer)
        try:
            empty, _frame = empties.make_empty(obj, read_rest(mesh), _members(mesh, handle), name, now[:3])
        finally:
            bpy.data.meshes.remove(mesh)
    else:
        size = 0.05 * (max(obj.dimensions) or 1.0)
        empty = empties.new_empty(obj, surface @ riding.rest_of(handle), now, name, size)
        handle.acts_as = "PLACE"
    handle.control, handle.bone, handle.owns_control = empty, "", True
    stand = np.linalg.inv(surface) @ riding.parent_inverse(empty)
    riding.set_stand(handle, stand)
    poses.capture_rest(handle, np.eye(4), stand @ np.array(empty.matrix_basis, dtype=np.float64), pose)
    handle.has_last_pose = False
    kinds.keep_evaluated(obj)
    obj.update_tag()


@sessions.suspended()
def remove_handle(obj: Object, deformer: SinewDeformer, index: int) -> None:
    """Remove a region, with the control and the vertex group that were made for it."""
    handle = deformer.handles[index]
    forget_row_rest(handle)
    release_control(handle)
    release_group(obj, deformer, handle)
    order = animation_paths.removed(len(deformer.handles), index)
    deformer.handles.remove(index)
    animation_paths.rows_reordered(obj, deformer, "handles", order)
    deformer.active_handle = max(0, min(deformer.active_handle, len(deformer.handles) - 1))
    kinds.keep_evaluated(obj)
    obj.update_tag()
    kind = kinds.kind_in_use(deformer)
    if not kind.is_set(deformer):
        unbind(obj, deformer)
        status.put(deformer.uid, Status(Level.INFO, kind.MISSING))
