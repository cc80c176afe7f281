# SPDX-License-Identifier: GPL-3.0-or-later
"""The convex hull of points, for shapes that have no faces to put a cage around."""

import bmesh
import bpy
import numpy as np

from ..compat import read_faces, read_positions

_THICKNESS = 1e-3  # of the diagonal: what lies in a plane or on a line becomes solid by so much
_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


def around(points: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Points (h, 3) and faces (counts, corners) of a closed mesh that holds all ``points`` (n, 3).

    It lies a thousandth of their size outside them. Makes a datablock, and takes it away: main thread only.
    """
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    outermost = points if len(points) < 8 else _hull(points)[0]
    solid = (outermost[:, None, :] + _THICKNESS * size * _CORNERS).reshape(-1, 3)
    return _hull(solid)


def _hull(points: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    mesh, edit = bpy.data.meshes.new("Hull"), bmesh.new()
    try:
        mesh.vertices.add(len(points))
        mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
        edit.from_mesh(mesh)
        found = bmesh.ops.convex_hull(edit, input=edit.verts)
        inside = {element for element in found["geom_interior"] if isinstance(element, bmesh.types.BMVert)}
        bmesh.ops.delete(edit, geom=list(inside), context="VERTS")
        edit.to_mesh(mesh)
        return read_positions(mesh).astype(np.float64), read_faces(mesh)
    finally:
        edit.free()
        bpy.data.meshes.remove(mesh)
