# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the smooth surface of a cage is: curves on it, along the edges of the cage."""

import numpy as np
from bpy.types import Mesh
from mathutils.kdtree import KDTree

from ....backend import RefinedSurface, Subdivision
from ....compat import read_creases, read_edges, read_faces
from ....core.memory import remember
from ....ids import Keys
from ....properties import SinewDeformer
from ...state import sessions

_LEVELS, _MANY = 3, 1000  # of more faces, curves are as coarse as one level makes them
_NO_CREASES = ((np.zeros((0, 2), dtype=np.int32), np.zeros(0)), (np.zeros(0, dtype=np.int32), np.zeros(0)))
# By the token of a rest: what refines the cage, and the refined vertices along each edge (edges, k).
_refined: dict[str, tuple[RefinedSurface, np.ndarray]] = remember({})
_drawn: dict[str, tuple[np.ndarray, np.ndarray]] = remember({})  # by the same: points, and their curves


def curves(deformer: SinewDeformer) -> np.ndarray | None:
    """Curves (edges, k, 3) in the frame of the target, float32, for the pose that the target shows.

    None without a cage that is smooth. The array is the same one until the pose changes. Cost, where it
    has changed: what refining a mesh like the cage takes.
    """
    session, rest = sessions.find(deformer.uid), deformer.cage_rest
    if session is None or session.bound is None or rest is None:
        return None
    points = session.poses.get("cage")
    if points is None or session.bound.factor.recipe.options.get("smooth", "off") == "off":
        return None
    token = rest[Keys.REST_TOKEN]
    if token not in _refined:
        _refined[token] = _along_edges(rest)
    surface, along = _refined[token]
    if len(points) != surface.control_count:
        return None
    if token not in _drawn or _drawn[token][0] is not points:
        _drawn[token] = points, surface.refine(points)[along]
    return _drawn[token][1]


def _along_edges(rest: Mesh) -> tuple[RefinedSurface, np.ndarray]:
    faces, edges = read_faces(rest), read_edges(rest)
    levels = _LEVELS if len(faces[0]) <= _MANY else 1
    # Points of no pattern, and faces that are only split: so each refined vertex is known by its place.
    points = np.random.default_rng(0).random((len(rest.vertices), 3))
    split = RefinedSurface(points, faces, _NO_CREASES, Subdivision(levels, "bilinear", False, "all", False))
    tree = KDTree(split.vertex_count)
    for vertex, place in enumerate(split.refine(points)):
        tree.insert(place, vertex)
    tree.balance()
    share = np.linspace(0.0, 1.0, 2**levels + 1)[:, None]
    places = points[edges[:, :1]] * (1.0 - share) + points[edges[:, 1:]] * share
    along = [[tree.find(place)[1] for place in line] for line in places]
    how = Subdivision(levels, "catmull_clark", True, "all", True)
    return RefinedSurface(points, faces, read_creases(rest), how), np.array(along)
