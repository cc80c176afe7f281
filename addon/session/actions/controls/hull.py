# SPDX-License-Identifier: GPL-3.0-or-later
"""The convex hull of points, to make a cage around a shape without faces. Main thread only."""

import bmesh
import bpy
import numpy as np

from ....compat import read_faces, read_positions

_THICKNESS = 1e-3  # relative to the size: points in a plane or on a line get a hull of this thickness
_SLIVER = 1e-6  # relative to the largest triangle: the normals of smaller ones are not reliable
_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


def around(points: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Points (h, 3) and triangles (counts, corners) of a closed mesh that contains all ``points`` (n, 3).

    Its distance from them is about a thousandth of their size. Each round adds the points that stick out
    most, so each hull has few points: 100,000 points take a fifth of a second.
    """
    reach = _THICKNESS * (float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0)
    outermost = np.unique(np.concatenate((points @ _CORNERS.T, points, -points), axis=1).argmax(axis=0))
    waiting = np.arange(len(points))
    while True:
        solid = (points[outermost, None, :] + reach * _CORNERS).reshape(-1, 3)
        corners, faces = _hull(solid)
        waiting, farthest = _outside(points, waiting, corners[faces[1].reshape(-1, 3)])
        found = np.setdiff1d(farthest, outermost)
        if not len(found):
            return corners, faces
        outermost = np.concatenate((outermost, found))


def _outside(points: np.ndarray, waiting: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Which of the points ``waiting`` lie outside ``triangles`` (t, 3, 3); the farthest one per triangle."""
    a, b, c = triangles.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    is_out, farthest = np.zeros(len(waiting), dtype=bool), []
    wide, places = length > _SLIVER * length.max(), points[waiting]
    for corner, normal in zip(a[wide], normals[wide]):
        away = places @ normal - corner @ normal
        is_out |= away > 0.0
        if len(away) and away.max() > 0.0:
            farthest.append(int(waiting[away.argmax()]))
    return waiting[is_out], farthest


def _hull(points: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The convex hull of points that do not lie in a plane; its faces point outwards."""
    mesh, edit = bpy.data.meshes.new("Hull"), bmesh.new()
    try:
        mesh.vertices.add(len(points))
        mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
        edit.from_mesh(mesh)
        found = bmesh.ops.convex_hull(edit, input=edit.verts)
        inside = {vertex for vertex in found["geom_interior"] if isinstance(vertex, bmesh.types.BMVert)}
        bmesh.ops.delete(edit, geom=list(inside), context="VERTS")
        edit.to_mesh(mesh)
        return read_positions(mesh).astype(np.float64), read_faces(mesh)
    finally:
        edit.free()
        bpy.data.meshes.remove(mesh)
