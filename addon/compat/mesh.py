# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write positions and indices of a mesh or a cloud, in the fastest way that each version offers.

Blender's indices are unsigned. Into a signed array it would convert them one by one, which is fifty times
slower.
"""

import numpy as np
from bpy.types import ID, Lattice, Mesh, MeshEdge


def read_positions(mesh: Mesh) -> np.ndarray:
    """The positions of all vertices, float32 (n, 3), in the space of the mesh."""
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    attribute = mesh.attributes.get("position")
    if attribute is not None and len(attribute.data) == len(mesh.vertices):
        attribute.data.foreach_get("vector", flat)
    else:
        mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def read_cloud(cloud: ID) -> np.ndarray:
    """The points of a point cloud or of hair curves, float32 (n, 3), in their own space."""
    attribute = cloud.attributes.get("position")
    flat = np.empty(3 * (0 if attribute is None else len(attribute.data)), dtype=np.float32)
    if len(flat):
        attribute.data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def read_lattice(lattice: Lattice) -> np.ndarray:
    """The points of a lattice, float32 (n, 3), in its own space, evaluated if the lattice is."""
    flat = np.empty(3 * len(lattice.points), dtype=np.float32)
    lattice.points.foreach_get("co_deform", flat)
    return flat.reshape(-1, 3)


def write_lattice(lattice: Lattice, positions: np.ndarray) -> None:
    """Move the points of a lattice, float32 (n, 3). They count only while it has no shape keys."""
    lattice.points.foreach_set("co_deform", np.ascontiguousarray(positions, dtype=np.float32).ravel())
    lattice.update_tag()


def read_faces(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """The number of corners per face, int32 (m,), and the vertex of each corner, face after face."""
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
    """The triangles of all faces as vertex indices, int32 (t, 3), divided as Blender divides the faces."""
    mesh.calc_loop_triangles()
    corners = np.empty(len(mesh.loop_triangles) * 3, dtype=np.uint32)
    mesh.loop_triangles.foreach_get("loops", corners)
    return read_faces(mesh)[1][corners].reshape(-1, 3)


def read_edges(mesh: Mesh) -> np.ndarray:
    """The edges as vertex indices, int32 (e, 2)."""
    flat = np.empty(len(mesh.edges) * 2, dtype=np.uint32)
    mesh.edges.foreach_get("vertices", flat)
    return flat.view(np.int32).reshape(-1, 2)


def read_creases(mesh: Mesh) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Which edges (k, 2) and vertices (k,) are creased, each with its crease from 0 to 1, float64 (k,)."""
    edges, vertices = (
        _creases(mesh, size, attribute, before)
        for size, attribute, before in (
            (len(mesh.edges), "crease_edge", "edge_creases"),
            (len(mesh.vertices), "crease_vert", "vertex_creases"),
        )
    )
    creased, sharp = np.flatnonzero(edges), np.flatnonzero(vertices)
    return (read_edges(mesh)[creased], edges[creased]), (sharp, vertices[sharp])


def _creases(mesh: Mesh, count: int, attribute: str, before: str) -> np.ndarray:
    """The creases of all edges or vertices; up to 3.6 these are no attributes, but layers of their own."""
    values, layer = np.zeros(count, dtype=np.float32), mesh.attributes.get(attribute)
    if layer is None:
        layer = next(iter(getattr(mesh, before, None) or ()), None)
    if layer is not None and len(layer.data) == count:
        layer.data.foreach_get("value", values)
    return values.astype(np.float64)


def edge_creases(mesh: Mesh) -> np.ndarray:
    """The crease of each edge from 0 to 1, float64 (e,)."""
    return _creases(mesh, len(mesh.edges), "crease_edge", "edge_creases")


def write_creases(mesh: Mesh, creases: np.ndarray) -> None:
    """Crease the edges, float (e,) from 0 to 1."""
    values = np.ascontiguousarray(creases, dtype=np.float32)
    if "crease" in MeshEdge.bl_rna.properties:
        mesh.edges.foreach_set("crease", values)
        return
    attribute = mesh.attributes.get("crease_edge") or mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
    attribute.data.foreach_set("value", values)


def write_positions(mesh: Mesh, positions: np.ndarray) -> None:
    """Replace the positions of all vertices, float32 (n, 3), and tell Blender of the change."""
    flat = np.ascontiguousarray(positions, dtype=np.float32).ravel()
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_set("vector", flat)
    else:
        mesh.vertices.foreach_set("co", flat)
    mesh.update_tag()
