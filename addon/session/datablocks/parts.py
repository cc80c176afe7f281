# SPDX-License-Identifier: GPL-3.0-or-later
"""The loose parts of a mesh, and how large they are."""

import numpy as np
from bpy.types import Depsgraph, Object

from ...backend import connected_parts
from ...compat import read_faces, read_positions
from ...core.errors import SinewError
from ...core.geometry import frames
from ...core.memory import remember
from . import targets
from .shapes.capture import evaluated_mesh

_last: dict[tuple, "ShownParts"] = remember({})  # those that were asked for last


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
