# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of an automatic cage, which remembers how it was made, so that its faces can be changed.

Main thread only.
"""

import hashlib

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ....core.errors import CageError
from ....core.geometry import frames
from ....ids import Keys
from ....properties import SinewDeformer, deformers_of
from ...controls import kinds
from ...controls.cage.kind import KIND as CAGE
from ...controls.objects import UNPOSED
from ...datablocks import libraries
from ...state import sessions

# Points (c, 3), corners per face, vertex of each corner, the options, and what else there is to say.
Shape = tuple[np.ndarray, np.ndarray, np.ndarray, dict, str]


def put(cage: Object, obj: Object, shape: Shape) -> None:
    """Give the cage this shape in the frame of ``obj``, wherever the cage is. It remembers the options."""
    points, counts, corners, options, _more = shape
    own, world = (np.array(other.matrix_world, dtype=np.float64) for other in (cage, obj))
    if not np.array_equal(own, world):
        relative = frames.inverse(own, cage.name) @ world
        placed = frames.transformed(relative, points)
        if not _are_alike(placed, points):  # else the rounding would spoil the symmetry
            points, corners = placed, frames.corners_after(relative, counts, corners)
    faces = [face.tolist() for face in np.split(corners, np.cumsum(counts)[:-1])]
    mesh = cage.data
    mesh.clear_geometry()
    mesh.from_pydata(points.tolist(), [], faces)
    for elements in (mesh.vertices, mesh.edges, mesh.polygons):  # so that a first click picks what moves
        elements.foreach_set("select", np.zeros(len(elements), dtype=bool))
    mesh[Keys.CAGE_ORIGIN] = {**options, "print": _print(mesh)}


def is_automatic(cage: Object) -> bool:
    """Whether Wrap in a Cage made this cage, by its mark."""
    return cage.type == "MESH" and cage.data is not None and Keys.CAGE_ORIGIN in cage.data


def face_count(cage: Object) -> int:
    """How many triangles the faces of the cage are; those that were asked for if it is flat."""
    if is_automatic(cage) and cage.data[Keys.CAGE_ORIGIN].get("flat", False):
        return int(cage.data[Keys.CAGE_ORIGIN]["faces"])
    return sum(len(face.vertices) - 2 for face in cage.data.polygons)


def moved_by(cage: Object) -> list[tuple[Object, SinewDeformer]]:
    """The deformers that this cage moves, with their objects."""
    return [
        (obj, row)
        for obj in bpy.data.objects
        for row in deformers_of(obj)
        if row.cage == cage and kinds.kind_in_use(row) is CAGE
    ]


def check_cage(deformer: SinewDeformer) -> dict:
    """The options that the cage was made with. Raises a ``CageError`` if its faces cannot be changed."""
    cage = deformer.cage
    if libraries.is_lost(cage):
        raise CageError(libraries.explain(cage))
    if not is_automatic(cage):
        raise CageError(f"{cage.name} was not made by Wrap in a Cage - remesh or decimate it, then New Rest")
    mesh = cage.data
    if cage.library is not None or mesh.library is not None or mesh.users > 1:
        raise CageError(f"{cage.name} shares its mesh - make it single-user and local first")
    if cage.mode == "EDIT":
        raise CageError(f"{cage.name} is in Edit Mode - leave it first")
    options = mesh[Keys.CAGE_ORIGIN].to_dict()
    if options.pop("print") != _print(mesh) or mesh.shape_keys is not None or len(cage.vertex_groups):
        raise CageError(
            f"{cage.name} was edited, and that would be lost - its faces can be changed as long as it is "
            "as Wrap in a Cage made it"
        )
    for obj, row in moved_by(cage):
        if obj.library is not None or obj.name not in bpy.context.scene.objects:
            raise CageError(
                f"{cage.name} moves {obj.name} as well, which is linked or in another scene - give that "
                "another cage first"
            )
        if row.bake.is_baked:
            raise CageError(f"{row.name} of {obj.name} is baked - Unbake it first")
        if row.is_bound and CAGE.not_at_rest(obj, row, bpy.context.evaluated_depsgraph_get()):
            raise CageError(
                f"{cage.name} is posed, and the pose of {obj.name} would be lost - move it back, or "
                "press New Rest"
            )
    return {**options, "quads": bool(options["quads"]), "flat": bool(options.get("flat", False))}


@sessions.suspended()
def change_cage(obj: Object, deformer: SinewDeformer, shape: Shape) -> None:
    """Give the cage another shape, in the frame of the mesh. ``bind`` must follow, and takes it as the rest.

    So it must for each deformer that has this cage.
    """
    put(deformer.cage, obj, shape)
    for _obj, row in moved_by(deformer.cage):
        CAGE.forget_rest(row)
    bpy.context.view_layer.update()


def _are_alike(points: np.ndarray, others: np.ndarray) -> bool:
    """Whether points (n, 3) are where the others are, but for single precision."""
    return bool(np.abs(points - others).max() <= UNPOSED * np.ptp(others, axis=0).max())


def _print(mesh: Mesh) -> str:
    """A number of its own for these vertices and faces."""
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return hashlib.sha256(points.tobytes() + corners.tobytes()).hexdigest()
