# SPDX-License-Identifier: GPL-3.0-or-later
"""The loose parts of a mesh, how large they are, and which of them lie inside of others."""

import itertools

import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...backend import connected_parts
from ...compat import read_faces, read_positions
from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.geometry.reach import triangulated
from ...core.memory import remember
from ...mesh_io import RestShape
from ..targets import targets
from ..targets.modified import evaluated_mesh

_HIDDEN = (
    0.66  # of all directions from a part in a cavity: from eyes in open sockets .76, from half sunk balls .58
)
_LONGEST = 0.5  # of what hides it: what is longer is worn
_LOOKS = 24  # vertices from which a part looks around
_MOST = 100  # parts that look around, the largest ones: no mouth has more, but a head of hair has
_DIRECTIONS = [Vector(way).normalized() for way in itertools.product((-1, 0, 1), repeat=3) if any(way)]

_last: dict[tuple, "ShownParts"] = remember({})  # those that were asked for last
_last_inside: dict[tuple[str, bytes], np.ndarray] = remember({})


class Parts:
    """The parts of points (n, 3) that faces connect: counts (m,) and corners.

    ``labels`` (n,) tells the part of each vertex, ``firsts`` (k,) the first vertex of each part, and
    ``sides`` (k, 3) how long it is along each axis.
    """

    def __init__(self, points: np.ndarray, faces: tuple[np.ndarray, np.ndarray]) -> None:
        _names, self.labels = np.unique(connected_parts(len(points), faces), return_inverse=True)
        order = np.argsort(self.labels, kind="stable")
        starts = np.flatnonzero(np.diff(self.labels[order], prepend=-1))
        low, high = (side.reduceat(points[order], starts) for side in (np.minimum, np.maximum))
        self.firsts, self.sides = order[starts], high - low


class ShownParts:
    """How large the parts of an object are, as it is shown. One that has no parts, or an odd mesh, is one."""

    def __init__(self, obj: Object, depsgraph: Depsgraph) -> None:
        self._whole = max(obj.dimensions) or 1.0
        self._points, self._sizes = np.zeros((0, 3)), np.zeros(0)
        if not targets.is_mesh(obj):
            return
        with evaluated_mesh(obj, depsgraph) as mesh:
            points, faces = read_positions(mesh).astype(np.float64), read_faces(mesh)
        if not len(points):
            return
        world = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
        try:
            parts = Parts(points, faces)
        except SinewError:
            return
        longest = (parts.sides * np.linalg.norm(world[:3, :3], axis=0)).max(axis=1)
        self._points, self._sizes = frames.transformed(world, points), longest[parts.labels]

    def size_at(self, place: np.ndarray) -> float:
        """The longest side of the part that is nearest to a place (3,) of the world."""
        sized = np.isfinite(self._sizes) & (self._sizes > 0.0)
        if not sized.any():
            return self._whole
        away = ((self._points - place) ** 2).sum(axis=1)
        return float(self._sizes[np.argmin(np.where(sized, away, np.inf))])


def shown_parts(obj: Object, depsgraph: Depsgraph) -> ShownParts:
    """The parts of an object, remembered as long as it is where it was, has its size and its vertices."""
    world = tuple(map(tuple, obj.matrix_world))
    key = (obj.name_full, targets.size(obj), tuple(obj.dimensions), world)
    if key not in _last:
        _last.clear()
        _last[key] = ShownParts(obj, depsgraph)
    return _last[key]


def inside(rest: RestShape, riding: np.ndarray) -> np.ndarray:
    """The vertices of those parts among ``riding`` ones (k,) that lie in a cavity of the others, as eyes and
    teeth do: small parts from which the others hide most directions. Remembered for what was asked last.
    """
    key = (rest.token, riding.tobytes())
    if key not in _last_inside:
        _last_inside.clear()
        _last_inside[key] = _inside(rest, riding)
    return _last_inside[key]


def _inside(rest: RestShape, riding: np.ndarray) -> np.ndarray:
    labels = connected_parts(len(rest.points), (rest.counts, rest.corners))
    rides = np.zeros(len(rest.points), dtype=bool)
    rides[riding] = True
    triangles = triangulated(rest.counts, rest.corners)
    hiding = triangles[~rides[triangles[:, 0]]]
    tree = BVHTree.FromPolygons(rest.points.tolist(), hiding.tolist(), all_triangles=True)
    in_order = riding[np.argsort(labels[riding], kind="stable")]
    parts = np.split(in_order, np.flatnonzero(np.diff(labels[in_order])) + 1)
    longest = _LONGEST * np.ptp(rest.points[~rides], axis=0).max(initial=0.0)
    solid = [part for part in parts if len(part) > 3 and np.ptp(rest.points[part], axis=0).max() < longest]
    solid.sort(key=len, reverse=True)
    found = [part for part in solid[:_MOST] if _is_hidden(rest.points[part], tree)]
    return np.sort(np.concatenate(found)) if found else np.zeros(0, dtype=int)


def _is_hidden(points: np.ndarray, tree: BVHTree) -> bool:
    """Whether a tree hides most directions from some points (n, 3)."""
    chosen = _spread(points)
    origins = [Vector(origin) for origin in chosen + 0.05 * (points.mean(axis=0) - chosen)]
    hits = sum(tree.ray_cast(at, way)[0] is not None for at in origins for way in _DIRECTIONS)
    return hits > _HIDDEN * len(origins) * len(_DIRECTIONS)


def _spread(points: np.ndarray) -> np.ndarray:
    """Some of the points, each the farthest from those before: however densely a part is divided."""
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    chosen: list[int] = []
    while len(chosen) < min(_LOOKS, len(points)):
        chosen.append(int(away.argmax()))
        beside = np.linalg.norm(points - points[chosen[-1]], axis=1)
        away = beside if len(chosen) == 1 else np.minimum(away, beside)
    return points[chosen]
