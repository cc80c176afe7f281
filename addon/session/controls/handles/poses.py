# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of the controls as poses in the object space of the target."""

import math
from functools import lru_cache
from typing import NamedTuple

import bpy
import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ....core.errors import ConstraintError
from ....core.geometry import frames
from ....mesh_io import read_shape
from ....properties import SinewDeformer, SinewHandle
from ...state import sessions
from ...state.evaluation import Evaluation
from ...state.sessions import Bound
from ..placement import read_place
from . import points, riding
from .links import follow_renamed_bones
from .riding import rest_of

IDENTITY = np.eye(4)[:3]


def control_matrix(handle: SinewHandle, depsgraph: Depsgraph) -> np.ndarray | None:
    """The evaluated control in the world, (4, 4); None if it is missing."""
    place = read_place(handle.control, depsgraph, handle.bone)
    return None if place is None else place.matrix()


def _inverse(matrix: Matrix, whose: str) -> np.ndarray:
    """The inverse (4, 4). It is kept for matrices that stay the same from frame to frame."""
    return _kept_inverse(matrix.copy().freeze(), whose)


@lru_cache(maxsize=256)
def _kept_inverse(matrix: Matrix, whose: str) -> np.ndarray:
    return frames.inverse(np.array(matrix.copy(), dtype=np.float64), whose)


def set_rest(handle: SinewHandle, matrix: np.ndarray) -> None:
    """Store the rest frame of the control."""
    handle.rest_matrix = matrix.ravel(order="F").tolist()
    handle.has_rest = True


def capture_rest(
    handle: SinewHandle, target: np.ndarray, control: np.ndarray, pose: np.ndarray | None = None
) -> None:
    """Choose the rest frame so that ``control``, which is its place in the world now, means ``pose``.

    By default that is the identity. So nothing jumps.
    """
    now = frames.inverse(target, "The mesh object") @ control
    if pose is not None:
        now = frames.inverse(riding.square(pose), handle.name) @ now
    set_rest(handle, now)


