# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows Apply Location, Rotation and Scale, and Set Origin: the pose stays where it is in the world.

They change the mesh and the frame of its object at once, so that the mesh itself stays in its place. By that
they are recognised, by hand or by a script: some points of the mesh have moved in object space, and not in
the world. Then the rest takes part in the change. All other edits of the mesh come on top of the pose. One
that moves the mesh as a whole, as Geometry to Origin does, leaves the controls behind, which the panel says;
in Edit Mode, everybody sees what they move.
"""

from typing import NamedTuple

import numpy as np
from bpy.types import Object
from mathutils import Matrix

from ...compat import read_positions, write_positions
from ...core import status
from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.labels import label_of
from ...core.memory import remember
from ...core.status import Level, Status
from ...ids import Keys
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks import rest_frame
from ..datablocks.shapes import shapes
from ..state import sessions
from ..state.sessions import LastUpdate
from ..targets import targets

_SAMPLE = 64  # points that are compared
_ROUNDING = 4e-6  # some roundings of float32, relative to the coordinates
_VISIBLE = 1e-3  # relative to the size of the shape
_EVEN = 1e-4  # a scale that differs by less than this share of it is the same along all axes
_MOST = 1000  # meshes that undo can go back to
_STRAYED = (
    "The mesh was moved in its object, away from its controls - undo it, or move these to their places, then "
    "Unbind and Bind"
)


class _Followed(NamedTuple):
    """A shape that has followed, float32 (n, 3), and what of it was applied, in words."""

    shape: np.ndarray
    applied: str


Expected = dict[str, _Followed | None]  # by the key of the deformer

_samples: dict[str, np.ndarray] = remember({})  # by object, in its last update
_in_edit_mode: set[str] = remember(set())  # the objects that were in it in their last update
_frames: dict[tuple, np.ndarray] = remember({})  # of the rest of a deformer, by what its mesh was then


def follow(obj: Object, evaluated: Object, last: LastUpdate | None) -> Expected:
    """Let the rest of an object follow if Apply has changed it, after its mesh was edited.

    Returns the shapes that stay where they were in the world; None where the mesh was moved as a whole, and
    its controls were not.
    Without a ``last`` update the mesh may be that of another step of undo. Blender stores such a step before
    the rest has followed, so the frame of the rest is what it was when this mesh was here before.
    """
    sample = targets.sample(obj, _SAMPLE)
    before, _samples[obj.name_full] = _samples.get(obj.name_full), sample
    by_hand = obj.name_full in _in_edit_mode or obj.mode == "EDIT"
    _in_edit_mode.discard(obj.name_full)
    if obj.mode == "EDIT":
        _in_edit_mode.add(obj.name_full)
    by = None
    strayed = False
    if last is not None and before is not None and _has_moved(before, sample):
        strayed = (
            not by_hand and last.world == evaluated.matrix_world and _is_moved_as_a_whole(before, sample)
        )
        by = _change(last.world, evaluated.matrix_world, before, sample)
    if len(_frames) > _MOST:
        _frames.clear()
    expected: Expected = {}
    if strayed:
        expected.update({deformer.uid: None for deformer in obj.sinew.deformers if deformer.is_bound})
    for index, deformer in enumerate(obj.sinew.deformers):
        rest = deformer.rest_in("VIEWPORT")
        token = "" if rest is None else str(rest.get(Keys.REST_TOKEN))
        key = (deformer.uid, token, hash(sample.tobytes()))
        try:
            frame = rest_frame.matrix(deformer)
            moved = by is not None
            if by is not None:
                shown = _transform_rest(deformer, by)
                if rest is not None and _may_renumber(by, len(rest.vertices), obj):
                    sessions.note_count(obj.name)
                elif shown is not None:
                    expected[deformer.uid] = _Followed(shown, _in_words(by))
            elif last is None and not np.array_equal(_frames.get(key, frame), frame):
                moved = True
                _transform_rest(deformer, _frames[key] @ np.linalg.inv(frame))
            _frames[key] = rest_frame.matrix(deformer)
        except SinewError:
            continue  # the bind shows it
        if moved and index < len(evaluated.sinew.deformers):
            _copy(deformer, evaluated.sinew.deformers[index])
    return expected


def _has_moved(before: np.ndarray, after: np.ndarray) -> bool:
    return before.shape == after.shape and len(after) > 0 and not np.array_equal(before, after)


def _is_moved_as_a_whole(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether one affine map moves all points. Of so few points that any edit is one, none is."""
    if not (np.isfinite(before).all() and np.isfinite(after).all()):
        return False
    rows = np.column_stack((before - before.mean(axis=0), np.ones(len(before)))).astype(np.float64)
    found, _residuals, rank, _values = np.linalg.lstsq(rows, after.astype(np.float64), rcond=1e-6)
    off, largest = (float(np.abs(one).max()) for one in (rows @ found - after, (before, after)))
    return bool(rank < len(before)) and off <= _ROUNDING * largest


