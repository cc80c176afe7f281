# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions and indices of a mesh, by the fastest way each version has.

Blender's indices are unsigned: into signed arrays it converts them one by one, fifty times slower.
"""

import numpy as np
from bpy.types import Mesh


def read_positions(mesh: Mesh) -> np.ndarray:
    """float32 (n, 3), in the mesh's space."""
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    attribute = mesh.attributes.get("position")
    if attribute is not None and len(attribute.data) == len(mesh.vertices):
        attribute.data.foreach_get("vector", flat)
    else:
        mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def read_faces(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Corners per face int32 (m,), and the vertex of each corner, face after face."""
    counts = np.empty(len(mesh.polygons), dtype=np.int32)
    corners = np.empty(len(mesh.loops), dtype=np.uint32)
    attribute = mesh.attributes.get(".corner_vert")
    if attribute is not None and len(attribute.data) == len(corners):
        attribute.data.foreach_get("value", corners.view(np.int32))
        mesh.polygons.foreach_get("loop_start", counts)
        counts = np.diff(counts, append=np.int32(len(corners)))
    else:
        mesh.loops.foreach_get("vertex_index", corners)
        mesh.polygons.foreach_get("loop_total", counts)
    return counts, corners.view(np.int32)


def read_triangles(mesh: Mesh) -> np.ndarray:
    """Vertex indices int32 (t, 3); concave polygons are cut as Blender cuts them."""
    mesh.calc_loop_triangles()
    corners = np.empty(len(mesh.loop_triangles) * 3, dtype=np.uint32)
    mesh.loop_triangles.foreach_get("loops", corners)
    return read_faces(mesh)[1][corners].reshape(-1, 3)


def read_edges(mesh: Mesh) -> np.ndarray:
    """Vertex indices int32 (e, 2)."""
    flat = np.empty(len(mesh.edges) * 2, dtype=np.uint32)
    mesh.edges.foreach_get("vertices", flat)
    return flat.view(np.int32).reshape(-1, 2)


def write_positions(mesh: Mesh, positions: np.ndarray) -> None:
    """Replace all positions, float32 (n, 3) of the size the mesh has, and tell Blender."""
    flat = np.ascontiguousarray(positions, dtype=np.float32).ravel()
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_set("vector", flat)
    else:
        mesh.vertices.foreach_set("co", flat)
    mesh.update_tag()
