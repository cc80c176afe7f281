# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the bones of an armature may turn. Angles are radians, measured from the rest of each bone.

Limit Rotation constraints in local space and the limits of inverse kinematics both count: a joint keeps
within both. Where they contradict each other, Limit Rotation wins, because Blender applies it to every pose,
whoever made it. A locked axis stays as it is.
"""

import math
from collections.abc import Iterator

import numpy as np
from bpy.types import Constraint, PoseBone
from mathutils import Quaternion, Vector

_AXES = "xyz"
_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")

Angles = tuple[np.ndarray, np.ndarray, str]  # lower and upper angles (3,), and the order of the axes


def angles_of(bone: PoseBone) -> Angles | None:
    """The limits of a joint; None if it turns freely."""
    order, lower, upper = _order(bone), np.full(3, -math.inf), np.full(3, math.inf)
    for k, axis in enumerate(_AXES):
        if getattr(bone, f"use_ik_limit_{axis}"):
            lower[k], upper[k] = getattr(bone, f"ik_min_{axis}"), getattr(bone, f"ik_max_{axis}")
    for limit in _limits(bone):
        for k, axis in enumerate(_AXES):
            if getattr(limit, f"use_limit_{axis}"):
                least, most = getattr(limit, f"min_{axis}"), getattr(limit, f"max_{axis}")
                least, most = min(least, most), max(least, most)
                if most < lower[k] or least > upper[k]:
                    lower[k], upper[k] = least, most
                else:
                    lower[k], upper[k] = max(lower[k], least), min(upper[k], most)
    locks = _locks(bone)
    if any(locks):
        now = _present_angles(bone, order)
        for k, is_locked in enumerate(locks):
            if is_locked:
                lower[k] = upper[k] = now[k]
    return (lower, upper, order) if np.isfinite((lower, upper)).any() else None


def stiffness_of(bone: PoseBone) -> float:
    """How firmly a joint stays as it is, relative to others: 1 without stiffness, 100 for the largest one."""
    most = max(bone.ik_stiffness_x, bone.ik_stiffness_y, bone.ik_stiffness_z)
    return 1.0 / (1.0 - min(float(most), 0.99))


def is_limit(constraint: Constraint) -> bool:
    """Whether a constraint limits how a bone turns against its parent."""
    return constraint.type == "LIMIT_ROTATION" and constraint.owner_space == "LOCAL" and in_use(constraint)


def in_use(constraint: Constraint) -> bool:
    """Whether Blender applies a constraint."""
    return not constraint.mute and constraint.influence > 0.0


def _limits(bone: PoseBone) -> Iterator[Constraint]:
    return (constraint for constraint in bone.constraints if is_limit(constraint))


def _locks(bone: PoseBone) -> list[bool]:
    locks = [bool(lock) for lock in bone.lock_rotation]
    if bone.rotation_mode in ("QUATERNION", "AXIS_ANGLE") and bone.lock_rotations_4d:
        any_lock = bool(bone.lock_rotation_w) or any(locks)
        locks = [any_lock] * 3  # single numbers of a quaternion say nothing about axes
    return [lock or bool(getattr(bone, f"lock_ik_{axis}")) for lock, axis in zip(locks, _AXES, strict=True)]


def _order(bone: PoseBone) -> str:
    """The order of the angles that Limit Rotation looks at, or else of those of the bone."""
    for limit in _limits(bone):
        order = getattr(limit, "euler_order", "AUTO")
        if order in _ORDERS:
            return order
    return bone.rotation_mode if bone.rotation_mode in _ORDERS else "XYZ"


def _present_angles(bone: PoseBone, order: str) -> tuple[float, ...]:
    if bone.rotation_mode == order:
        return tuple(bone.rotation_euler)
    return tuple(rotation_of(bone).to_euler(order))


def rotation_of(bone: PoseBone) -> Quaternion:
    """The rotation that the channels of a bone say."""
    if bone.rotation_mode == "QUATERNION":
        return bone.rotation_quaternion.normalized()
    if bone.rotation_mode == "AXIS_ANGLE":
        angle, *axis = bone.rotation_axis_angle
        return Quaternion(Vector(axis), angle)
    return bone.rotation_euler.to_quaternion()
