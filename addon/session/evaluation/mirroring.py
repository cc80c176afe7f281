# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrored posing: the control of the other side follows the one that an artist moves, as its mirror image.

What an artist moves differs from what was seen after the last evaluation, before the next one begins. What
animation and drivers move differs only after it. So partners follow before Blender evaluates, and everything
is noted as seen afterwards. Both controls are then evaluated, and the shape solved, once for both.

Blender often takes an undo step when an operator ends, before it evaluates, so the step lacks the move of the
partner. And undo keeps objects in memory on which two steps agree. So after undo, a leader may stand beside a
partner from another step. Which places belonged together is remembered; about leaders the steps are right.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import bpy
import numpy as np
from bpy.types import ID, Object
from mathutils import Matrix

from ... import compat
from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.memory import remember
from ...properties import SinewHandle
from ..controls import locks
from ..controls.handles import poses, riding
from ..controls.handles.sides import control_pairs, mirrored
from ..datablocks.owners import owners
from ..state import sessions
from . import schedule

_ROTATIONS = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
_MODES = (*_ROTATIONS, "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
_MOST_AGREEMENTS = 20_000  # a few megabytes; undo goes back some dozens of steps
_CARRIERS = {"CHILD_OF", "ARMATURE"}  # constraints that carry an object as a parent does


Channels = tuple[float, ...]  # the own transform of an object, see ``_channels``
Pair = tuple[SinewHandle, SinewHandle]


@dataclass
class _Edit:
    """State of both controls before the running operator, to restore on cancel."""

    leader: Channels
    partner: Channels
    operator: tuple[int, int]


@dataclass(frozen=True)
class _Agreement:
    """Places of two controls after an evaluation, and which of them led: 0, 1, or None if neither did."""

    number: int
    places: tuple[Channels, Channels]
    leader: int | None


mirrored_targets: set[str] = remember(set())  # objects with a deformer whose posing is mirrored, by name
_seen: dict[str, Channels] = remember({})  # after the last evaluation, by the name of the control
_led: dict[tuple[str, str], int] = remember({})  # which control leads in this evaluation, by pair
_agreed: dict[tuple, _Agreement] = remember({})  # the last one by pair, control and place; and by both places
_numbers = count()
_edits: dict[tuple[str, str], _Edit] = remember({})  # by the names of leader and partner
_followed: dict[str, str] = remember({})  # by the name of the partner: the leader that it has followed
_key_counts: dict[str, int] = remember({})  # how many keyframes a control had when that was last looked at
_unkeyed: dict[str, tuple[str, float]] = remember({})  # by partner: the leader that was keyed, and the frame


def note_target(obj: Object) -> None:
    """Note whether posing is mirrored for an object. Call it when its settings may have changed."""
    if obj.library is None and any(deformer.use_mirror_x for deformer in obj.sinew.deformers):
        mirrored_targets.add(obj.name)
    else:
        mirrored_targets.discard(obj.name)


def _note_targets() -> None:
    mirrored_targets.clear()
    for obj in owners():
        note_target(obj)


def _targets() -> list[Object]:
    found = [bpy.data.objects.get(name) for name in mirrored_targets]
    if None in found:  # renamed or removed
        _note_targets()
        found = [bpy.data.objects[name] for name in mirrored_targets]
    return found


def _pairs(obj: Object) -> dict[tuple[str, str], Pair]:
    """The pairs of handles whose posing is mirrored, by the names of their controls."""
    found: dict[tuple[str, str], Pair] = {}
    for deformer in obj.sinew.deformers:
        for left, right in control_pairs(deformer) if deformer.use_mirror_x else ():
            found.setdefault((left.control.name_full, right.control.name_full), (left, right))
    return found


def move_partners() -> None:
    """Let partners follow the controls that were moved since the last evaluation. Call it before the next.

    If both controls of a pair were moved, each stays where it is. What Sinew itself moves has no followers.
    """
    for obj in () if sessions.is_suspended() or schedule.is_waiting() else _targets():
        for names, pair in _pairs(obj).items():
            moved = [_is_moved(handle.control) for handle in pair]
            if moved[0] != moved[1]:
                _led[names] = moved.index(True)
                _follow(obj, *(pair if moved[0] else pair[::-1]))


def _follow(obj: Object, leader: SinewHandle, partner: SinewHandle) -> None:
    names = leader.control.name_full, partner.control.name_full
    edit, operator = _edits.get(names), _last_operator()
    if edit is None or edit.operator != operator:
        edit = _edits[names] = _Edit(_seen[names[0]], _channels(partner.control), operator)
        _edits.pop(names[::-1], None)
    if edit.leader == _channels(leader.control) and not bpy.app.background:
        _set_channels(partner.control, edit.partner)  # Esc: no operator has ended, and all is as it was
        _followed.pop(names[1], None)
        return
    try:
        _mirror(obj, leader, partner)
    except SinewError:
        return  # scaled to zero, as the status says: such a frame has no mirror image
    _followed[names[1]] = names[0]


def _last_operator() -> tuple[int, int]:
    """Changes when an operator ends that Adjust Last Operation can repeat, such as a move, but not by Esc."""
    operators = bpy.context.window_manager.operators
    return len(operators), operators[-1].as_pointer() if operators else 0


def _mirror(obj: Object, leader: SinewHandle, partner: SinewHandle) -> None:
    """Move the control of ``partner`` to the mirror image of the pose of ``leader``."""
    basis = np.array(leader.control.matrix_basis, dtype=np.float64)
    if riding.is_carried(obj, leader) and riding.is_carried(obj, partner):
        moved = riding.image_of(leader, partner, basis)
        if np.isfinite(moved).all():
            _set_basis(partner.control, Matrix(moved.tolist()))
        return
    to_rest = frames.inverse(poses.rest_of(leader), f"The control of {leader.name}")
    image = mirrored(_carrier(obj, leader.control) @ basis @ to_rest) @ poses.rest_of(partner)
    moved = frames.inverse(_carrier(obj, partner.control), partner.control.name) @ image
    if np.isfinite(moved).all():
        _set_basis(partner.control, Matrix(moved.tolist()))


def _carrier(obj: Object, control: Object) -> np.ndarray:
    """What carries a control, relative to the target, (4, 4): its place is this times its own transform."""
    parent = control.parent
    own = np.array(control.matrix_parent_inverse, dtype=np.float64)
    if any(constraint.type in _CARRIERS and not constraint.mute for constraint in control.constraints) or (
        parent is not None and control.parent_type != "OBJECT"
    ):
        depsgraph = bpy.context.view_layer.depsgraph  # of the last evaluation; this does not evaluate again
        control = control if depsgraph is None else control.evaluated_get(depsgraph)
        basis = np.array(control.matrix_basis, dtype=np.float64)
        world = np.array(control.matrix_world, dtype=np.float64) @ frames.inverse(basis, control.name)
    elif parent == obj:
        return own
    else:
        world = np.eye(4) if parent is None else np.array(parent.matrix_world, dtype=np.float64) @ own
    return frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name) @ world


