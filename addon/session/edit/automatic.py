# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of an automatic cage, which remembers how it was made, so that its faces can be changed.

Main thread only.
"""

import hashlib

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...core.errors import CageError
from ...core.geometry import frames
from ...ids import Keys
from ...properties import SinewDeformer, deformers_of
from ..blocks import libraries, rest_frame
from ..control.cage.kind import KIND as CAGE
from ..memory import sessions

# Points (c, 3), corners per face, vertex of each corner, the options, and what else there is to say.
Shape = tuple[np.ndarray, np.ndarray, np.ndarray, dict, str]

_UNPOSED = 1e-5  # of the size of the cage; coordinates are stored in single precision


def fill(mesh: Mesh, shape: Shape) -> None:
    """Give the mesh this shape. It remembers the options."""
    points, counts, corners, options, _more = shape
    faces = [face.tolist() for face in np.split(corners, np.cumsum(counts)[:-1])]
    mesh.clear_geometry()
    mesh.from_pydata(points.tolist(), [], faces)
    mesh[Keys.CAGE_ORIGIN] = {**options, "print": _print(mesh)}


def is_automatic(cage: Object) -> bool:
    """Whether Add Cage made this cage, by its mark."""
    return cage.type == "MESH" and cage.data is not None and Keys.CAGE_ORIGIN in cage.data


def face_count(cage: Object) -> int:
    """How many triangles the faces of the cage are; those that were asked for if it is flat."""
    if is_automatic(cage) and cage.data[Keys.CAGE_ORIGIN].get("flat", False):
        return int(cage.data[Keys.CAGE_ORIGIN]["faces"])
    return sum(len(face.vertices) - 2 for face in cage.data.polygons)


def check_cage(obj: Object, deformer: SinewDeformer) -> dict:
    """The options that the cage was made with. Raises a ``CageError`` if its faces cannot be changed."""
    cage = deformer.cage
    if libraries.is_lost(cage):
        raise CageError(libraries.explain(cage))
    if not is_automatic(cage):
        raise CageError(f"{cage.name} was not made by Add Cage - remesh or decimate it, then Set Rest Cage")
    mesh = cage.data
    if cage.library is not None or mesh.library is not None or mesh.users > 1:
        raise CageError(f"{cage.name} shares its mesh - make it single-user and local first")
    if cage.mode == "EDIT":
        raise CageError(f"{cage.name} is in Edit Mode - leave it first")
    options = mesh[Keys.CAGE_ORIGIN].to_dict()
    if options.pop("print") != _print(mesh) or mesh.shape_keys is not None or len(cage.vertex_groups):
        raise CageError(
            f"{cage.name} was edited, and that would be lost - its faces can be changed as long as it is "
            "as Add Cage made it"
        )
    others = [
        other.name
        for other in bpy.data.objects
        for row in deformers_of(other)
        if row.cage == cage and row.uid != deformer.uid
    ]
    if others:
        raise CageError(f"{cage.name} moves {others[0]} as well - give that another cage first")
    if deformer.is_bound and not _is_unposed(obj, deformer):
        raise CageError(f"{cage.name} is posed, and the pose would be lost - move it back, or Set Rest Cage")
    return {**options, "quads": bool(options["quads"]), "flat": bool(options.get("flat", False))}


@sessions.suspended()
def change_cage(obj: Object, deformer: SinewDeformer, shape: Shape) -> None:
    """Give the cage another shape around the mesh. ``bind`` must follow, and takes it as the rest."""
    cage = deformer.cage
    inverse = frames.inverse(np.array(cage.matrix_world, dtype=np.float64), cage.name)
    points = shape[0]
    placed = frames.transformed(inverse @ np.array(obj.matrix_world, dtype=np.float64), points)
    if not _are_alike(placed, points):  # else the rounding would spoil the symmetry
        points = placed
    fill(cage.data, (points, *shape[1:]))
    CAGE.forget_rest(deformer)
    bpy.context.view_layer.update()


def _is_unposed(obj: Object, deformer: SinewDeformer) -> bool:
    """Whether the cage is where it rests."""
    if not isinstance(deformer.cage_rest, Mesh):
        return True
    place = CAGE.place(deformer, bpy.context.evaluated_depsgraph_get())
    rest = rest_frame.read(deformer, deformer.cage_rest).points
    if place is None or len(place.vertices) != len(rest):
        return False
    relative = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name) @ place.matrix()
    now = frames.transformed(relative, place.vertices.astype(np.float64))
    return _are_alike(now, rest)


def _are_alike(points: np.ndarray, others: np.ndarray) -> bool:
    """Whether points (n, 3) are where the others are, but for single precision."""
    return bool(np.abs(points - others).max() <= _UNPOSED * np.ptp(others, axis=0).max())


def _print(mesh: Mesh) -> str:
    """A number of its own for these vertices and faces."""
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return hashlib.sha256(points.tobytes() + corners.tobytes()).hexdigest()
