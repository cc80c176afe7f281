# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden shape mesh that the modifier shows.

It has one vertex per target vertex and one more, whose x is the Factor and whose y says whether the rest
are positions (0) or displacements (1). One write of one array changes all of it together.
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
    """Let a shape mesh show the rest shape of another number of vertices."""
    mesh.clear_geometry()
    mesh.vertices.add(vertex_count + 1)
    write_shape(mesh, np.zeros((vertex_count + 1, 3), dtype=np.float32), 0.0, False)


def shape_array(vertex_count: int) -> np.ndarray:
    """Room for a shape mesh, float32 (n + 1, 3)."""
    return np.empty((vertex_count + 1, 3), dtype=np.float32)


def write_shape(mesh: Mesh, shape: np.ndarray, factor: float, displacement: bool) -> bool:
    """Write all of it, a ``shape_array``; False where the mesh has another size."""
    if len(mesh.vertices) != len(shape):
        return False
    shape[-1] = factor, float(displacement), 0.0
    write_positions(mesh, shape)
    return True


def read_shape(mesh: Mesh) -> np.ndarray | None:
    """The positions (n, 3) a shape mesh shows, float64; None where it shows rest or displacements."""
    held = read_positions(mesh).astype(np.float64)
    factor, displacement = held[-1, :2]
    return held[:-1] if factor > 0.0 and displacement < 0.5 else None
