# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets a control stand on the surface that enters, or in the world. Main thread only."""

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix

from .... import compat
from ....core.errors import SinewError
from ....core.geometry import frames
from ....properties import SinewDeformer, SinewHandle
from ...controls.handles import poses, riding
from ...controls.handles.points import are_apart
from ...controls.movers import CHANNELS
from ...datablocks.movers import is_moved_before

NOTHING_MOVES = "Nothing before Sinew moves this mesh"
_SAME = 1e-6  # of a frame: keys so near each other are at one


def why_not_on_surface(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> str:
    """Why a handle cannot stand on the surface; empty if it can."""
    if handle.kind != "HANDLE":
        return "It has no control"
    if are_apart(deformer, handle):
        return "The points of its control count, not its place"
    return "" if is_moved_before(obj, deformer) else NOTHING_MOVES


def stand_on(obj: Object, deformer: SinewDeformer, handle: SinewHandle, on: str, convert: bool) -> int:
    """Let a handle stand ``on`` WORLD or SURFACE. The shape of this frame stays.

    With ``convert`` the keyframes of its control are rewritten, so that each keeps the shape of its frame;
    returns how many frames these are.
    """
    if on == handle.stands_on:
        return 0
    why = why_not_on_surface(obj, deformer, handle)
    if on == "SURFACE" and why:
        raise SinewError(f"{why} - {handle.name} stays in the world")
    scene = bpy.context.scene
    here = scene.frame_current, scene.frame_subframe
    keyed = _keyed_frames(handle.control) if convert and _is_own_child(obj, handle) else []
    effects = {}
    for frame in keyed:
        _go(frame)
        effects[frame] = _effect(obj, deformer, handle)
    _go(here[0] + here[1])
    handle.stands_on = on
    obj.update_tag()
    bpy.context.view_layer.update()
    for frame, effect in effects.items():
        _go(frame)
        _key(obj, deformer, handle, frame, effect)
    if keyed:
        _go(here[0] + here[1])
    return len(keyed)


def _go(frame: float) -> None:
    whole = int(np.floor(frame))
    bpy.context.scene.frame_set(whole, subframe=frame - whole)


def _is_own_child(obj: Object, handle: SinewHandle) -> bool:
    control = handle.control
    return (
        control is not None and not handle.bone and control.parent == obj and control.parent_type == "OBJECT"
    )


def _curves(control: Object) -> list:
    return [curve for _action, curve in compat.action_curves(control) if curve.data_path in CHANNELS]


def _keyed_frames(control: Object) -> list[float]:
    found = sorted(point.co.x for curve in _curves(control) for point in curve.keyframe_points)
    return [frame for i, frame in enumerate(found) if not i or frame - found[i - 1] > _SAME]


def _effect(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> np.ndarray:
    """How the handle moves what enters now, (4, 4)."""
    control = poses.present(obj, deformer, handle, bpy.context.evaluated_depsgraph_get())
    if control is None:
        raise SinewError(f"{handle.name} has lost its control - New Control, or pick another")
    pose = control @ frames.inverse(riding.rest_of(handle), handle.name)
    surface = riding.surface_of(deformer, handle)
    return surface @ pose @ np.linalg.inv(surface)


def _key(obj: Object, deformer: SinewDeformer, handle: SinewHandle, frame: float, effect: np.ndarray) -> None:
    """Let the keys of the control at a frame move what enters by ``effect`` (4, 4)."""
    control, surface = handle.control, riding.surface_of(deformer, handle)
    stand = riding.stand_of(handle) if riding.is_riding(handle) else riding.parent_inverse(control)
    placed = np.linalg.inv(surface) @ effect @ surface @ riding.rest_of(handle)
    control.matrix_basis = Matrix((frames.inverse(stand, handle.name) @ placed).tolist())
    for curve in _curves(control):
        if any(abs(point.co.x - frame) <= _SAME for point in curve.keyframe_points):
            control.keyframe_insert(curve.data_path, index=curve.array_index, frame=frame)