def _set_basis(control: Object, basis: Matrix) -> None:
    """Set the transform of an object, except where it is locked. Turns beyond half a circle go on."""
    rotation = _rotation(control)
    before = {name: getattr(control, name)[:] for name in ("location", rotation, "scale")}
    turned = getattr(control, rotation)
    turned = turned.copy() if hasattr(turned, "make_compatible") else None
    control.matrix_basis = basis
    if turned is not None:
        new = getattr(control, rotation).copy()
        new.make_compatible(turned)
        setattr(control, rotation, new)
    locks.hold_locked(control, before)


def _rotation(control: Object) -> str:
    """The property that holds the rotation of an object."""
    return _ROTATIONS.get(control.rotation_mode, "rotation_euler")


def _channels(control: Object) -> Channels:
    """The transform of an object without parents and constraints; first the number of its rotation mode."""
    rotation = getattr(control, _rotation(control))
    return (float(_MODES.index(control.rotation_mode)), *control.location, *rotation, *control.scale)


def _set_channels(control: Object, channels: Channels) -> None:
    """Set the transform to what ``_channels`` returned, if the rotation mode is still the same."""
    if channels[0] == _MODES.index(control.rotation_mode):
        control.location, control.scale = channels[1:4], channels[-3:]
        setattr(control, _rotation(control), channels[4:-3])


def _is_moved(control: Object) -> bool:
    """Whether a control was moved. One that was never seen, or that turns in another mode now, was not."""
    before, now = _seen.get(control.name_full, ()), _channels(control)
    return before[:1] == now[:1] and before != now


