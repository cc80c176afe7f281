# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a rest mesh: points, faces, weights of vertex groups."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from bpy.types import Mesh

from ..compat import read_positions
from ..ids import Keys


@dataclass
class RestShape:
    """What entered the modifier at bind.

    ``points`` float64 (n, 3), ``counts`` (m,) corners per face, ``corners`` vertex indices face after face,
    ``weights`` float32 (n,) by vertex group name, filled on demand.
    """

    token: str
    points: np.ndarray
    counts: np.ndarray
    corners: np.ndarray
    weights: dict[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def compact(self) -> np.ndarray:
        """The points as Blender holds them, float32."""
        return self.points.astype(np.float32)


def read_rest(mesh: Mesh) -> RestShape:
    """The rest shape stored in a mesh datablock."""
    counts = np.empty(len(mesh.polygons), dtype=np.int32)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    mesh.loops.foreach_get("vertex_index", corners)
    points = read_positions(mesh).astype(np.float64)
    return RestShape(mesh.get(Keys.REST_TOKEN, ""), points, counts, corners)


def group_weights(mesh: Mesh, names: list[str], wanted: set[str]) -> dict[str, np.ndarray]:
    """Weights float32 (n,) of the ``wanted`` groups, in one pass; ``names``: the mesh's groups in order."""
    found = {name: np.zeros(len(mesh.vertices), dtype=np.float32) for name in wanted if name in names}
    rows = {names.index(name): weights for name, weights in found.items()}
    if not rows:
        return found
    for index, vertex in enumerate(mesh.vertices):
        for element in vertex.groups:
            weights = rows.get(element.group)
            if weights is not None:
                weights[index] = element.weight
    return found
