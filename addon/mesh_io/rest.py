# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and replace rest meshes: points, faces, the weights of vertex groups, and UV maps."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import bmesh
import numpy as np
from bpy.types import Mesh

from ..compat import read_creases, read_faces, read_positions, write_positions
from ..core.geometry import frames, numbering
from ..core.point_types import MESH, PointType, point_type_with_id
from ..ids import Keys

_KEYS = (
    Keys.REST_TOKEN,
    Keys.REST_GROUPS,
    Keys.REST_LOST,
    Keys.REST_POINT_TYPE,
    Keys.REST_STRUCTURE,
    Keys.REST_POSE,
)
_WEIGHTS = ".sinew_weight_"  # prefix of the attributes that hold the weights of vertex groups


@dataclass
class RestShape:
    """The shape that entered the modifier at bind.

    ``points`` float64 (n, 3). ``counts`` (m,) are the corners per face, and ``corners`` their vertex indices,
    face after face. ``weights`` float32 (n,), by the name of the vertex group, and
    ``uv_maps`` float64 (n, 2), by their names, are filled on demand.
    ``not_finite`` (k,) are the vertices whose coordinates are NaN or infinite in Blender; ``points`` has
    finite places near their neighbours instead. ``structure`` describes what an object that is not a mesh
    consists of, as a text that can be compared. ``frame`` (4, 4) leads here from the space in which the shape
    was stored: what Apply has done since.
    """

    token: str
    points: np.ndarray
    counts: np.ndarray
    corners: np.ndarray
    weights: dict[str, np.ndarray] = field(default_factory=dict)
    uv_maps: dict[str, np.ndarray] = field(default_factory=dict)
    not_finite: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    point_type: PointType = MESH
    structure: str = ""
    frame: np.ndarray = field(default_factory=lambda: np.eye(4))

    @cached_property
    def points_float32(self) -> np.ndarray:
        """The points in float32, as Blender stores them."""
        return self.points.astype(np.float32)

    def moved(self, matrix: np.ndarray, token: str) -> "RestShape":
        """The shape moved by an affine ``matrix`` (4, 4). Faces point to the same side after a reflection."""
        return replace(
            self,
            token=token,
            points=frames.transformed(matrix, self.points),
            corners=frames.corners_after(matrix, self.counts, self.corners),
            frame=matrix @ self.frame,
        )


def read_rest(mesh: Mesh) -> RestShape:
    """The rest shape stored in a mesh datablock."""
    counts, corners = read_faces(mesh)
    points = read_positions(mesh).astype(np.float64)
    not_finite = np.flatnonzero(~frames.are_valid(points))
    if len(not_finite):
        points[not_finite] = _replacement_points(points, counts, corners, not_finite)
    return RestShape(
        mesh.get(Keys.REST_TOKEN, ""),
        points,
        counts,
        corners,
        not_finite=not_finite,
        point_type=point_type_with_id(mesh.get(Keys.REST_POINT_TYPE)),
        structure=mesh.get(Keys.REST_STRUCTURE, ""),
    )


def replace_rest(held: Mesh, new: Mesh) -> None:
    """Replace everything that ``held`` stores as a rest mesh by what ``new`` stores. The datablock stays."""
    if not _copy_weights(held, new):
        copy = bmesh.new()
        copy.from_mesh(new, face_normals=False)
        copy.to_mesh(held)
        copy.free()
    for key in _KEYS:
        if key in new:
            held[key] = new[key]
        elif key in held:
            del held[key]


def _copy_weights(held: Mesh, new: Mesh) -> bool:
    """Copy only the weights, which takes a tenth of the time; False if that is not enough.

    It is enough if shapes, UV maps and creases are equal and all weights are stored as attributes.
    """
    wanted = [weights_attribute(index) for index in range(len(known_groups(new)))]
    if not all(name in new.attributes for name in wanted):
        return False
    turned = _turned_faces(held, new)
    if turned is None or turned.any() or not np.array_equal(read_positions(held), read_positions(new)):
        return False
    if not _same_uv_maps(held, new) or not _same_creases(held, new):
        return False
    for name in [attribute.name for attribute in held.attributes]:
        if name.startswith(_WEIGHTS):
            held.attributes.remove(held.attributes[name])
    weights = np.empty(len(new.vertices), dtype=np.float32)
    for name in wanted:
        new.attributes[name].data.foreach_get("value", weights)
        held.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", weights)
    return True


def _same_uv_maps(held: Mesh, new: Mesh) -> bool:
    """Whether two meshes with the same faces have the same UV maps."""
    names = [layer.name for layer in new.uv_layers]
    return names == [layer.name for layer in held.uv_layers] and all(
        np.array_equal(_corner_places(held, name), _corner_places(new, name)) for name in names
    )


def _same_creases(held: Mesh, new: Mesh) -> bool:
    """Whether two meshes with the same faces have the same creases of edges and vertices."""
    pairs = zip(read_creases(held), read_creases(new), strict=True)
    return all(np.array_equal(a, b) for own, other in pairs for a, b in zip(own, other, strict=True))


def _corner_places(mesh: Mesh, name: str) -> np.ndarray:
    """u and v of each corner of the faces, float32 (c, 2)."""
    flat = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    mesh.uv_layers[name].data.foreach_get("uv", flat)
    return flat.reshape(-1, 2)


