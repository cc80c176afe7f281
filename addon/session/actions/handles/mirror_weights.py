# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror images of vertices across the local X of an object, and mirrored weights."""

import numpy as np
from bpy.types import Object, VertexGroup
from mathutils.kdtree import KDTree

from ....compat import read_positions
from ....core.sides import Side
from ....mesh_io import group_weights


def images(points: np.ndarray, tolerance: float, chosen: np.ndarray | None = None) -> np.ndarray:
    """The vertex at the mirror image of each vertex in ``chosen`` (indices; all by default), -1 for none.

    ``points`` are (n, 3), with ``tolerance`` in their units. A vertex on the centre is its own image.
    """
    tree = KDTree(len(points))
    for index, point in enumerate(points.tolist()):
        tree.insert(point, index)
    tree.balance()
    asked = points if chosen is None else points[chosen]
    found = np.full(len(asked), -1)
    for row, (x, y, z) in enumerate(asked.tolist()):
        _place, index, distance = tree.find((-x, y, z))
        if index is not None and distance <= tolerance:
            found[row] = index
    centre = np.arange(len(points)) if chosen is None else chosen
    on_plane = 2.0 * np.abs(asked[:, 0]) <= tolerance  # a seam there has several vertices in one place
    return np.where(on_plane & (found >= 0), centre, found)


class MirrorPlane:
    """The base mesh of an object, and the mirror image of each of its vertices."""

    def __init__(self, obj: Object, tolerance: float) -> None:
        self.points = read_positions(obj.data).astype(np.float64)
        self.images = images(self.points, tolerance)
        self.paired = self.images >= 0
        self.centre = self.images == np.arange(len(self.points))
        self._names = [group.name for group in obj.vertex_groups]
        self._obj = obj

    def weights(self, name: str) -> np.ndarray:
        """The weights (n,) of a group, all 0 if there is no such group."""
        found = group_weights(self._obj.data, self._names, {name})
        return found.get(name, np.zeros(len(self.points), dtype=np.float32))

    def copy_across(self, source: str, target: VertexGroup, strength: float) -> int:
        """Give ``target`` the mirrored weights of ``source``. Vertices without an image keep their weights.

        Vertices on the centre that the source holds exactly (its weights times ``strength``) are not given to
        ``target``. Returns how many these are.
        """
        weights = self.weights(source)
        mirrored = weights[self.images]
        kept = self.centre & (weights.astype(np.float64) * strength >= 1.0)
        mirrored[kept] = 0.0
        _write(target, mirrored, self.paired & ~(self.centre & (weights == 0.0)))
        return int(kept.sum())

    def even_out(self, group: VertexGroup, source: Side) -> None:
        """Give the half of the group that is not on the side ``source`` the mirrored weights of the other."""
        across = self.points[:, 0] < 0.0 if source is Side.LEFT else self.points[:, 0] > 0.0
        weights = self.weights(group.name)
        _write(group, weights[self.images], across & self.paired)


def _write(group: VertexGroup, weights: np.ndarray, where: np.ndarray) -> None:
    """Replace the weights (n,) in a group at the vertices ``where`` (n,). A weight of 0 removes a vertex."""
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
