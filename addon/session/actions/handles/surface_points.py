# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles without a region, at places of the surface: for methods that deform the space around them.

Such a handle rests where the surface rests at this place, and is posed as the surface is now. So a method
that meets its handles changes nothing yet. Main thread only.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from ....core.errors import ConstraintError, SinewError
from ....core.geometry import frames
from ....core.names import numbered, unique_name
from ....core.sides import Side, flip
from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer, SinewHandle
from ...controls import kinds
from ...controls.handles import poses, riding
from ...controls.handles.sides import counterpart, mirrored
from ...datablocks.shapes import capture, shapes
from ...state import sessions
from . import empties

_ENDINGS = {Side.LEFT: ".L", Side.RIGHT: ".R"}


@dataclass(frozen=True)
class _Place:
    """A place of the surface at rest, (3,) in object space, and how far it has moved by now, (3,)."""

    rest: np.ndarray
    moved: np.ndarray


@sessions.suspended()
def add_point_handles(
    obj: Object, deformer: SinewDeformer, place: np.ndarray, radius: float
) -> list[SinewHandle]:
    """A handle at a place (3,) of the world on the surface that is shown, as large as ``radius`` there.

    With Mirror, a handle on the other side comes with it, unless both would overlap. ``bind`` must
    follow.
    """
    mesh = capture.rest_mesh(obj, deformer)
    try:
        rest = read_rest(mesh)
    finally:
        bpy.data.meshes.remove(mesh)
    found = _on_surface(obj, deformer, rest, place)
    across = np.linalg.norm(np.array(obj.matrix_world, dtype=np.float64)[:3, 0])  # how long the unit of x is
    if not deformer.use_mirror_x or abs(found.rest[0]) * across <= radius:
        handles = [_add(obj, deformer, "Point", found, radius)]
    else:
        side = Side.LEFT if found.rest[0] > 0.0 else Side.RIGHT
        name = numbered("Point", [handle.name[:-2] for handle in deformer.handles]) + _ENDINGS[side]
        flipped = np.array((-1.0, 1.0, 1.0))
        image = _Place(found.rest * flipped, found.moved * flipped)
        uids = [
            _add(obj, deformer, words, at, radius).uid for words, at in ((name, found), (flip(name), image))
        ]
        handles = [next(row for row in deformer.handles if row.uid == uid) for uid in uids]
    deformer.active_handle = list(deformer.handles).index(handles[0])
    kinds.keep_evaluated(obj)
    return handles


def _add(obj: Object, deformer: SinewDeformer, name: str, place: _Place, radius: float) -> SinewHandle:
    frame, pose = np.eye(4), np.eye(4)
    frame[:3, 3], pose[:3, 3] = place.rest, place.moved
    handle = deformer.handles.add()
    handle.uid = shapes.new_key()
    handle.kind = "HANDLE"
    taken = [other.name for other in deformer.handles if other.uid != handle.uid]
    handle.named = unique_name(name, taken)  # so that the name below renames nothing
    handle.name = handle.named
    handle.colour = empties.colour(len(deformer.handles) - 1)
    control = empties.new_empty(obj, frame, pose, f"{obj.name} {handle.name}", 0.5 * radius)
    empties.own(obj, deformer, handle, control, frame)
    return handle


def _on_surface(obj: Object, deformer: SinewDeformer, rest: RestShape, place: np.ndarray) -> _Place:
    """The place of the rest shape whose deformed place is nearest to one of the world.

    Without a surface it is that place itself, which has moved as the nearest point has.
    """
    if not len(rest.points):
        raise ConstraintError(f"{obj.name} has no points - a handle needs a place on its surface")
    before, after = _shown(deformer, rest)
    world = np.array(obj.matrix_world, dtype=np.float64)
    local = (frames.inverse(world, obj.name) @ (*place, 1.0))[:3]
    if not len(rest.counts):
        nearest = int(np.argmin(np.linalg.norm(after - local, axis=1)))
        moved = after[nearest] - before[nearest]
        return _Place(local - moved, moved)
    faces = np.split(rest.corners, np.cumsum(rest.counts)[:-1])
    tree = BVHTree.FromPolygons(after.tolist(), [face.tolist() for face in faces])
    at, _normal, index, _distance = tree.find_nearest(Vector(local))
    if index is None:
        raise ConstraintError("The surface has no place there - press elsewhere")
    face = faces[index]
    weights = np.array(poly_3d_calc([Vector(after[v]) for v in face], at))
    weights = weights / weights.sum() if weights.sum() > 0.0 else np.full(len(face), 1.0 / len(face))
    return _Place(weights @ rest.points[face], weights @ (after[face] - before[face]))


def _shown(deformer: SinewDeformer, rest: RestShape) -> tuple[np.ndarray, np.ndarray]:
    """The shape before and after the deformer, as viewports show it, (n, 3) each."""
    session = sessions.find(deformer.uid)
    shown = session.view("VIEWPORT") if session else None
    if shown is None or shown.positions is None or len(shown.positions) != len(rest.points):
        return rest.points, rest.points
    before = session.bound.rest.points if shown.incoming is None else shown.incoming.astype(np.float64)
    return before, shown.positions + (before if shown.displacement else 0.0)


def move_image(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> None:
    """Put the handle of the other side where the mirror image of this handle is, if posing is mirrored."""
    other = counterpart(deformer, handle) if deformer.use_mirror_x else None
    if other is None or other.control is None or handle.control is None or handle.bone or other.bone:
        return
    try:
        if riding.is_carried(obj, handle) and riding.is_carried(obj, other):
            basis = np.array(handle.control.matrix_basis, dtype=np.float64)
            other.control.matrix_basis = empties.to_matrix(riding.image_of(handle, other, basis))
            return
        world = np.array(obj.matrix_world, dtype=np.float64)
        now = np.array(handle.control.matrix_world, dtype=np.float64)
        inverse = frames.inverse(world, obj.name)
        pose = inverse @ now @ frames.inverse(poses.rest_of(handle), handle.name)
    except SinewError:
        return  # scaled to zero: such a frame has no mirror image
    other.control.matrix_world = empties.to_matrix(world @ mirrored(pose) @ poses.rest_of(other))


def point_handle_near(deformer: SinewDeformer, place: np.ndarray, radius: float) -> SinewHandle | None:
    """The handle without a region whose control is nearest to a place (3,) of the world, within a radius."""
    near = [
        (float(np.linalg.norm(np.array(handle.control.matrix_world.translation) - place)), index)
        for index, handle in enumerate(deformer.handles)
        if handle.kind == "HANDLE"
        and not handle.vertex_group
        and handle.enabled
        and handle.control is not None
    ]
    distance, index = min(near, default=(np.inf, -1))
    return deformer.handles[index] if distance <= radius else None
