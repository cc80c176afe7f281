# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds, moves and removes the keys of a deformer, which edit its handles in frames of an animation.

Main thread only.
"""

import bpy
import numpy as np
from bpy.types import Object

from ...core.errors import SinewError
from ...core.labels import label_of, names_of
from ...core.methods import METHODS
from ...properties import SinewDeformer, SinewKey
from ..controls.handles import poses
from ..state import sessions
from ..state.sessions import Asked

_LEAST = 1e-5  # what a control moves or turns less than this edits nothing; of the unit, and of a full scale


def with_keys() -> str:
    """The names of the methods that have keys."""
    return names_of(method for method in METHODS if method.keyed)


def require_keyed(deformer: SinewDeformer) -> None:
    """Refuse if the method has no keys."""
    if not deformer.definition.keyed:
        raise SinewError(f"{label_of(deformer.definition)} has no keys - choose {with_keys()}")


def add_key(obj: Object, deformer: SinewDeformer, blank: bool = False) -> SinewKey:
    """Keep how the handles are edited in the present frame, by the keys so far and by their controls.

    The controls stay where they are and edit nothing more: from there on they edit again. A ``blank`` key
    edits nothing in this frame. A key that is there already is replaced.
    """
    require_keyed(deformer)
    asked = _present(obj, deformer)
    bound, control, further, incoming = asked
    options = {"incoming": incoming, "from_rest": further["from_rest"]}
    still = bound.factor.still_poses(**options)
    edits = np.broadcast_to(poses.IDENTITY, still.shape)
    if not blank:
        edits = bound.factor.edits(control, frame=further["frame"], keys=further["keys"], **options)
    with sessions.suspended():
        key = _key_at(deformer, round(float(further["frame"])))
        _keep(key, deformer, dict(zip(bound.handles, edits, strict=True)))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        poses.rest_here(obj, deformer, dict(zip(bound.handles, still, strict=True)), depsgraph)
        obj.update_tag()
    return key


def _keep(key: SinewKey, deformer: SinewDeformer, edits: dict[str, np.ndarray]) -> None:
    """Store edits (3, 4) by the keys of the bound handles. Those of handles that are not used now stay."""
    wanted = [handle.uid for handle in deformer.handles if handle.kind == "HANDLE" and handle.uid in edits]
    there = {row.handle for row in key.edits}
    for uid in wanted:
        if uid not in there:
            key.edits.add().handle = uid
    for row in key.edits:
        if row.handle in wanted:
            row.edit = edits[row.handle].ravel().tolist()


def remove_key(obj: Object, deformer: SinewDeformer, index: int) -> None:
    """Remove a key. The handles are edited by the others."""
    deformer.keys.remove(index)
    deformer.active_key = max(0, min(deformer.active_key, len(deformer.keys) - 1))
    obj.update_tag()


def move_key(obj: Object, deformer: SinewDeformer, index: int, frame: int) -> None:
    """Move a key to another frame. A key that is there already is replaced."""
    deformer.keys[index].frame = frame
    for other in reversed(range(len(deformer.keys))):
        if other != index and deformer.keys[other].frame == frame:
            deformer.keys.remove(other)
            index -= other < index
    deformer.active_key = _in_order(deformer, index)
    obj.update_tag()


def key_beside(deformer: SinewDeformer, frame: float, step: int) -> int:
    """The index of the next key after a frame (``step`` 1), or of the last one before it (-1); -1 if none."""
    found = [(step * key.frame, index) for index, key in enumerate(deformer.keys)]
    return min(((at, index) for at, index in found if at > step * frame), default=(0, -1))[1]


def key_notes(deformer: SinewDeformer) -> tuple[str, ...]:
    """The lines below the list of keys: what edits beside them, and what is in doubt."""
    lines = []
    moved = _unkeyed(deformer)
    if moved:
        lines.append(f"{', '.join(moved)}: moved in all frames - key it, and only this frame keeps the edit")
    frames = [key.frame for key in deformer.keys]
    lines += [
        f"Two keys are at frame {frame}: the lower one counts - move or remove one"
        for frame in sorted({frame for frame in frames if frames.count(frame) > 1})
    ]
    return tuple(lines)


def _unkeyed(deformer: SinewDeformer) -> tuple[str, ...]:
    """The names of the handles whose controls edit the present frame beside the keys."""
    asked = _asked(deformer)
    if asked is None:
        return ()
    bound, control, further, incoming = asked
    still = bound.factor.still_poses(incoming=incoming, from_rest=further["from_rest"])
    moved = np.abs(control - still).max(axis=(1, 2)) > _LEAST
    names = {handle.uid: handle.name for handle in deformer.handles}
    return tuple(
        names[uid] for uid, is_moved in zip(bound.handles, moved, strict=True) if is_moved and uid in names
    )


def _asked(deformer: SinewDeformer) -> Asked | None:
    """What the last evaluation asked of the present factor, if its method has keys."""
    session = sessions.find(deformer.uid)
    asked = None if session is None else session.asked
    if asked is None or asked.bound is not session.bound or "keys" not in asked.further:
        return None
    return None if asked.bound.factor.is_released else asked


def _present(obj: Object, deformer: SinewDeformer) -> Asked:
    """What the present frame asks of the factor."""
    obj.update_tag()
    bpy.context.view_layer.update()
    if not deformer.is_bound:
        raise SinewError(f"{deformer.name} is not bound - press Bind first")
    if not deformer.live:
        raise SinewError(f"{deformer.name} is not live - switch Live on to key its edits")
    asked = _asked(deformer)
    if asked is None:
        raise SinewError(f"{deformer.name} does not follow its controls now - the panel says why")
    return asked


def _key_at(deformer: SinewDeformer, frame: int) -> SinewKey:
    """The key at a frame, the active one from now on; a new one if there is none."""
    index = next((index for index, key in enumerate(deformer.keys) if key.frame == frame), None)
    if index is None:
        deformer.keys.add().frame = frame
        index = len(deformer.keys) - 1
    deformer.active_key = _in_order(deformer, index)
    return deformer.keys[deformer.active_key]


def _in_order(deformer: SinewDeformer, index: int) -> int:
    """Sort the keys by their frames; returns where the key at ``index`` is then."""
    while index > 0 and deformer.keys[index - 1].frame > deformer.keys[index].frame:
        deformer.keys.move(index, index - 1)
        index -= 1
    while index + 1 < len(deformer.keys) and deformer.keys[index + 1].frame < deformer.keys[index].frame:
        deformer.keys.move(index, index + 1)
        index += 1
    return index
