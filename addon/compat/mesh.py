# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions of a mesh, by the fastest way each version has."""

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


def write_positions(mesh: Mesh, positions: np.ndarray) -> None:
    """Replace all positions, float32 (n, 3) of the size the mesh has, and tell Blender."""
    flat = np.ascontiguousarray(positions, dtype=np.float32).ravel()
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_set("vector", flat)
    else:
        mesh.vertices.foreach_set("co", flat)
    mesh.update_tag()
