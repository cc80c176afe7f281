# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden shape mesh that the modifier shows.

It has one vertex per point of the target, and one more. The x coordinate of this last vertex is the Factor;
its y coordinate says whether the other vertices hold positions (0) or displacements (1). Writing one array
thus changes everything at once.
"""

import bpy
import numpy as np
from bpy.types import Mesh

from ..compat import read_positions, write_positions
from ..ids import Keys


def shape_mesh(name: str, vertex_count: int) -> Mesh:
    """A new shape mesh that shows the rest shape."""
    mesh = bpy.data.meshes.new(name)
    mesh[Keys.SHAPE] = True
    resize_shape(mesh, vertex_count)
    return mesh


def resize_shape(mesh: Mesh, vertex_count: int) -> None:
    """Give a shape mesh another number of vertices. It then shows the rest shape."""
    mesh.clear_geometry()
    mesh.vertices.add(vertex_count + 1)
    write_shape(mesh, np.zeros((vertex_count + 1, 3), dtype=np.float32), 0.0, False)


def shape_array(vertex_count: int) -> np.ndarray:
    """An uninitialised array for all vertices of a shape mesh, float32 (n + 1, 3)."""
    return np.empty((vertex_count + 1, 3), dtype=np.float32)


def write_shape(mesh: Mesh, shape: np.ndarray, factor: float, displacement: bool) -> bool:
    """Write a ``shape_array``; False if the mesh has another number of vertices."""
    if len(mesh.vertices) != len(shape):
        return False
    shape[-1] = factor, float(displacement), 0.0
    write_positions(mesh, shape)
    return True


def copy_shape(source: Mesh, mesh: Mesh) -> bool:
    """Let a shape mesh show what another one shows; False if that has another number of vertices."""
    if len(mesh.vertices) != len(source.vertices):
        return False
    held = read_positions(source)
    if not np.array_equal(held, read_positions(mesh)):
        write_positions(mesh, held)
    return True


def read_shape(mesh: Mesh) -> np.ndarray | None:
    """The positions (n, 3) that a shape mesh shows, float64; None if it shows the rest shape or
    displacements.
    """
    held = read_positions(mesh).astype(np.float64)
    factor, displacement = held[-1, :2]
    return held[:-1] if factor > 0.0 and displacement < 0.5 else None
