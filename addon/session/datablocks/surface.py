# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface that a viewport shows: what a ray meets first, and the vertex of the mesh at such a place.

The surface is the one after all modifiers, so it may have other vertices than the mesh itself. Then a copy of
the object carries the place of each vertex in the mesh through its modifiers, as an attribute.
"""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object
from mathutils import Vector

from ...compat import read_positions
from ...core.errors import MeshError, SinewError
from ...core.geometry import frames
from ..targets import targets
from ..targets.kinds import kind_of
from ..targets.modified import evaluated_mesh
from .shapes.capture import mesh_with_places

_SEE_THROUGH = ("WIRE", "BOUNDS")  # how cages, for example, are displayed
_MOST_LAYERS = 100  # of objects that are seen through
_AS_NEAR = 0.25  # of the limit: points so much farther from the line of sight count as equally near
_PAST = 1e-5  # of the distance, to go on behind what was met


@dataclass(frozen=True)
class Hit:
    """Where a ray meets the surface of ``obj``: ``place`` and ``normal`` (3,) in the world."""

    obj: Object
    place: np.ndarray
    normal: np.ndarray


def first_hit(
    depsgraph: Depsgraph, origin: np.ndarray, direction: np.ndarray, shows: Callable[[Object], bool]
) -> Hit | None:
    """The first surface on a ray of the world, of an object that ``shows``; None if there is none.

    What is displayed as wire or bounds is seen through. ``origin`` and ``direction`` are (3,).
    """
    length = float(np.linalg.norm(direction))
    if not np.isfinite((*origin, *direction)).all() or length == 0.0:
        raise SinewError("The ray has no direction, or is not finite - give three numbers for each")
    start, along = Vector(origin), Vector(direction) / length
    for _layer in range(_MOST_LAYERS):
        met, place, normal, _face, obj, matrix = depsgraph.scene.ray_cast(depsgraph, start, along)
        if not met:
            return None
        if obj.display_type not in _SEE_THROUGH and shows(obj):
            if matrix != obj.evaluated_get(depsgraph).matrix_world:
                raise SinewError(f"This is an instance of {obj.name} - drag on {obj.name} itself")
            return Hit(obj, np.array(place, dtype=np.float64), np.array(normal, dtype=np.float64))
        start = place + along * max((place - Vector(origin)).length * _PAST, 1e-6)
    return None


def nearest_point(
    depsgraph: Depsgraph,
    direction: np.ndarray,
    shows: Callable[[Object], bool],
    apart: Callable[[np.ndarray], np.ndarray],
    limit: float,
) -> Hit | None:
    """Where a curve, text, hair or a point cloud that ``shows`` is nearest; None if nothing is that near.

    ``apart`` tells how far places (n, 3) of the world are from the line of sight, (n,); at most ``limit``
    counts. Of several about as near, the first along the ``direction`` is taken. The normal of what has no
    surface points against that.
    """
    found: list[tuple[Object, np.ndarray, np.ndarray]] = []
    for obj in depsgraph.scene.objects:
        if targets.is_mesh(obj) or not targets.can_be_moved(obj) or not shows(obj):
            continue
        world = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
        places = frames.transformed(world, kind_of(obj).points_shown(obj, depsgraph).astype(np.float64))
        distances = apart(places)
        near = distances <= limit
        if near.any():
            found.append((obj, places[near], distances[near]))
    if not found:
        return None
    owners = np.repeat(np.arange(len(found)), [len(places) for _obj, places, _distances in found])
    places, distances = (np.concatenate([row[column] for row in found]) for column in (1, 2))
    as_near = distances <= distances.min() + _AS_NEAR * limit
    chosen = int(np.argmin(np.where(as_near, places @ direction, np.inf)))
    return Hit(found[owners[chosen]][0], places[chosen], -np.asarray(direction, dtype=np.float64))


def vertex_at(hit: Hit, depsgraph: Depsgraph) -> int:
    """The vertex of the mesh itself that is shown nearest to a place on the surface, on its side of it."""
    obj = hit.obj
    world = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    with evaluated_mesh(obj, depsgraph) as mesh:
        if len(mesh.vertices) == len(obj.data.vertices):
            return _nearest(mesh, world, hit)
    mesh, places = mesh_with_places(obj)
    try:
        if places is None:
            raise MeshError(
                f"The modifiers of {obj.name} make a new mesh, so no vertices of its own are at this place - "
                "switch them off in viewports, or apply them"
            )
        own = places[_nearest(mesh, world, hit)]
    finally:
        bpy.data.meshes.remove(mesh)
    return int(np.nanargmin(((read_positions(obj.data) - own) ** 2).sum(axis=1)))


def _nearest(mesh: Mesh, world: np.ndarray, hit: Hit) -> int:
    """The vertex of a mesh, shown in the frame ``world`` (4, 4), nearest to a hit, among those that face it.

    On a thin sheet the vertices of the other side may be nearer than those of the face that was met.
    """
    linear = world[:3, :3]
    distances = np.linalg.norm(read_positions(mesh) @ linear.T + (world[:3, 3] - hit.place), axis=1)
    normals = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("normal", normals)
    # Normals of the object turn by the inverse transpose, so this turns the one of the world back.
    faces = normals.reshape(-1, 3) @ (linear.T @ hit.normal) > 0.0
    distances[np.isnan(distances)] = np.inf
    return int(np.argmin(np.where(faces, distances, np.inf) if faces.any() else distances))
