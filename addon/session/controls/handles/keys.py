# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a deformer as arrays for the native module, which finds the edits between them.

What ``keywords`` and ``rows`` return depends on the settings and the frame alone.
"""

import numpy as np
from bpy.types import Depsgraph

from ....properties import SinewDeformer
from ...state.sessions import Bound

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


def turn_with_rest(deformer: SinewDeformer, bound: Bound | None, points: np.ndarray) -> None:
    """Let the edits do the same when ``points`` (n, 3) become the rest shape, from which handles turn.

    ``bound`` is the factor for the rest shape so far. Without one, nothing is known of it.
    """
    if bound is None or not deformer.keys or not bound.factor.recipe.method.keyed:
        return
    if bound.factor.is_released or points.shape != bound.rest.points.shape or not np.isfinite(points).all():
        return
    frames = bound.factor.still_poses(incoming=points.astype(np.float64), from_rest=True)
    _turn(deformer, dict(zip(bound.handles, frames[:, :, :3], strict=True)))


def transform_rest(deformer: SinewDeformer, linear: np.ndarray) -> None:
    """Take the edits along with a linear map (3, 3) of the target's object space."""
    _turn(deformer, {edit.handle: linear for key in deformer.keys for edit in key.edits})


def _turn(deformer: SinewDeformer, maps: dict[str, np.ndarray]) -> None:
    """Take the edits of handles along with linear maps (3, 3)."""
    for key in deformer.keys:
        for edit in key.edits:
            if edit.handle in maps:
                linear = maps[edit.handle]
                values = np.array(edit.edit, dtype=np.float64).reshape(3, 4)
                turned = (linear @ values[:, :3] @ np.linalg.inv(linear), linear @ values[:, 3])
                edit.edit = np.column_stack(turned).ravel().tolist()