def note_seen(edit: bool = False) -> None:
    """Note where the controls are. Call it after each evaluation in viewports, on the main thread.

    Unless it was an ``edit``, such as a step of a drag, no edit under way can be cancelled any more.
    """
    _seen.clear()
    if len(_agreed) > _MOST_AGREEMENTS:
        _agreed.clear()
    for obj in _targets():
        for names, pair in _pairs(obj).items():
            places = _channels(pair[0].control), _channels(pair[1].control)
            _seen.update(zip(names, places, strict=True))
            for handle in pair:
                if handle.control.name_full not in _key_counts:
                    _count_keys(handle.control)
            if edit and (names, places) not in _agreed:
                agreement = _Agreement(next(_numbers), places, _led.get(names))
                for key in (places, (0, places[0]), (1, places[1])):
                    _agreed[names, key] = agreement
    _led.clear()
    if not edit:
        _edits.clear()
        _followed.clear()


def note_keyed(is_edited: Callable[[ID], bool]) -> None:
    """Note the partners of selected controls that were given keyframes: by I, or by automatic keyframes.

    Call it before ``note_seen``, after an edit. ``is_edited`` tells of a datablock whether it was edited.
    """
    for obj in _targets():
        for names, pair in _pairs(obj).items():
            edited = [
                any(is_edited(action) for action, _curve in compat.action_curves(handle.control))
                for handle in pair
            ]
            more = [edited[side] and _count_keys(pair[side].control) for side in (0, 1)]
            for side in (0, 1):
                leader, partner = names[side], names[1 - side]
                is_led = more[side] or _followed.get(partner) == leader
                if edited[side] and is_led and not more[1 - side] and _is_selected(pair[side].control):
                    _unkeyed[partner] = leader, bpy.context.scene.frame_current_final


def _count_keys(control: Object) -> bool:
    """Count the keyframes of a control; whether they are more than when they were counted last."""
    now = sum(len(curve.keyframe_points) for _action, curve in compat.action_curves(control))
    before, _key_counts[control.name_full] = _key_counts.get(control.name_full, now), now
    return now > before


def _is_selected(control: Object) -> bool:
    return control.select_get() or control == bpy.context.view_layer.objects.active


def complete_undo() -> None:
    """After undo or redo, move partners that no longer mirror their leader."""
    _note_targets()
    for noted in (_edits, _followed, _key_counts, _unkeyed):
        noted.clear()
    for obj in _targets():
        for names, pair in _pairs(obj).items():
            places = _channels(pair[0].control), _channels(pair[1].control)
            known = [_agreed.get((names, (side, places[side]))) for side in (0, 1)]
            if (names, places) in _agreed or None in known:
                continue
            leader = max(known, key=lambda agreement: agreement.number).leader
            if leader is not None:
                _set_channels(pair[1 - leader].control, known[leader].places[1 - leader])
    note_seen()


def waits_for_keys() -> bool:
    """Whether a leader may have been keyed, and not its partner."""
    return bool(_unkeyed)


def key_partners() -> None:
    """Give partners the keyframes that the controls on the other side were given.

    This may make actions, so handlers may not call it.
    """
    frame = bpy.context.scene.frame_current_final
    for name, (leader_name, keyed_frame) in list(_unkeyed.items()):
        leader, partner = (bpy.data.objects.get(each) for each in (leader_name, name))
        if leader is None or partner is None or keyed_frame != frame:
            del _unkeyed[name]
            continue
        keys = _keys_now(leader, frame)
        for path, index in keys:
            if path == _rotation(leader) and path != _rotation(partner):
                path, index = _rotation(partner), -1
            partner.keyframe_insert(path, index=index, frame=frame, group="Object Transforms")
        if keys:
            del _unkeyed[name]


def _keys_now(control: Object, frame: float) -> list[tuple[str, int]]:
    """The channels with a keyframe at this frame, by path and index; none while one has an older value."""
    found = []
    for _action, curve in compat.action_curves(control):
        if curve.data_path not in ("location", _rotation(control), "scale"):
            continue
        values = [point.co.y for point in curve.keyframe_points if abs(point.co.x - frame) < 1e-3]
        value = getattr(control, curve.data_path)[curve.array_index]
        if any(abs(value - other) > 1e-6 * max(1.0, abs(value)) for other in values):
            return []
        found += [(curve.data_path, curve.array_index)] if values else []
    return found
