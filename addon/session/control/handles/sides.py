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
