# SPDX-License-Identifier: GPL-3.0-or-later
"""Names a handle by the side of the target that its region lies on. Main thread only."""

import re
from itertools import chain

import numpy as np
from bpy.types import Object

from ....core.errors import ConstraintError
from ....core.sides import Side, flip
from ....properties import SinewDeformer, SinewHandle
from ...datablocks import group_users

_ENDINGS = {Side.LEFT: ".L", Side.RIGHT: ".R"}
_NUMBER = re.compile(r"^(.*)(\.\d+)$")


def side_of_points(points: np.ndarray, tolerance: float) -> Side | None:
    """The side of the target on which all these points (n, 3) lie; None if they reach the centre."""
    if (points[:, 0] > tolerance).all():
        return Side.LEFT
    return Side.RIGHT if (points[:, 0] < -tolerance).all() else None


def name_of_side(
    obj: Object, deformer: SinewDeformer, handle: SinewHandle, side: Side, taken: list[str]
) -> str:
    """The name of a handle with the ending of its side, and with a number where that name is ``taken``.

    The name of the other side may belong to a handle, its counterpart, but to no group that has no handle.
    """
    others = taken + [text for other in deformer.handles for text in (other.name, other.vertex_group)]
    groups = [group.name for group in obj.vertex_groups]
    for stem in chain((handle.name,), (f"{handle.name}.{number:03}" for number in range(1, 1000))):
        name = stem + _ENDINGS[side]
        if name not in others + groups and (flip(name) in others or flip(name) not in groups):
            return name
    raise ConstraintError(f"All names for the sides of {handle.name} are taken - rename it")


def give_name(obj: Object, handle: SinewHandle, name: str) -> None:
    """Rename a handle. Its vertex group and its control follow where they carried the old name.

    A group that carries a bone's weights for an Armature modifier keeps its name, as do bones.
    """
    old, handle.name = handle.name, name
    if handle.vertex_group == old and not _belongs_to_bone(obj, old):
        group_users.rename(obj, old, name)
    control = handle.control
    if control is not None and not handle.bone and control.library is None and not control.override_library:
        control.name = _renamed(control.name, old, name)


def _belongs_to_bone(obj: Object, group: str) -> bool:
    return any(
        modifier.type == "ARMATURE" and modifier.object is not None and group in modifier.object.data.bones
        for modifier in obj.modifiers
    )


def _renamed(text: str, old: str, new: str) -> str:
    """``text`` with ``new`` in place of its last words ``old``. A number that Blender added stays behind."""
    numbered = _NUMBER.match(text)
    for stem, number in ((text, ""), *([numbered.groups()] if numbered else [])):
        if stem == old or stem.endswith(f" {old}"):
            return stem.removesuffix(old) + new + number
    return text