def _change(old: Matrix, new: Matrix, before: np.ndarray, after: np.ndarray) -> np.ndarray | None:
    """The affine map (4, 4) that Apply has moved the points by; None if it was no Apply.

    The points ``before`` were in the frame ``old``, and are ``after`` in the frame ``new``.
    """
    was, now = (np.array(matrix.copy(), dtype=np.float64) for matrix in (old, new))
    if np.array_equal(was, now):
        return None
    before, after = before.astype(np.float64), after.astype(np.float64)
    moved = np.abs(frames.transformed(now, after) - frames.transformed(was, before)).max()
    largest = max(
        (np.abs(points) @ np.abs(frame[:3, :3]).T + np.abs(frame[:3, 3])).max()
        for frame, points in ((was, before), (now, after))
    )
    if not moved <= _ROUNDING * largest:
        return None
    try:
        by = frames.inverse(now, "The mesh object") @ was
    except SinewError:
        return None
    return _refined(by, before, after)


def _refined(by: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The map next to ``by`` that moves the points exactly: far from the origin, frames are rounded more."""
    moved = frames.transformed(by, before)
    centre = moved.mean(axis=0)
    rows = np.column_stack((moved - centre, np.ones(len(moved))))
    correction = np.eye(4)
    found = np.linalg.lstsq(rows, after - moved, rcond=1e-6)[0]
    correction[:3, :3] += found[:3].T
    correction[:3, 3] = found[3] - found[:3].T @ centre
    return correction @ by


def _may_renumber(by: np.ndarray, entering: int, obj: Object) -> bool:
    """Whether modifiers may number so many vertices anew: Blender 5.2 turns faces that are mirrored."""
    return bool(np.linalg.det(by[:3, :3]) < 0.0) and entering != targets.vertex_count(obj)


def _in_words(by: np.ndarray) -> str:
    """What the affine map (4, 4) that Apply has moved the points by has changed of a shape."""
    scales = np.linalg.svd(by[:3, :3], compute_uv=False)
    if scales[0] - scales[-1] > _EVEN * scales[0]:
        return "proportions that were"
    return "mirroring that was" if np.linalg.det(by[:3, :3]) < 0.0 else "transform that was"


def _transform_rest(deformer: SinewDeformer, by: np.ndarray) -> np.ndarray | None:
    """Change the frame of the rest, of the last poses and of the shape that is shown, which is returned.

    That is float32 (n, 3), or None if the rest shape is shown.
    """
    session = sessions.open_session(deformer.uid)
    with session.lock:
        rest_frame.move(deformer, by)
        for kind in kinds.every_kind():
            kind.transform_rest(deformer, by, session.poses)
        for mode in ("RENDER", "VIEWPORT"):
            shapes.session_of(deformer, mode).shown.clear()
        _move_shape(deformer.shape("RENDER"), by)
        return _move_shape(deformer.shape("VIEWPORT"), by)


def _move_shape(shape: Object | None, by: np.ndarray) -> np.ndarray | None:
    """Move what a shape object shows, float32 (n, 3); None if that is the rest shape."""
    if shape is None or shapes.is_linked(shape):
        return None
    held = read_positions(shape.data)
    factor, displacement = held[-1, :2]
    if not factor > 0.0:
        return None
    held[:-1] = held[:-1] @ by[:3, :3].T
    if displacement < 0.5:
        held[:-1] += by[:3, 3]
    write_positions(shape.data, held)
    return held[:-1]


def _copy(deformer: SinewDeformer, evaluated: SinewDeformer) -> None:
    """Change the copy of the settings that this evaluation has been given."""
    for owner, copy, name in (
        (deformer, evaluated, "applied"),
        *((handle, copy, "rest_matrix") for handle, copy in zip(deformer.handles, evaluated.handles)),
    ):
        setattr(copy, name, np.array(getattr(owner, name)).ravel(order="F").tolist())
    evaluated.has_applied = deformer.has_applied


def report(obj: Object, evaluated: Object, expected: Expected) -> None:
    """Tell in the panel where the mesh has left its controls.

    And where a method gives another shape now, as it may after an uneven scale: by how much in the world.
    """
    to_world = np.array(evaluated.matrix_world, dtype=np.float64)[:3, :3].T
    for deformer in obj.sinew.deformers:
        wanted, session = expected.get(deformer.uid), sessions.find(deformer.uid)
        if wanted is None and deformer.uid in expected:
            if status.current(deformer.uid).level is not Level.ERROR:
                status.put(deformer.uid, Status(Level.WARNING, _STRAYED))
            continue
        found = None if session is None else session.view("VIEWPORT").positions
        if wanted is None or found is None or found.shape != wanted.shape.shape:
            continue
        off = float(np.linalg.norm((found - wanted.shape) @ to_world, axis=1).max())
        if off > _VISIBLE * float(np.ptp(wanted.shape @ to_world, axis=0).max()):
            text = (
                f"The pose changed by up to {off:.3g}, as {label_of(deformer.definition)} depends on the "
                f"{wanted.applied} applied - undo it, or go on with this shape"
            )
            status.put(deformer.uid, Status(Level.WARNING, text))
