# SPDX-License-Identifier: GPL-3.0-or-later
"""Read how the vertices of a mesh hang together."""

import numpy as np
from bpy.types import Mesh


def read_triangles(mesh: Mesh) -> np.ndarray:
    """Vertex indices int32 (t, 3); concave polygons are cut as Blender cuts them."""
    mesh.calc_loop_triangles()
    flat = np.empty(len(mesh.loop_triangles) * 3, dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", flat)
    return flat.reshape(-1, 3)


def read_edges(mesh: Mesh) -> np.ndarray:
    """Vertex indices int32 (e, 2)."""
    flat = np.empty(len(mesh.edges) * 2, dtype=np.int32)
    mesh.edges.foreach_get("vertices", flat)
    return flat.reshape(-1, 2)
