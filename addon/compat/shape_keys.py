# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write the positions of a shape key, and remove datablocks that may have some.

For meshes, Blender 4.1 and later read and write the fast way.
"""

from collections.abc import Iterable

import bpy
import numpy as np
from bpy.types import ID, Mesh, ShapeKey


def read_key(key: ShapeKey) -> np.ndarray:
    """The positions of a shape key, float32 (n, 3), in the space of the mesh or lattice."""
    flat = np.empty(len(key.data) * 3, dtype=np.float32)
    _points(key).foreach_get("co", flat)
    return flat.reshape(-1, 3)


def write_key(key: ShapeKey, positions: np.ndarray) -> None:
    """Replace the positions of a shape key, float32 (n, 3)."""
    _points(key).foreach_set("co", np.ascontiguousarray(positions, dtype=np.float32).ravel())


def remove_data(datablocks: Iterable[ID]) -> None:
    """Remove meshes, curves or lattices with their shape keys, which Blender 3.4 would leave behind."""
    held = list(datablocks)
    keys = [getattr(data, "shape_keys", None) for data in held]
    bpy.data.batch_remove(held + [key for key in keys if key is not None])


def _points(key: ShapeKey):
    is_fast = hasattr(key, "points") and isinstance(key.id_data.user, Mesh)
    return key.points if is_fast else key.data
