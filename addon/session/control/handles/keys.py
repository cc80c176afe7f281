# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a deformer as arrays for the native module, which finds the edits between them.

This only reads Blender's data. What it returns depends on the settings and the frame alone.
"""

import numpy as np
from bpy.types import Depsgraph

from ....properties import SinewDeformer
from ...memory.sessions import Bound

NUMBERS = 14  # of a row: frame, handle, and an affine map row by row


def keywords(deformer: SinewDeformer, bound: Bound, depsgraph: Depsgraph) -> dict[str, np.ndarray]:
    """What the ``solve`` of a method with keys takes beside the poses; nothing for another method.

    Keys are read from the original, as nothing animates them.
    """
    if not bound.factor.recipe.method.keyed:
        return {}
    frame = np.array(depsgraph.scene.frame_current_final)  # with fractions for motion blur
    return {"frame": frame, "keys": rows(deformer, bound.handles)}


def rows(deformer: SinewDeformer, handles: tuple[str, ...]) -> np.ndarray:
    """The edits (m, 14) of the bound ``handles``, which are the keys of these; of two at a frame, the later
    one in the list.
    """
    found: dict[tuple[int, int], np.ndarray] = {}
    numbers = {uid: row for row, uid in enumerate(handles)}
    for key in deformer.keys:
        for edit in key.edits:
            row = numbers.get(edit.handle)
            if row is not None:
                found[key.frame, row] = np.array(edit.edit, dtype=np.float64)
    if not found:
        return np.empty((0, NUMBERS))
    return np.array([(*place, *values) for place, values in sorted(found.items(), key=lambda item: item[0])])


def take_along(deformer: SinewDeformer, linear: np.ndarray) -> None:
    """Take the edits along with a linear map (3, 3) of the target's object space."""
    inverse = np.linalg.inv(linear)
    for key in deformer.keys:
        for edit in key.edits:
            values = np.array(edit.edit, dtype=np.float64).reshape(3, 4)
            turned = np.column_stack((linear @ values[:, :3] @ inverse, linear @ values[:, 3]))
            edit.edit = turned.ravel().tolist()
