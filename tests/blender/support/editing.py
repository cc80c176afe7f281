# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode from a test: selecting, reading what it shows, and Grab Once on it."""

import math

import bmesh
import bpy
import numpy as np
from rigs.rig import grid_object, make_active, new_empty, update


def edit(obj: bpy.types.Object, where) -> np.ndarray:
    """Enter Edit Mode with the vertices selected for which ``where(point)``; their indices."""
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    return select(obj, where)


def select(obj: bpy.types.Object, where) -> np.ndarray:
    mesh = bmesh.from_edit_mesh(obj.data)
    for vertex in mesh.verts:
        vertex.select = bool(where(vertex.co)) and not vertex.hide
    mesh.select_flush_mode()
    bmesh.update_edit_mesh(obj.data)
    return np.array([vertex.index for vertex in mesh.verts if vertex.select])


def edited(obj: bpy.types.Object) -> np.ndarray:
    """What Edit Mode shows, float32 (n, 3)."""
    return np.array([vertex.co[:] for vertex in bmesh.from_edit_mesh(obj.data).verts], dtype=np.float32)


def selection(obj: bpy.types.Object) -> list[bool]:
    mesh = bmesh.from_edit_mesh(obj.data)
    return [element.select for kind in (mesh.verts, mesh.edges, mesh.faces) for element in kind]


def centre(point) -> bool:
    return math.hypot(point.x, point.y) < 0.15


def grab(**keywords) -> None:
    assert bpy.ops.sinew.grab_region(**keywords) == {"FINISHED"}


def placed_object(cells: int = 12) -> bpy.types.Object:
    """A plate that is parented, turned, moved and scaled without proportion."""
    obj = grid_object(cells=cells)
    parent = new_empty("Parent", (3.0, -2.0, 1.0))
    parent.rotation_euler = (0.4, 0.1, -0.7)
    obj.parent = parent
    obj.rotation_euler = (0.2, 0.5, 0.9)
    obj.scale = (2.0, 0.5, 1.5)
    update()
    return obj
