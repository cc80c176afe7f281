# SPDX-License-Identifier: GPL-3.0-or-later
"""Which side of the target a handle is on, by its name; which handle is its counterpart; and mirror images.

With S the reflection across the target's local X, the mirror image of a frame or pose M is S M S: a rigid
motion again, and the one Blender's Paste Pose Flipped gives bones.
"""

import numpy as np

from ....core.sides import Side, flip, side_of
from ....properties import SinewDeformer, SinewHandle

_REFLECTION = np.diag((-1.0, 1.0, 1.0, 1.0))


def mirrored(matrix: np.ndarray) -> np.ndarray:
    """The mirror image of a frame or pose (4, 4) of the target's object space."""
    return _REFLECTION @ matrix @ _REFLECTION


def sided_name(handle: SinewHandle) -> str:
    """The name that tells the side: that of the handle, or else of its group; empty on the centre."""
    return next((name for name in (handle.name, handle.vertex_group) if flip(name)), "")


def side_of_handle(handle: SinewHandle) -> Side | None:
    """The side of a handle; None on the centre."""
    return side_of(sided_name(handle))


def counterpart(deformer: SinewDeformer, source: SinewHandle) -> SinewHandle | None:
    """The handle of the other side, found by its name or else by the name of its group."""
    for name in ("name", "vertex_group"):
        wanted = flip(getattr(source, name))
        for handle in deformer.handles:
            if wanted and getattr(handle, name) == wanted:
                return handle
    return None


def control_pairs(deformer: SinewDeformer) -> list[tuple[SinewHandle, SinewHandle]]:
    """The left and the right handle of each pair whose controls are two objects with a rest frame each.

    The names of the handles tell the side, or else those of their groups, or else those of the controls.
    """
    movable = [
        handle
        for handle in deformer.handles
        if handle.kind == "HANDLE" and handle.control is not None and not handle.bone and handle.has_rest
    ]
    found: list[tuple[SinewHandle, SinewHandle]] = []
    paired: set[str] = set()
    for name_of in (_name, _group, _control):
        by_name = {name_of(handle): handle for handle in movable if handle.uid not in paired}
        for name, left in by_name.items():
            right = by_name.get(flip(name)) if side_of(name) is Side.LEFT else None
            if right is not None and right.control != left.control:
                found.append((left, right))
                paired |= {left.uid, right.uid}
    return found


def _name(handle: SinewHandle) -> str:
    return handle.name


def _group(handle: SinewHandle) -> str:
    return handle.vertex_group


def _control(handle: SinewHandle) -> str:
    return handle.control.name
