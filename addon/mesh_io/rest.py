# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a rest mesh: points, faces, weights of vertex groups."""

from dataclasses import dataclass, field
from functools import cached_property

import bmesh
import numpy as np
from bpy.types import Mesh

from ..compat import read_faces, read_positions
from ..core.geometry import frames
from ..core.kinds import MESH, Kind, named
from ..ids import Keys

_KEYS = (Keys.REST_TOKEN, Keys.REST_GROUPS, Keys.REST_KIND, Keys.REST_STRUCTURE)
_WEIGHTS = ".sinew_weight_"  # how the attributes begin that keep the weights of groups


@dataclass
class RestShape:
    """What entered the modifier at bind.

    ``points`` float64 (n, 3), ``counts`` (m,) corners per face, ``corners`` vertex indices face after face,
    ``weights`` float32 (n,) by vertex group name, filled on demand. ``not_finite`` (k,) vertices whose
    coordinates are NaN or infinite in Blender; ``points`` holds finite places near their neighbours.
    ``structure`` is what an object that is no mesh was made of, as a text to compare.
    """

    token: str
    points: np.ndarray
    counts: np.ndarray
    corners: np.ndarray
    weights: dict[str, np.ndarray] = field(default_factory=dict)
    not_finite: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    kind: Kind = MESH
    structure: str = ""

    @cached_property
    def compact(self) -> np.ndarray:
        """The points as Blender holds them, float32."""
        return self.points.astype(np.float32)


def read_rest(mesh: Mesh) -> RestShape:
    """The rest shape stored in a mesh datablock."""
    counts, corners = read_faces(mesh)
    points = read_positions(mesh).astype(np.float64)
    not_finite = np.flatnonzero(~frames.is_place(points))
    if len(not_finite):
        points[not_finite] = _stand_ins(points, counts, corners, not_finite)
    return RestShape(
        mesh.get(Keys.REST_TOKEN, ""),
        points,
        counts,
        corners,
        not_finite=not_finite,
        kind=named(mesh.get(Keys.REST_KIND)),
        structure=mesh.get(Keys.REST_STRUCTURE, ""),
    )


def replace_rest(held: Mesh, new: Mesh) -> None:
    """Let ``held`` be what ``new`` is, to those who read a rest mesh. Its identity stays."""
    if not _take_weights(held, new):
        copy = bmesh.new()
        copy.from_mesh(new, face_normals=False)
        copy.to_mesh(held)
        copy.free()
    for key in _KEYS:
        if key in new:
            held[key] = new[key]
        elif key in held:
            del held[key]


def _take_weights(held: Mesh, new: Mesh) -> bool:
    """Where the shape is the same and all weights are attributes, copy only these: a tenth of the time."""
    wanted = [weights_attribute(index) for index in range(len(group_names(new)))]
    if not all(name in new.attributes for name in wanted):
        return False
    if not same_topology(held, new) or not np.array_equal(read_positions(held), read_positions(new)):
        return False
    for name in [attribute.name for attribute in held.attributes]:
        if name.startswith(_WEIGHTS):
            held.attributes.remove(held.attributes[name])
    weights = np.empty(len(new.vertices), dtype=np.float32)
    for name in wanted:
        new.attributes[name].data.foreach_get("value", weights)
        held.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", weights)
    return True


def same_topology(a: Mesh, b: Mesh) -> bool:
    """Equal numbers of vertices, the same faces, made of the same."""
    if len(a.vertices) != len(b.vertices):
        return False
    if any(a.get(key) != b.get(key) for key in (Keys.REST_KIND, Keys.REST_STRUCTURE)):
        return False
    return all(np.array_equal(x, y) for x, y in zip(read_faces(a), read_faces(b), strict=True))


def _stand_ins(points: np.ndarray, counts: np.ndarray, corners: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """Finite places (k, 3) for the ``lost`` vertices: the mean of the finite corners around, else of all."""
    finite = frames.is_place(points)
    known = np.where(finite[:, None], points, 0.0)
    everywhere = known.sum(axis=0) / max(int(finite.sum()), 1)
    faces = np.repeat(np.arange(len(counts)), counts)
    sums, numbers = np.zeros((len(counts), 3)), np.zeros(len(counts))
    np.add.at(sums, faces, known[corners])
    np.add.at(numbers, faces, finite[corners])
    places = np.empty((len(lost), 3))
    for row, vertex in enumerate(lost):
        around = faces[corners == vertex]
        number = numbers[around].sum()
        places[row] = sums[around].sum(axis=0) / number if number else everywhere
    return places


def group_names(mesh: Mesh) -> list[str]:
    """The vertex groups that a rest mesh had, in their order."""
    names = mesh.get(Keys.REST_GROUPS)
    if not hasattr(names, "__iter__"):
        return []
    return [name if isinstance(name, str) else "" for name in names]


def weights_attribute(index: int) -> str:
    """Where a rest mesh keeps the weights of its ``index``-th vertex group for a quick read."""
    return f"{_WEIGHTS}{index}"


def group_weights(mesh: Mesh, names: list[str], wanted: set[str]) -> dict[str, np.ndarray]:
    """Weights float32 (n,) of the ``wanted`` groups; ``names``: the mesh's groups in order.

    Groups kept as attributes take a millisecond a million vertices; the others one slow pass together.
    """
    found = {name: np.zeros(len(mesh.vertices), dtype=np.float32) for name in wanted if name in names}
    rows = {}
    for name, weights in found.items():
        index = names.index(name)
        attribute = mesh.attributes.get(weights_attribute(index))
        if attribute is not None and len(attribute.data) == len(weights):
            attribute.data.foreach_get("value", weights)
        else:
            rows[index] = weights
    if not rows:
        return found
    for index, vertex in enumerate(mesh.vertices):
        for element in vertex.groups:
            weights = rows.get(element.group)
            if weights is not None:
                weights[index] = element.weight
    return found
