# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the objects that share handles, and tells each of them about the others. Main thread only."""

from collections.abc import Iterator

import numpy as np
from bpy.types import Mesh, Object

from ...core.errors import SinewError
from ...core.geometry import frames
from ...properties import SinewDeformer, SinewHandle
from ..controls.handles import companions
from ..controls.handles.points import are_apart
from ..controls.handles.riding import rest_of
from ..datablocks import rest_frame
from ..datablocks.owners import owners
from ..datablocks.shapes import shapes

_Handles = dict[tuple[Object, str], SinewHandle]
_SAME = 1e-6  # frames are kept that differ by less: so that a bind of one object does not bind the others


def renew(deformer: SinewDeformer) -> None:
    """Let each of the objects that share handles know the rest shapes of all, as they are now.

    They have the frame of the first one in common, with its scale.
    """
    group = {other: frame for other, frame in sharing_handles(deformer).items() if other.is_bound}
    first = next(iter(group))
    scale = _scale(first.id_data) @ frames.inverse(group[first], first.id_data.name)
    placed = {other.uid: scale @ frame @ rest_frame.matrix(other) for other, frame in group.items()}
    for target in group:
        rows = [(other.uid == target.uid, other.rest, placed[other.uid]) for other in group]
        _store(target, rows if len(rows) > 1 else [])


def _scale(obj: Object) -> np.ndarray:
    """What the matrix of an object stretches, (4, 4), without its rotation and place; an axis without length
    is left as it is.
    """
    _left, stretches, axes = np.linalg.svd(np.array(obj.matrix_world, dtype=np.float64)[:3, :3])
    found = np.eye(4)
    found[:3, :3] = axes.T @ np.diag(np.where(stretches > 0.0, stretches, 1.0)) @ axes
    return found


def _store(deformer: SinewDeformer, rows: list[tuple[bool, Mesh, np.ndarray]]) -> None:
    held = deformer.companions
    rows = [(is_target, None if is_target else rest, frame) for is_target, rest, frame in rows]
    if len(held) == len(rows) and all(
        (row.is_target, row.rest) == (is_target, rest)
        and np.allclose(companions.frame_of(row.frame), frame, rtol=0.0, atol=_SAME * np.abs(frame).max())
        for row, (is_target, rest, frame) in zip(held, rows, strict=True)
    ):
        return
    former = [row.rest for row in held]
    held.clear()
    for is_target, rest, frame in rows:
        row = held.add()
        row.is_target, row.rest, row.frame = is_target, rest, frame.ravel(order="F").tolist()
    shapes.free_meshes(*former)
    deformer.id_data.update_tag()


def sharing_handles(deformer: SinewDeformer) -> dict[SinewDeformer, np.ndarray]:
    """The deformers that share handles with this one, or with another of them; with the frames (4, 4) of
    their targets in that of this one's. All of them find the same order.
    """
    if not companions.counts(deformer):
        return {deformer: np.eye(4)}
    candidates = {other.uid: other for other in _candidates(deformer)}
    handles = {uid: _handles(other) for uid, other in candidates.items()}
    found = {deformer.uid: np.eye(4)}
    waiting = [deformer.uid]
    while waiting:
        here = waiting.pop()
        for uid, other in candidates.items():
            if uid not in found:
                frame = _frame(candidates[here], handles[here], other, handles[uid])
                if frame is not None:
                    found[uid] = found[here] @ frame
                    waiting.append(uid)
    return {candidates[uid]: found[uid] for uid in candidates if uid in found}


def _candidates(deformer: SinewDeformer) -> Iterator[SinewDeformer]:
    for obj in owners():
        for other in obj.sinew.deformers:
            if obj.library is None and other.method == deformer.method:
                yield other


def _handles(deformer: SinewDeformer) -> _Handles:
    """The handles that hold space where their controls are, by object and bone."""
    return {
        (handle.control, handle.bone): handle
        for handle in deformer.handles
        if handle.enabled and handle.kind == "HANDLE" and handle.control and not handle.vertex_group
    }


def _frame(
    deformer: SinewDeformer, own: _Handles, other: SinewDeformer, others: _Handles
) -> np.ndarray | None:
    """From the target of ``other`` to that of ``deformer`` when a control of both rested, (4, 4); or None."""
    shared = [(own[control], others[control]) for control in own if control in others]
    for here, there in shared:
        if here.has_rest and there.has_rest and not are_apart(deformer, here) and not are_apart(other, there):
            try:
                return rest_of(here) @ frames.inverse(rest_of(there), there.name)
            except SinewError:
                continue
    if not shared:
        return None
    placed = [np.array(row.id_data.matrix_world, dtype=np.float64) for row in (deformer, other)]
    return frames.inverse(placed[0], deformer.id_data.name) @ placed[1]
