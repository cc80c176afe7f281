# SPDX-License-Identifier: GPL-3.0-or-later
"""Locked channels of a control: what moves it leaves them as they were, as Blender's own tools do."""

from collections.abc import Mapping, Sequence

from bpy.types import Object, PoseBone
from mathutils import Quaternion, Vector


def hold_locked(mover: Object | PoseBone, before: Mapping[str, Sequence[float]]) -> None:
    """Give locked channels the values that they had ``before``, by the names of the properties.

    Quaternions and axis angles are locked by number where the control says so, else as Euler angles XYZ.
    """
    for name, locks in (("location", mover.lock_location), ("scale", mover.lock_scale)):
        _hold(mover, name, before[name], locks)
    mode, locks = mover.rotation_mode, tuple(mover.lock_rotation)
    if mode not in ("QUATERNION", "AXIS_ANGLE"):
        _hold(mover, "rotation_euler", before["rotation_euler"], locks)
        return
    name = f"rotation_{mode.lower()}"
    if mover.lock_rotations_4d or all(locks):
        first = mover.lock_rotation_w if mover.lock_rotations_4d else True
        _hold(mover, name, before[name], (first, *locks))
    elif any(locks):
        was, now = _turn(before[name], mode), _turn(getattr(mover, name), mode)
        angles = now.to_euler()
        for axis, is_locked in enumerate(locks):
            if is_locked:
                angles[axis] = was.to_euler()[axis]
        turn = angles.to_quaternion()
        if mode == "AXIS_ANGLE":
            axis, angle = turn.to_axis_angle()
            mover.rotation_axis_angle = (angle, *axis)
        else:
            turn.make_compatible(now)
            mover.rotation_quaternion = turn


def _hold(mover: Object | PoseBone, name: str, before: Sequence[float], locks: Sequence[bool]) -> None:
    values = getattr(mover, name)
    for channel, is_locked in enumerate(locks):
        if is_locked:
            values[channel] = before[channel]


def _turn(values: Sequence[float], mode: str) -> Quaternion:
    """A rotation by its channels."""
    return Quaternion(values) if mode == "QUATERNION" else Quaternion(Vector(values[1:]), values[0])
