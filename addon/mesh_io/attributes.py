# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the positions that entered Sinew's modifier, from the final evaluated mesh."""

from dataclasses import dataclass

import numpy as np
from bpy.types import Mesh


@dataclass(frozen=True)
class Incoming:
    """The incoming ``points`` float32 (n, 3), and their ``count``.

    ``points`` is None if later modifiers changed the order of the vertices; ``count`` is -1 if it is unknown.
    """

    points: np.ndarray | None
    count: int


def read_incoming(mesh: Mesh, position_name: str, index_name: str, expected: int) -> Incoming:
    """Read the incoming positions from the two attributes that the node group stores."""
    positions, indices = mesh.attributes.get(position_name), mesh.attributes.get(index_name)
    if positions is None or indices is None or len(indices.data) == 0:
        return Incoming(None, -1)
    index = np.empty(len(indices.data), dtype=np.int32)
    indices.data.foreach_get("value", index)
    count = int(index.max()) + 1
    if count != expected or not np.array_equal(index[:expected], np.arange(expected, dtype=np.int32)):
        return Incoming(None, count)
    flat = np.empty(len(positions.data) * 3, dtype=np.float32)
    positions.data.foreach_get("vector", flat)
    return Incoming(flat[: expected * 3].reshape(-1, 3), count)


def read_attributes(mesh: Mesh, position_name: str, index_name: str) -> tuple[np.ndarray, np.ndarray]:
    """Both attributes of all final vertices: float32 (m, 3) and int32 (m,)."""
    positions, indices = mesh.attributes[position_name], mesh.attributes[index_name]
    flat, index = (
        np.empty(len(positions.data) * 3, dtype=np.float32),
        np.empty(len(indices.data), dtype=np.int32),
    )
    positions.data.foreach_get("vector", flat)
    indices.data.foreach_get("value", index)
    return flat.reshape(-1, 3), index
