# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror images of vertices across the object's local X, and weights by them."""

import numpy as np
from bpy.types import Object, VertexGroup
from mathutils.kdtree import KDTree

from ....compat import read_positions
from ....core.sides import Side
from ....mesh_io import group_weights


def images(points: np.ndarray, tolerance: float, of: np.ndarray | None = None) -> np.ndarray:
    """The vertex at the mirror image of each vertex in ``of`` (indices; all by default), -1 for none.

    ``points`` (n, 3), ``tolerance`` in their units. A vertex on the centre is its own image.
    """
    tree = KDTree(len(points))
    for index, point in enumerate(points.tolist()):
        tree.insert(point, index)
    tree.balance()
    asked = points if of is None else points[of]
    found = np.full(len(asked), -1)
    for row, (x, y, z) in enumerate(asked.tolist()):
        _place, index, distance = tree.find((-x, y, z))
        if index is not None and distance <= tolerance:
            found[row] = index
    centre = np.arange(len(points)) if of is None else of
    on_plane = 2.0 * np.abs(asked[:, 0]) <= tolerance  # a seam there has several vertices in one place
    return np.where(on_plane & (found >= 0), centre, found)


class MirrorPlane:
    """The base mesh of an object, with the mirror image of each of its vertices."""

    def __init__(self, obj: Object, tolerance: float) -> None:
        self.points = read_positions(obj.data).astype(np.float64)
        self.images = images(self.points, tolerance)
        self.paired = self.images >= 0
        self.centre = self.images == np.arange(len(self.points))
        self._names = [group.name for group in obj.vertex_groups]
        self._obj = obj

    def weights(self, name: str) -> np.ndarray:
        """Weights (n,) of a group, 0 where there is no such group."""
        found = group_weights(self._obj.data, self._names, {name})
        return found.get(name, np.zeros(len(self.points), dtype=np.float32))

    def copy_across(self, source: str, target: VertexGroup, strength: float) -> int:
        """Give ``target`` the mirror image of ``source``; vertices without an image keep what they have.

        Vertices on the centre that the source holds exactly (its weights times ``strength``) stay its own:
        how many.
        """
        weights = self.weights(source)
        mirrored = weights[self.images]
        kept = self.centre & (weights.astype(np.float64) * strength >= 1.0)
        mirrored[kept] = 0.0
        _write(target, mirrored, self.paired & ~(self.centre & (weights == 0.0)))
        return int(kept.sum())

    def even_out(self, group: VertexGroup, source: Side) -> None:
        """Give the half of the group across from ``source`` the mirror image of the other."""
        across = self.points[:, 0] < 0.0 if source is Side.LEFT else self.points[:, 0] > 0.0
        weights = self.weights(group.name)
        _write(group, weights[self.images], across & self.paired)


def _write(group: VertexGroup, weights: np.ndarray, where: np.ndarray) -> None:
    """Replace weights (n,) where asked; 0 means not in the group."""
    absent = np.flatnonzero(where & (weights <= 0.0))
    if len(absent):
        group.remove(absent.tolist())
    present = np.flatnonzero(where & (weights > 0.0))
    if len(present) == 0:
        return
    order = np.argsort(weights[present], kind="stable")
    values, starts = np.unique(weights[present][order], return_index=True)
    for value, members in zip(values, np.split(present[order], starts[1:]), strict=True):
        group.add(members.tolist(), float(value), "REPLACE")