def read_uv_map(mesh: Mesh, name: str) -> np.ndarray | None:
    """u and v of each vertex at its first corner, float64 (n, 2); None without a map of this name.

    NaN for a vertex in no face, and for one whose place on the map is not finite.
    """
    if name not in mesh.uv_layers:
        return None
    at_corners = _corner_places(mesh, name).astype(np.float64)
    at_corners[~np.isfinite(at_corners).all(axis=1)] = np.nan
    vertices, first = np.unique(read_faces(mesh)[1], return_index=True)
    places = np.full((len(mesh.vertices), 2), np.nan)
    places[vertices] = at_corners[first]
    return places


def same_topology(a: Mesh, b: Mesh) -> bool:
    """Whether two rest meshes have equally many vertices, the same faces and the same structure.

    Faces that were turned over, as by Flip Normals or an applied negative scale, are the same faces.
    """
    return _turned_faces(a, b) is not None


def _turned_faces(a: Mesh, b: Mesh) -> np.ndarray | None:
    """Which faces are turned over in ``b``, bool (m,); None if the meshes have another topology."""
    if len(a.vertices) != len(b.vertices):
        return None
    if not _same_structure(a, b):
        return None
    return frames.turned_faces(read_faces(a), read_faces(b))


def _same_structure(a: Mesh, b: Mesh) -> bool:
    return all(a.get(key) == b.get(key) for key in (Keys.REST_POINT_TYPE, Keys.REST_STRUCTURE))


def keep_shape(mesh: Mesh, held: Mesh) -> None:
    """Give a mesh the points of another with the same topology, and let its faces point to the same sides."""
    write_positions(mesh, read_positions(held))
    turned = _turned_faces(held, mesh)
    if turned is not None and turned.any():
        _turn(mesh, np.flatnonzero(turned))


def _turn(mesh: Mesh, faces: np.ndarray) -> None:
    """Let these faces (k,) point to their other sides."""
    edit = bmesh.new()
    edit.from_mesh(mesh, face_normals=False)
    edit.faces.ensure_lookup_table()
    for index in faces:
        edit.faces[index].normal_flip()
    edit.to_mesh(mesh)
    edit.free()


def renumbered(held: Mesh, new: Mesh, base: Mesh, wanted: set[str]) -> Mesh | None:
    """What a rest mesh has ``held``, as another one, in the order in which ``new`` has vertices and faces.

    None if they differ in more than that. Modifiers number their vertices anew where faces of the ``base``
    were turned. The other mesh has the weights of ``new``, and those of ``wanted`` groups that ``held`` alone
    has.
    """
    count = len(held.vertices)
    kept, groups = len(base.vertices), len(base.polygons)
    if count == kept or count != len(new.vertices) or not _same_structure(held, new):
        return None
    found = numbering.matched(read_faces(held), read_faces(new), count, kept, groups)
    if found is None:
        return None
    places, turned = found
    mesh = new.copy()
    write_positions(mesh, read_positions(held)[places])
    keep_lost_groups(mesh, held, wanted, lambda weights: weights[places])
    _turn(mesh, np.flatnonzero(turned))
    return mesh


def _replacement_points(
    points: np.ndarray, counts: np.ndarray, corners: np.ndarray, lost: np.ndarray
) -> np.ndarray:
    """Finite places (k, 3) for the ``lost`` vertices.

    Each is the mean of the finite corners of the faces around the vertex, or else of all finite points.
    """
    finite = frames.are_valid(points)
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
    """The names of the vertex groups that the object of a rest mesh had, in their order."""
    return _names(mesh, Keys.REST_GROUPS)


def known_groups(mesh: Mesh) -> list[str]:
    """The same, then the names of groups that were deleted before, and whose weights it still holds."""
    return group_names(mesh) + _names(mesh, Keys.REST_LOST)


def _names(mesh: Mesh, key: str) -> list[str]:
    names = mesh.get(key)
    if not hasattr(names, "__iter__"):
        return []
    return [name if isinstance(name, str) else "" for name in names]


def keep_lost_groups(
    mesh: Mesh, held: Mesh, wanted: set[str], carry: Callable[[np.ndarray], np.ndarray] | None = None
) -> None:
    """Let a new rest mesh take over the weights of the ``wanted`` groups that only ``held`` still has.

    Both have the same vertices, or ``carry`` makes weights of the new vertices from those of the held ones.
    """
    own = group_names(mesh)
    found = group_weights(held, known_groups(held), wanted - set(own))
    for index, name in enumerate(sorted(found), len(own)):
        kept = mesh.attributes.new(weights_attribute(index), "FLOAT", "POINT")
        kept.data.foreach_set("value", found[name] if carry is None else carry(found[name]))
    if found:
        mesh[Keys.REST_LOST] = sorted(found)


def weights_attribute(index: int) -> str:
    """The attribute in which a rest mesh holds the weights of its ``index``-th vertex group."""
    return f"{_WEIGHTS}{index}"


def group_weights(mesh: Mesh, names: list[str], wanted: set[str]) -> dict[str, np.ndarray]:
    """Weights float32 (n,) from 0 to 1 of the ``wanted`` groups. ``names`` are all groups of the mesh.

    Blender itself may store weights that are a little above 1, as With Automatic Weights does.
    Groups that are stored as attributes take a millisecond per million vertices. All others are read
    together, in one slow pass over the vertices.
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
    for index, vertex in enumerate(mesh.vertices if rows else ()):
        for element in vertex.groups:
            weights = rows.get(element.group)
            if weights is not None:
                weights[index] = element.weight
    return {name: weights.clip(0.0, 1.0) for name, weights in found.items()}
