# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes, chooses and changes cages. Main thread only."""

from collections.abc import Callable
from functools import partial

import bmesh
import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix

from ...backend import Progress, automatic_cage
from ...core.errors import CageError, MeshError
from ...core.geometry import flat_outline
from ...mesh_io import read_rest
from ...properties import SinewDeformer
from ..blocks import capture, rest_frame, targets
from ..blocks.transforms import put
from ..control import kinds
from ..control.cage.kind import KIND as CAGE
from ..live import binding
from ..memory import sessions
from . import automatic, hull
from .automatic import Shape

CAGE_METHODS = kinds.methods_of(CAGE)


def cage_maker(obj: Object, deformer: SinewDeformer | None, **options) -> Callable[[Progress | None], Shape]:
    """A function that makes a cage around what enters the deformer, or would enter a new one.

    Any thread may call the function. ``options`` are those of ``backend.automatic_cage``, and ``flat`` if the
    cage of a flat shape may be flat. The cage of points without faces is made around their convex hull.
    """
    mesh = capture.mesh_after(obj, capture.position(obj, deformer))
    try:
        rest = read_rest(mesh)
    finally:
        bpy.data.meshes.remove(mesh)
    if not len(rest.points):
        raise MeshError(f"{obj.name} has no points - add some, or check the modifiers before Sinew")
    points, faces = rest.points, (rest.counts, rest.corners)
    if options.pop("flat", False):
        corners = flat_outline.around(points, options["margin"], options["faces"])
        if corners is not None:
            return partial(_flat, corners, options)
    if not len(rest.counts):
        points, faces = hull.around(points)
    return partial(_around, points, faces, options)


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
def add_cage_object(obj: Object, shape: Shape) -> Object:
    """A new mesh object of this shape in the frame of ``obj``, which it follows."""
    mesh = bpy.data.meshes.new(f"{obj.name} Cage")
    automatic.fill(mesh, shape)
    cage = bpy.data.objects.new(mesh.name, mesh)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(cage)
    follow(cage, obj)
    cage.show_in_front = True
    bpy.context.view_layer.update()
    return cage


def follow(cage: Object, obj: Object, place: Matrix | None = None) -> None:
    """Make the cage, or another control, follow the object from a ``place`` in the world, as Ctrl P does.

    Without a place it starts where the object is.

    So it stays in its place when it gets another parent, such as an armature. A child of a curve would
    follow its path, so a constraint makes the cage follow a curve.
    """
    follows, place = None, place or obj.matrix_world.copy()
    if targets.is_path(obj):
        follows = cage.constraints.new("CHILD_OF")
        follows.target = obj
    else:
        cage.parent = obj
    world = obj.matrix_world.copy()
    put(cage, place)
    sheared = np.abs(np.array(cage.matrix_basis) - np.array(place)).max() > 1e-5 * max(
        place.median_scale, 1.0
    )
    if sheared or world.determinant() == 0.0:
        put(cage, world.inverted_safe() @ place)
        return
    if follows is None:
        cage.matrix_parent_inverse = world.inverted()
    else:
        follows.inverse_matrix = world.inverted()


@sessions.suspended()
def set_rest_cage(obj: Object, deformer: SinewDeformer) -> None:
    """Let the cage rest as it is now, so that the mesh is at rest too. ``bind`` must follow."""
    rest_frame.absorb(deformer)
    CAGE.take_rest(obj, deformer)
    binding.abandon(deformer.uid)


@sessions.suspended()
def flip_cage(deformer: SinewDeformer) -> None:
    """Flip the faces of the cage, so that they point outwards. ``bind`` must follow, and takes its rest."""
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
    CAGE.forget_rest(deformer)
    bpy.context.view_layer.update()