def transform_rest(deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
    """Take rest frames and last poses along with an affine map ``by`` (4, 4) of the target's object space."""
    inverse = frames.inverse(by, "The mesh object")
    for handle in deformer.handles:
        if handle.has_rest:
            set_rest(handle, by @ rest_of(handle))
            riding.set_stand(handle, by @ riding.stand_of(handle))
        if handle.has_last_pose:
            last = np.array(handle.last_pose, dtype=np.float64).reshape(3, 4)
            handle.last_pose = (by[:3] @ riding.square(last) @ inverse).ravel().tolist()
        points.transform_rest(handle, by, held)
        if handle.uid in held:
            held[handle.uid] = by[:3] @ riding.square(held[handle.uid]) @ inverse


class HandlePoses(NamedTuple):
    """Where the handles of a bind are, in one evaluation.

    ``affine`` (k, 3, 4) are their poses, ``from_rest`` (k,) says whether each moves the rest shape, and
    ``placed`` are the points (c, 3) of each handle whose points count, instead of its pose. ``seen`` and
    ``lost`` are the places of handles with and without their control, before a surface carries them on, as
    ``keep_poses`` stores them.
    """

    affine: np.ndarray
    from_rest: np.ndarray
    placed: list[np.ndarray]
    seen: dict[str, np.ndarray]
    lost: dict[str, np.ndarray]


def take_up_controls(evaluation: Evaluation, bound: Bound, surfaces: dict[str, riding.Surface]) -> None:
    """Follow bones that were renamed, and give controls without a rest frame one.

    A control that took the place of another one starts where that one was.
    """
    pairs = list(zip(evaluation.deformer.handles, evaluation.control, strict=True))
    if any(place is None and handle.bone for handle, place in pairs):
        follow_renamed_bones(evaluation.obj)
    counts, by_key = points.bound_counts(bound), {handle.uid: handle for handle, _place in pairs}
    for row, key in enumerate(bound.handles):
        handle = by_key.get(key)
        if handle is None or handle.kind != "HANDLE" or handle.has_rest or row in counts:
            continue
        world = control_matrix(handle, evaluation.depsgraph)
        control = _in_target(evaluation, handle, world, surfaces.get(key))
        if control is not None:
            held = evaluation.session.poses
            last = held[key] if key in held else _last_pose(evaluation.deformer, bound, row)
            capture_rest(handle, np.eye(4), control, last)
            evaluation.session.rewire, handle.has_last_pose = True, False


def read_poses(
    evaluation: Evaluation, bound: Bound, surfaces: dict[str, riding.Surface]
) -> HandlePoses | None:
    """The handles as they are. A handle without its control stays where it was last.

    None if the last place of points is unknown. ``surfaces`` are what handles stand on, see ``riding.ride``.
    """
    deformer, held = evaluation.deformer, evaluation.session.poses
    by_key = {
        handle.uid: (handle, place)
        for handle, place in zip(deformer.handles, evaluation.control, strict=True)
    }
    counts = points.bound_counts(bound)
    found = HandlePoses(
        np.tile(IDENTITY, (len(bound.handles), 1, 1)), np.zeros(len(bound.handles), dtype=bool), [], {}, {}
    )
    for row, key in enumerate(bound.handles):
        handle, place = by_key.get(key, (None, None))
        if handle is None or handle.kind != "HANDLE":
            continue
        if place is None and handle.bone:  # perhaps under another name by now
            place = points.place_of(deformer, handle, evaluation.depsgraph)
        surface = surfaces.get(key)
        found.from_rest[row] = handle.from_rest if surface is None else bound.factor.recipe.method.keyed
        if row in counts:
            now = points.now(evaluation, handle, place, counts[row])
            if now is None:
                return None
            found.seen[points.held_key(handle)] = now
            found.placed.append(now)
            continue
        control = _in_target(evaluation, handle, None if place is None else place.matrix(), surface)
        if control is not None and handle.has_rest:
            to_rest = _inverse(handle.rest_matrix, f"The control of {handle.name}")
            pose = found.seen[key] = (control @ to_rest)[:3]
            if not math.isfinite(pose.sum()):
                raise ConstraintError(frames.not_a_number(f"The control of {handle.name}"))
        else:
            pose = found.lost[key] = held[key] if key in held else _last_pose(deformer, bound, row)
        found.affine[row] = pose if surface is None else riding.on_surface(bound, surface.moved, pose)
    return found


def keep_poses(evaluation: Evaluation, found: HandlePoses) -> None:
    """Remember the poses: a control may be deleted. In viewports, the file keeps those without a control."""
    evaluation.session.poses.update(found.seen | found.lost)
    if evaluation.in_viewport:
        for handle in evaluation.deformer.handles:
            if handle.uid in found.lost:
                _keep(handle, found.lost[handle.uid])


def _in_target(
    evaluation: Evaluation, handle: SinewHandle, control: np.ndarray | None, surface: riding.Surface | None
) -> np.ndarray | None:
    """A control in the world as one in the frame of the target; on a surface, as if that were at rest."""
    if control is None:
        return None
    control = _inverse(evaluation.evaluated.matrix_world, "The mesh object") @ control
    if surface is None:
        return control
    if surface.by_place:
        return frames.inverse(surface.moved, handle.name) @ control
    return riding.seen_from_surface(evaluation.obj, handle, evaluation.depsgraph, control, surface.moved)


def rest_here(
    obj: Object, deformer: SinewDeformer, still: dict[str, np.ndarray], depsgraph: Depsgraph
) -> None:
    """Let controls that are where they are now mean the poses ``still`` (3, 4), by the key of the handle."""
    session = sessions.find(deformer.uid)
    for handle in deformer.handles:
        if handle.kind != "HANDLE" or handle.uid not in still:
            continue
        pose = still[handle.uid]
        if riding.is_riding(handle):
            surface = riding.surface_of(deformer, handle)
            pose = (np.linalg.inv(surface) @ riding.square(pose))[:3]
        control = present(obj, deformer, handle, depsgraph)
        if control is not None:
            capture_rest(handle, np.eye(4), control, pose)
        else:
            _keep(handle, pose)
        if session is not None:
            session.poses[handle.uid] = pose.copy()


def present(
    obj: Object, deformer: SinewDeformer, handle: SinewHandle, depsgraph: Depsgraph
) -> np.ndarray | None:
    """The control in the frame of the target, (4, 4); on a surface, as if that had not moved from rest.

    None if it is missing.
    """
    control = control_matrix(handle, depsgraph)
    if control is None:
        return None
    target = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    control = frames.inverse(target, "The mesh object") @ control
    if not riding.is_riding(handle):
        return control
    return riding.seen_from_surface(obj, handle, depsgraph, control, riding.surface_of(deformer, handle))


def _keep(handle: SinewHandle, pose: np.ndarray) -> None:
    """Store in the file where a region without a control stays."""
    values = pose.astype(np.float32).ravel()
    if not handle.has_last_pose or not np.array_equal(values, np.array(handle.last_pose, dtype=np.float32)):
        handle.last_pose, handle.has_last_pose = values.tolist(), True


def kept_pose(deformer: SinewDeformer, handle: SinewHandle) -> np.ndarray:
    """The pose (3, 4) that the region of a handle without a control keeps."""
    session = sessions.find(deformer.uid)
    if session is not None and handle.uid in session.poses:
        return session.poses[handle.uid]
    if session is not None and session.bound is not None and handle.uid in session.bound.handles:
        return _last_pose(deformer, session.bound, session.bound.handles.index(handle.uid))
    kept = _stored_pose(handle)
    return IDENTITY if kept is None else kept


def _stored_pose(handle: SinewHandle) -> np.ndarray | None:
    """The pose in the file, which a handle without a control keeps; None if there is none."""
    kept = np.array(handle.last_pose, dtype=np.float64).reshape(3, 4)
    return kept if handle.has_last_pose and np.isfinite(kept).all() else None


def keep_pose(deformer: SinewDeformer, held: dict[str, np.ndarray]) -> None:
    """Store the poses ``held`` of controls from libraries: the next time, these may be missing."""
    for handle in deformer.handles:
        if handle.control is not None and handle.control.library is not None and handle.uid in held:
            _keep(handle, held[handle.uid])


def _last_pose(deformer: SinewDeformer, bound: Bound, row: int) -> np.ndarray:
    """Where a region without its control stays: as stored in the file, else as the saved shape shows it."""
    handle = next(handle for handle in deformer.handles if handle.uid == bound.handles[row])
    kept = _stored_pose(handle)
    if kept is not None:
        return kept
    rest = bound.rest.points
    members = bound.indices[row]
    if not len(members):
        return IDENTITY
    for proxy in (deformer.shape("VIEWPORT"), deformer.shape("RENDER")):
        shape = read_shape(proxy.data) if proxy is not None else None
        if shape is not None and len(shape) == len(rest):
            return frames.fit(rest[members], shape[members])
    return IDENTITY


def complete_rest_frames(obj: Object, deformer: SinewDeformer) -> None:
    """Give a rest frame to each handle that has a control but no rest frame yet; likewise where points count.

    Those that have become more or fewer rest as they are now.
    """
    lacking = [
        row
        for row in deformer.handles
        if row.kind == "HANDLE" and row.control is not None and not row.has_rest
    ]
    apart = [row for row in deformer.handles if points.are_apart(deformer, row)]
    if not lacking and not apart:
        return  # on a heavy mesh, the evaluation takes as long as all else here
    target = np.array(obj.matrix_world, dtype=np.float64)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for handle in lacking:
        matrix = control_matrix(handle, depsgraph)
        if matrix is not None:
            capture_rest(handle, target, matrix)
            if handle.control.parent == obj:
                riding.set_stand(handle, riding.parent_inverse(handle.control))
    for handle in apart:
        if points.is_stale(deformer, handle, depsgraph):
            points.take_rest(obj, handle)
