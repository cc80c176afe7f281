# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives a control to a mirrored handle: the bone or object of the other side, or else an empty."""

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix

from ....core.geometry import frames
from ....core.sides import flip
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...controls.handles import poses, riding
from ...controls.handles.release import release_control
from ...controls.handles.sides import mirrored
from ...datablocks.transforms import put
from ...state import sessions
from . import empties

_CLOSE = 1e-3  # largest difference of poses that count as equal: a millimetre, a twentieth of a degree


def give(
    obj: Object,
    deformer: SinewDeformer,
    source: SinewHandle,
    target: SinewHandle,
    rest: RestShape,
    members: np.ndarray,
) -> None:
    """Let the control of the other side move the handle ``target``, in the mirrored pose.

    ``members`` are its vertices in ``rest``. A control that the user chose before stays where it is.
    """
    if target.kind != "HANDLE":
        release_control(target)
        return
    surface = riding.surface_of(deformer, source)
    now = surface @ riding.square(_pose(obj, deformer, source)) @ np.linalg.inv(surface)
    pose = mirrored(now)
    frame = mirrored(surface @ poses.rest_of(source)) if source.has_rest else None
    if not target.control_missing:
        if target.owns_control and frame is not None:
            _place(obj, deformer, target, frame, pose)
        return
    control, bone = _other_side(obj, source)
    if control is None:
        empty, own_frame = empties.make_empty(obj, rest, members, f"{obj.name} {target.name}", pose[:3])
        _give_empty(target, empty, source.control)
        _place(obj, deformer, target, own_frame if frame is None else frame, pose)
    elif bone:
        _give_bone(obj, source, target, control, bone)
    else:
        _give_object(obj, target, control, frame, pose)


def _pose(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> np.ndarray:
    """The pose of a handle now, (3, 4), relative to its rest; its last one if its control is gone."""
    control = poses.present(obj, deformer, handle, bpy.context.evaluated_depsgraph_get())
    if control is not None and handle.has_rest:
        return (control @ frames.inverse(poses.rest_of(handle), f"The control of {handle.name}"))[:3]
    session = sessions.find(deformer.uid)
    return poses.IDENTITY if session is None else session.poses.get(handle.uid, poses.IDENTITY)


def _world(obj: Object) -> np.ndarray:
    return np.array(obj.matrix_world, dtype=np.float64)


def _other_side(obj: Object, source: SinewHandle) -> tuple[Object | None, str]:
    """The bone of the same armature, or the object of the scene, with the name of the other side."""
    control = source.control
    if control is None:
        return None, ""
    bone = flip(source.bone)
    if bone and control.pose is not None and bone in control.pose.bones:
        return control, bone
    other = bpy.context.scene.objects.get(flip(control.name) or " ")
    usable = other is not None and other not in (obj, control)
    return (other if usable and not source.bone else None), ""


def _give_empty(target: SinewHandle, empty: Object, like: Object | None) -> None:
    """Let an empty, which looks like the other control if that is one, too, move a handle."""
    if like is not None and like.type == "EMPTY":
        for name in ("empty_display_type", "empty_display_size", "show_in_front", "rotation_mode"):
            setattr(empty, name, getattr(like, name))
    target.control, target.bone, target.owns_control = empty, "", True


def _place(
    obj: Object, deformer: SinewDeformer, target: SinewHandle, frame: np.ndarray, pose: np.ndarray
) -> None:
    """Move the control of a handle to where ``pose`` takes the rest frame ``frame``, and store that frame."""
    control = target.control
    if control.parent == obj and control.parent_type == "OBJECT":
        control.matrix_parent_inverse = Matrix(frame.tolist())
        put(control, Matrix((frames.inverse(frame, target.name) @ pose @ frame).tolist()))
    else:
        control.matrix_world = Matrix((_world(obj) @ pose @ frame).tolist())
    at_rest = np.linalg.inv(riding.surface_of(deformer, target)) @ frame
    poses.set_rest(target, at_rest)
    riding.set_stand(target, at_rest)


def _give_bone(obj: Object, source: SinewHandle, target: SinewHandle, control: Object, bone: str) -> None:
    """Let a bone move a handle. It rests, in its own axes, as the bone of the source does in its axes."""
    target.control, target.bone, target.owns_control = control, bone, False
    if not source.has_rest:
        return
    to_target = frames.inverse(_world(obj), obj.name) @ _world(control)
    bones = control.data.bones
    own, other = (np.array(bones[name].matrix_local, dtype=np.float64) for name in (source.bone, bone))
    moved = frames.inverse(to_target @ own, source.bone) @ poses.rest_of(source)
    poses.set_rest(target, to_target @ other @ mirrored(moved))


def _give_object(
    obj: Object, target: SinewHandle, control: Object, frame: np.ndarray | None, pose: np.ndarray
) -> None:
    """Let an object move a handle, without moving the object.

    If it stands at the mirror image of the rest or pose of the source, its rest frame is mirrored too. Else
    its place now means the mirrored pose.
    """
    target.owns_control = False
    empties.assign(obj, target, control, "", pose[:3])
    matrix = poses.control_matrix(target, bpy.context.evaluated_depsgraph_get())
    if frame is None or matrix is None:
        return
    now = frames.pose(_world(obj), matrix, frame, control.name)
    if any(np.abs(now - known[:3]).max() < _CLOSE for known in (pose, np.eye(4))):
        poses.set_rest(target, frame)
