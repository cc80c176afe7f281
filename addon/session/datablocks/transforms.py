# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts new controls into their places, with numbers that the sidebar shows as they are meant."""

from collections.abc import Iterable

from bpy.types import Object, PoseBone
from mathutils import Matrix

_NOISE = 2.5e-7  # of the largest number: two roundings in single precision


def put(obj: Object | PoseBone, basis: Matrix) -> None:
    """Give an object, or a bone, a transform of its own.

    Zeros and ones stand where rounding left something beside them: the sidebar shows -1e-9 as "-0 m".
    """
    obj.matrix_basis = basis
    size = max(map(abs, (*obj.location, *obj.scale)))
    obj.location = _without_noise(obj.location, _NOISE * size)
    obj.rotation_euler = _without_noise(obj.rotation_euler, _NOISE)
    obj.rotation_quaternion = _without_noise(obj.rotation_quaternion, _NOISE)
    obj.scale = [1.0 if abs(value - 1.0) <= _NOISE else value for value in obj.scale]


def _without_noise(values: Iterable[float], limit: float) -> list[float]:
    return [0.0 if abs(value) <= limit else value for value in values]
