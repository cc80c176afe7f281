# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh objects whose vertices are the points of control grids. Reading them makes no datablock.

How far a vertex is from where it was when the object was made is what counts. So the object may stand
anywhere, Apply changes nothing, and the points can be moved by whatever moves vertices: in Edit Mode, by
shape keys, hooks and other modifiers.
"""

from collections.abc import Sequence

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...compat import read_positions, write_positions
from ...core.errors import OptionError
from ...core.geometry import frames
from ...ids import Keys


def make_mesh(name: str, grids: Sequence[np.ndarray]) -> Mesh:
    """A new mesh with the points and lines of grids (rows, columns, 3), whose points rest where they are."""
    points, edges, count = [], [], 0
    for grid in grids:
        index = count + np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
        for one, other in ((index[:, :-1], index[:, 1:]), (index[:-1], index[1:])):
            edges.append(np.stack((one.ravel(), other.ravel()), axis=1))
        points.append(grid.reshape(-1, 3))
        count += index.size
    mesh = bpy.data.meshes.new(name)
    placed = np.concatenate(points).astype(np.float32)
    mesh.vertices.add(len(placed))
    lines = np.concatenate(edges).astype(np.int32)
    mesh.edges.add(len(lines))
    mesh.edges.foreach_set("vertices", lines.ravel())
    write_positions(mesh, placed)
    mesh[Keys.GRID_REST] = placed.ravel().astype(np.float64).tolist()
    mesh.update()
    return mesh


def is_grid(obj: Object | None) -> bool:
    """Whether the object was made by ``make_mesh`` for a deformer."""
    return obj is not None and isinstance(obj.data, Mesh) and Keys.GRID_REST in obj.data


def read(obj: Object) -> tuple[np.ndarray, np.ndarray] | None:
    """Where the vertices of an evaluated object are, and where they rest, float32 (g, 3) each.

    None where the object was deleted, which a pointer to it outlives.
    """
    original = obj.original
    if not any(original.name in scene.objects for scene in bpy.data.scenes):
        return None
    if not is_grid(original):
        raise OptionError(f"{original.name} is no control grid - press New Grid to make one")
    rest = np.array(original.data[Keys.GRID_REST].to_list(), dtype=np.float32).reshape(-1, 3)
    try:
        mesh = obj.to_mesh()
        points = np.zeros((0, 3), dtype=np.float32) if mesh is None else read_positions(mesh)
    finally:
        obj.to_mesh_clear()
    if len(points) != len(rest):
        raise OptionError(
            f"{original.name} has {len(points):,} vertices, and was made with {len(rest):,} - undo that, or "
            "press New Grid"
        )
    return points, rest


def moves(obj: Object, target: np.ndarray) -> np.ndarray | None:
    """How far the points are from their rest, float64 (g, 3) in the space of a target of this frame."""
    found = read(obj)
    if found is None:
        return None
    world = np.array(obj.matrix_world, dtype=np.float64)
    relative = frames.inverse(target, "The mesh object") @ world
    points, rest = (each.astype(np.float64) for each in found)
    with np.errstate(invalid="ignore"):  # the native module refuses it
        return (points - rest) @ relative[:3, :3].T
