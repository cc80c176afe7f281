# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes, chooses and changes cages. Main thread only."""

from collections.abc import Callable, Sequence
from functools import partial

import bmesh
import bpy
import numpy as np
from bpy.types import Object

from ....backend import Progress, automatic_cage
from ....core.errors import CageError, MeshError
from ....core.geometry import flat_outline, frames
from ....mesh_io import RestShape
from ....properties import SinewDeformer
from ...controls import kinds
from ...controls.cage.kind import KIND as CAGE
from ...state import sessions
from . import automatic, hull
from .around import Target, follow, leader, shape_of
from .automatic import Shape

CAGE_METHODS = kinds.methods_of(CAGE)


def cage_maker(around: Sequence[Target], **options) -> Callable[[Progress | None], Shape]:
    """A function that makes a cage around what enters deformers, or would enter new ones.

    The cage is in the frame of the first object. Any thread may call the function. ``options`` are those of
    ``backend.automatic_cage``, and ``flat`` if the cage of a flat shape may be flat. The cage of points
    without faces is made around their convex hull.
    """
    shapes = _in_one_frame(around)
    if not shapes:
        names = ", ".join(obj.name for obj, _deformer in around)
        raise MeshError(f"{names} has no points - add some, or check the modifiers before Sinew")
    if options.pop("flat", False):
        points = np.concatenate([shape.points for shape in shapes])
        corners = flat_outline.around(points, options["margin"], options["faces"])
        if corners is not None:
            return partial(_flat, corners, options)
    return partial(_around, *_joined(shapes), options)


def _in_one_frame(around: Sequence[Target]) -> list[RestShape]:
    """The shapes that have points, in the frame of the first object."""
    first, shapes = around[0][0], []
    for obj, deformer in around:
        shape = shape_of(obj, deformer)
        if obj != first:
            inverse = frames.inverse(np.array(first.matrix_world, dtype=np.float64), first.name)
            shape = shape.moved(inverse @ np.array(obj.matrix_world, dtype=np.float64), shape.token)
        if len(shape.points):
            shapes.append(shape)
    return shapes


def _joined(shapes: Sequence[RestShape]) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Points and faces (counts, corners) of one mesh; of a shape without faces its convex hull."""
    points, counts, corners, first = [], [], [], 0
    for shape in shapes:
        places, faces = shape.points, (shape.counts, shape.corners)
        if not len(shape.counts):
            places, faces = hull.around(places)
        points.append(places)
        counts.append(faces[0])
        corners.append(faces[1] + first)
        first += len(places)
    return np.concatenate(points), (np.concatenate(counts), np.concatenate(corners))


def takes_flat_cage(method: str) -> bool:
    """Whether the cage of a method may be flat."""
    return any(row.takes_flat for row in CAGE_METHODS if row.id == method)


def cage_seconds(margin: float) -> float:
    """About how long an automatic cage takes: its fine surface has the more faces, the smaller the margin."""
    return 2.5e-4 / margin**2


def _around(
    points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], options: dict, progress: Progress | None
) -> Shape:
    around, counts, corners, more = automatic_cage(points, faces, progress, **options)
    return around, counts, corners, options, more


def _flat(corners: np.ndarray, options: dict, _progress: Progress | None) -> Shape:
    count = len(corners)
    kept = {**options, "flat": True}
    return corners, np.array([count], np.int32), np.arange(count, dtype=np.int32), kept, ""


@sessions.suspended()
def add_cage_object(objects: Sequence[Object], shape: Shape) -> Object:
    """A new mesh object of this shape in the frame of the first object. It follows what all follow."""
    obj = objects[0]
    mesh = bpy.data.meshes.new(f"{obj.name} Cage")
    cage = bpy.data.objects.new(mesh.name, mesh)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(cage)
    follow(cage, leader(objects), obj.matrix_world.copy())
    bpy.context.view_layer.update()
    automatic.put(cage, obj, shape)
    cage.show_in_front = True
    bpy.context.view_layer.update()
    return cage


@sessions.suspended()
def flip_cage(deformer: SinewDeformer) -> list[tuple[Object, SinewDeformer]]:
    """Flip the faces of the cage, so that they point outwards.

    ``bind`` must follow, and takes the cage as the rest; also for the other deformers, returned with their
    objects, that were refused as well.
    """
    cage = deformer.cage
    if cage is None or cage.type != "MESH" or cage.data.library is not None:
        raise CageError("There is no cage here that could be flipped - make it local first")
    edit = bmesh.from_edit_mesh(cage.data) if cage.mode == "EDIT" else bmesh.new()
    if cage.mode != "EDIT":
        edit.from_mesh(cage.data)
    bmesh.ops.reverse_faces(edit, faces=edit.faces[:])
    if cage.mode == "EDIT":
        bmesh.update_edit_mesh(cage.data)
    else:
        edit.to_mesh(cage.data)
        edit.free()
    others = [
        (obj, row)
        for obj, row in automatic.moved_by(cage)
        if row.uid != deformer.uid and obj.library is None and not row.is_bound
    ]
    for row in (deformer, *(row for _obj, row in others)):
        CAGE.forget_rest(row)
    bpy.context.view_layer.update()
    return others
