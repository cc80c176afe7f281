# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that stand on the surface as it enters, which bones and shape keys before Sinew move.

Let M be the rigid motion that fits best how the surface under a handle has moved from rest. What the control
does beyond it is the pose P, relative to the surface at rest. So the handle moves what enters by M P M^-1,
and without a correction by nothing. A control that was made for its handle is carried along: it is a child
of the target, its parent inverse is M S with the frame S that carried it at rest, and its own transform is
the correction alone. As the pose is computed from what enters and from that transform, the shape is right in
the very evaluation that carries the control. Other controls go where their own parents and constraints take
them, and the region goes with them.
"""

from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ....core.geometry import frames, rigid_motion
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...state import render_writes, sessions
from ...state.evaluation import Evaluation
from ...state.sessions import Bound, Session
from .sides import mirrored

_ROUNDING = 1e-5  # of float32 matrices that were multiplied, as a share of their largest entry


def is_riding(handle: SinewHandle) -> bool:
    """Whether the rest frames of a handle refer to the surface."""
    return handle.stood_on == "SURFACE"


def is_carried(obj: Object, handle: SinewHandle) -> bool:
    """Whether Sinew carries the control: nothing else does, neither a parent nor a constraint of the user."""
    control = handle.control
    return (
        is_riding(handle)
        and handle.owns_control
        and control is not None
        and control.library is None
        and not handle.bone
        and control.parent == obj
        and control.parent_type == "OBJECT"
        and not control.constraints
        and stand_of(handle)[3, 3] == 1.0
    )


def rest_of(handle: SinewHandle) -> np.ndarray:
    """The rest frame: the control relative to the target at rest, (4, 4)."""
    return np.array(handle.rest_matrix, dtype=np.float64).reshape(4, 4, order="F")


def standing(handle: SinewHandle) -> str:
    """What the control of a handle stands on, as an artist reads it; or what carries it instead."""
    if handle.stands_on != "SURFACE":
        return f"{handle.name} stays in the world"
    carrier = carrier_of(handle)
    if carrier:
        return f"{handle.name} now follows {carrier}"
    return f"{handle.name} stands on the surface and moves with it"


def carrier_of(handle: SinewHandle) -> str:
    """The parent or constraint that carries the control in place of the surface; empty if none does."""
    control = handle.control
    if control is None or is_carried(handle.id_data, handle):
        return ""
    for constraint in control.constraints:
        target = getattr(constraint, "target", None)
        return getattr(constraint, "subtarget", "") or (constraint.name if target is None else target.name)
    if handle.bone:
        return handle.bone
    if control.parent is not None:
        return control.parent_bone if control.parent_type == "BONE" else control.parent.name
    return control.name


def stand_of(handle: SinewHandle) -> np.ndarray:
    """The frame that carries the control on the surface at rest, relative to the target, (4, 4)."""
    return np.array(handle.stand_matrix, dtype=np.float64).reshape(4, 4, order="F")


def set_stand(handle: SinewHandle, frame: np.ndarray) -> None:
    """Store the frame that carries the control on the surface at rest."""
    handle.stand_matrix = frame.ravel(order="F").tolist()


def parent_inverse(control: Object) -> np.ndarray:
    """What carries a child of the target now, relative to the target, (4, 4)."""
    return np.array(control.matrix_parent_inverse, dtype=np.float64)


# How the surface has moved


class Surface(NamedTuple):
    """How the surface under a handle has ``moved`` from rest, (4, 4).

    ``by_place``: the place of the control counts in this evaluation, even if it is carried.
    """

    moved: np.ndarray
    by_place: bool


def ride(evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None) -> dict[str, Surface]:
    """What each handle stands on that stands on the surface, by its key.

    The controls are put there, and in viewports the rest frames follow *Stands On*. A render leaves controls
    alone while a window shows them.
    """
    session, handles = sessions.open_session(evaluation.deformer.uid), evaluation.deformer.handles
    asking = [handle for handle in handles if _asks(handle) and handle.uid in bound.handles]
    if evaluation.in_viewport:
        _tell(evaluation)
    if not asking:
        return {}
    world = np.array(evaluation.evaluated.matrix_world, dtype=np.float64)
    moved = motions(bound, asking, incoming, world)
    displaced: set[str] = set()
    if evaluation.in_viewport:
        for handle in asking:
            if not carry(evaluation.obj, session, handle, moved[handle.uid]):
                displaced.add(handle.uid)
            if handle.stands_on != handle.stood_on:
                change_stand(evaluation.obj, handle, moved[handle.uid])
                evaluation.obj.update_tag()  # the evaluated copy still has the former frames
        session.surfaces = moved
    elif not render_writes.must_hand_over(evaluation.depsgraph.scene):
        for handle in asking:
            if is_carried(evaluation.obj, handle):
                _put(session, handle, moved[handle.uid] @ stand_of(handle))
    return {
        handle.uid: Surface(moved[handle.uid], handle.uid in displaced)
        for handle in asking
        if is_riding(handle)
    }


def _tell(evaluation: Evaluation) -> None:
    """Say in the panel which control has been taken off the surface by a parent or a constraint."""
    told = next((standing(handle) for handle in evaluation.deformer.handles if _is_taken(handle)), "")
    if told or evaluation.session.told:
        evaluation.note(told)
    evaluation.session.told = told


def _is_taken(handle: SinewHandle) -> bool:
    return is_riding(handle) and handle.owns_control and bool(carrier_of(handle))


def _asks(handle: SinewHandle) -> bool:
    return handle.kind == "HANDLE" and "SURFACE" in (handle.stands_on, handle.stood_on)


def motions(
    bound: Bound, handles: list[SinewHandle], points: np.ndarray | None, world: np.ndarray
) -> dict[str, np.ndarray]:
    """How the surface under handles has moved from rest to ``points`` (n, 3), (4, 4) by their keys.

    The motions are rigid in the world, where ``world`` (4, 4) is the frame of the target.
    """
    if points is None:
        return {handle.uid: np.eye(4) for handle in handles}
    frames.inverse(world, "The mesh object")  # refuses one that is scaled to zero
    found = {}
    for handle in handles:
        piece = _piece(bound, handle)
        found[handle.uid] = rigid_motion.motion(bound.rest.points[piece], points[piece], world[:3, :3])
    if bound.factor.recipe.method.keyed:  # which has frames of its own
        still = bound.factor.still_poses(incoming=points, from_rest=np.ones(len(bound.handles), dtype=bool))
        found |= {key: square(pose) for key, pose in zip(bound.handles, still, strict=True) if key in found}
    return found


def _piece(bound: Bound, handle: SinewHandle) -> np.ndarray:
    """The vertices whose motion carries a handle: those of its region, or around its place without one."""
    found = bound.pieces.get(handle.uid)
    if found is None:
        rest = bound.rest
        found = rigid_motion.piece(rest.points, rest.counts, rest.corners, _members(rest, handle))
        bound.pieces[handle.uid] = found
    return found


def _members(rest: RestShape, handle: SinewHandle) -> np.ndarray:
    painted = rest.weights.get(handle.vertex_group)
    if painted is not None:
        return np.flatnonzero(painted > 0.0)
    if handle.vertex_group or not len(rest.points):
        return np.empty(0, dtype=np.intp)
    place = rest_of(handle)[:3, 3]
    distances = np.linalg.norm(rest.points - place, axis=1)
    return np.array([np.argmin(np.where(np.isfinite(distances), distances, np.inf))])


# Poses


def seen_from_surface(
    obj: Object, handle: SinewHandle, depsgraph: Depsgraph, control: np.ndarray, surface: np.ndarray
) -> np.ndarray:
    """A control, (4, 4) in the frame of the target, as if the ``surface`` (4, 4) had not moved from rest.

    One that is carried may still be where it was carried last, so only its own transform counts.
    """
    if is_carried(obj, handle):
        evaluated = handle.control.evaluated_get(depsgraph)
        return stand_of(handle) @ np.array(evaluated.matrix_basis, dtype=np.float64)
    return np.linalg.inv(surface) @ control


def on_surface(bound: Bound, surface: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """A pose (3, 4) relative to the surface at rest as the factor takes it, where the ``surface`` is now."""
    method = bound.factor.recipe.method
    posed = surface @ square(pose)
    if method.keyed:  # whose pose is that of a control which follows the animation, from rest
        return posed[:3]
    if method.adds_displacements:  # to what has moved by M, after it was moved from rest
        return (posed - surface + np.eye(4))[:3]
    return (posed @ np.linalg.inv(surface))[:3]


def image_of(leader: SinewHandle, partner: SinewHandle, basis: np.ndarray) -> np.ndarray:
    """The own transform (4, 4) of the partner's control that is the mirror image of the leader's ``basis``.

    Each is seen in the frame of its own surface, as the two sides may be posed differently.
    """
    correction = frames.inverse(rest_of(leader), leader.name) @ stand_of(leader) @ basis
    placed = rest_of(partner) @ mirrored(correction)
    return frames.inverse(stand_of(partner), partner.name) @ placed


def surface_of(deformer: SinewDeformer, handle: SinewHandle) -> np.ndarray:
    """How the surface under a handle had moved from rest in the last evaluation; not at all in the world."""
    session = sessions.find(deformer.uid)
    found = None if session is None or not is_riding(handle) else session.surfaces.get(handle.uid)
    return np.eye(4) if found is None else found


def square(pose: np.ndarray) -> np.ndarray:
    """A pose (3, 4) as a matrix (4, 4)."""
    return np.vstack((pose, (0.0, 0.0, 0.0, 1.0)))


# What is written


def carry(obj: Object, session: Session, handle: SinewHandle, surface: np.ndarray) -> bool:
    """Put the control onto the surface; False if it was to stay where something else has put it just now.

    It is drawn there at once, as Blender evaluates what handlers write.
    """
    if not is_carried(obj, handle):
        return True
    control, frame = handle.control, surface @ stand_of(handle)
    now = parent_inverse(control)
    is_ours = _is_ours(session, handle, now, frame)
    if not is_ours:
        basis = np.array(control.matrix_basis, dtype=np.float64)
        control.matrix_basis = Matrix((frames.inverse(frame, handle.name) @ now @ basis).tolist())
    _put(session, handle, frame)
    return is_ours


def _put(session: Session, handle: SinewHandle, frame: np.ndarray) -> None:
    control = handle.control
    if not np.array_equal(frame.astype(np.float32), parent_inverse(control).astype(np.float32)):
        control.matrix_parent_inverse = Matrix(frame.tolist())
    session.carried[handle.uid] = parent_inverse(control)


def _is_ours(session: Session, handle: SinewHandle, now: np.ndarray, frame: np.ndarray) -> bool:
    """Whether Sinew has written what carries the control ``now``.

    Apply writes it, too, with another own transform, so that the control stays where it is. That of an undo
    step may be of another frame, unless it was found to be such before.
    """
    if np.abs(now - frame).max() <= _ROUNDING * np.abs(frame).max():
        return True
    last = session.carried.get(handle.uid)
    basis = np.array(handle.control.matrix_basis, dtype=np.float64)
    key = (handle.uid, now.tobytes(), basis.tobytes())
    if last is None:
        return key not in session.foreign
    if np.array_equal(last, now):
        return True
    session.foreign.add(key)
    return False


def change_stand(obj: Object, handle: SinewHandle, surface: np.ndarray) -> None:
    """Let the rest frames refer to what the handle stands on now. The shape of this frame stays."""
    rest = rest_of(handle)
    handle.stood_on = handle.stands_on
    if is_riding(handle):
        if not handle.from_rest:
            rest = np.linalg.inv(surface) @ rest
        if handle.control is not None and handle.control.parent == obj:
            set_stand(handle, np.linalg.inv(surface) @ parent_inverse(handle.control))
        handle.from_rest = False
    else:
        rest = surface @ rest
    handle.rest_matrix = rest.ravel(order="F").tolist()


def _same_shape(bound: Bound, points: np.ndarray) -> bool:
    return points.shape == bound.rest.points.shape


def turn_with_rest(obj: Object, deformer: SinewDeformer, bound: Bound | None, points: np.ndarray) -> None:
    """Let controls do the same when ``points`` (n, 3) become the rest shape.

    ``bound`` is the factor for the rest shape so far. Without one of as many points, or with points that are
    not finite, the place counts where the controls were put last.
    """
    riding = [handle for handle in deformer.handles if is_riding(handle) and handle.has_rest]
    moved: dict[str, np.ndarray] = {}
    is_finite = bool(np.isfinite(points).all())
    if is_finite and bound is not None and not bound.factor.is_released and _same_shape(bound, points):
        known = [handle for handle in riding if handle.uid in bound.handles]
        moved = motions(bound, known, points, np.array(obj.matrix_world, dtype=np.float64))
    for handle in riding:
        surface = moved.get(handle.uid)
        if surface is None and is_carried(obj, handle):
            surface = parent_inverse(handle.control) @ np.linalg.inv(stand_of(handle))
        if surface is not None:
            handle.rest_matrix = (surface @ rest_of(handle)).ravel(order="F").tolist()
            set_stand(handle, surface @ stand_of(handle))
    session = sessions.find(deformer.uid)
    if session is not None:
        session.surfaces = {}
