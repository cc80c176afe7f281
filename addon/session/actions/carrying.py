# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives a mesh new triangles that take over all that the old ones carry. Main thread only.

Vertex groups, shape keys, UV maps, attributes, materials, and marks of edges are carried over. Custom
normals, attributes of edges but the crease, loose edges and loose vertices are not.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...backend import Carried, Lined
from ...compat import (
    edge_creases,
    read_creases,
    read_edges,
    read_faces,
    read_key,
    read_positions,
    write_creases,
    write_key,
)
from ...core.errors import SinewError
from ..state import sessions
from .repair import require_editable, users_of

_ISLAND = 1e-6  # of a UV map: corners that are further apart belong to different islands
# Of the types of attributes: the field, how many numbers each has, and whether they may be mixed.
_FIELDS = {
    "FLOAT": ("value", 1, True),
    "INT": ("value", 1, False),
    "INT8": ("value", 1, False),
    "BOOLEAN": ("value", 1, False),
    "FLOAT_VECTOR": ("vector", 3, True),
    "FLOAT2": ("vector", 2, True),
    "FLOAT_COLOR": ("color", 4, True),
    "BYTE_COLOR": ("color", 4, True),
}
# Attributes that have other names in some release, or that hold what is read in another way.
_OWN = {"position", "material_index", "sharp_face", "sharp_edge", "uv_seam", "custom_normal"}
_SCULPTED = {".sculpt_mask", ".sculpt_face_set"}
_FLAGS = ("use_seam", "use_edge_sharp")


@dataclass(frozen=True)
class Taken(Lined):
    """What a mesh was when new triangles were asked for; any thread may read it.

    Its lines are seams, sharp and creased edges, and borders of materials and of UV islands.
    """

    edges: np.ndarray  # (k,) the index of the edge of each line


def take(obj: Object) -> Taken:
    """Read the mesh of an object in Object Mode."""
    mesh = obj.data
    require_editable(obj, "remesh")
    for user in users_of(mesh):
        if any(modifier.type == "MULTIRES" for modifier in user.modifiers):
            raise SinewError(f"{user.name} has a Multiresolution modifier - apply or remove it first")
    if not len(mesh.polygons):
        raise SinewError(f"{obj.name} has no faces")
    points = read_positions(mesh).astype(np.float64)
    if not np.isfinite(points).all():
        raise SinewError(f"{obj.name} has vertices without a position - repair it first")
    kept = (edge_creases(mesh) > 0.0) | _island_borders(mesh)
    for flag in _FLAGS:
        kept |= _read(mesh.edges, flag, bool)
    edges = np.flatnonzero(kept)
    return Taken(points, read_faces(mesh), read_edges(mesh)[edges], edges)


@sessions.suspended()
def put(obj: Object, taken: Taken, made: Carried) -> None:
    """Give the mesh its new triangles, in Object Mode. It must be as it was when it was taken."""
    mesh = obj.data
    counts, corners = read_faces(mesh)
    if not (
        np.array_equal(read_positions(mesh), taken.points)
        and np.array_equal(counts, taken.faces[0])
        and np.array_equal(corners, taken.faces[1])
    ):
        raise SinewError("The mesh was changed meanwhile - it stays as it is")
    groups = _groups(mesh)
    uv_maps = [(layer.name, _read(layer.data, "uv", float, 2)) for layer in mesh.uv_layers]
    active_uv = mesh.uv_layers.active.name if mesh.uv_layers else None
    rendered_uv = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
    active_colour = getattr(mesh.color_attributes.active_color, "name", "")
    attributes = list(_attributes(mesh))
    of_faces = [
        (name, _read(mesh.polygons, name, kind))
        for name, kind in (("use_smooth", bool), ("material_index", int))
    ]
    flags = [(name, _read(mesh.edges, name, bool)) for name in _FLAGS]
    creases = edge_creases(mesh)
    keys = mesh.shape_keys
    moves = {} if keys is None else {key.name: read_key(key) - taken.points for key in keys.key_blocks}

    names, regions = obj.vertex_groups.keys(), _regions(mesh)
    carried = {index: _weights(weights, made, names[index] in regions) for index, weights in groups.items()}
    where, sharpness = read_creases(mesh)[1]
    sharp = np.zeros(len(taken.points))
    if "crease_vert" not in mesh.attributes:  # else they are carried as an attribute
        sharp[where] = sharpness
    _replace(mesh, made, carried, made.at_vertices(sharp))
    for name, moved in moves.items():
        write_key(keys.key_blocks[name], (made.points + made.at_vertices(moved)).astype(np.float32))
    for name, values in uv_maps:
        layer = mesh.uv_layers.new(name=name, do_init=False)
        layer.data.foreach_set("uv", made.at_corners(values).astype(np.float32).ravel())
    for name, kind, domain, values in attributes:
        _write(mesh, name, kind, domain, values, made)
    for name, values in of_faces:
        mesh.polygons.foreach_set(name, values[made.face_sources])
    new_edges = _edge_indices(mesh, made.lines)
    old_edges = taken.edges[made.line_sources]
    for name, values in flags:
        marked = np.zeros(len(mesh.edges), dtype=bool)
        marked[new_edges] = values[old_edges]
        mesh.edges.foreach_set(name, marked)
    if creases.any():
        creased = np.zeros(len(mesh.edges))
        creased[new_edges] = creases[old_edges]
        write_creases(mesh, creased)
    for layer in mesh.uv_layers:
        layer.active_render = layer.name == rendered_uv
    if active_uv is not None:
        mesh.uv_layers.active = mesh.uv_layers[active_uv]
    if active_colour in mesh.color_attributes:
        mesh.color_attributes.active_color = mesh.color_attributes[active_colour]
    mesh.update()
    obj.update_tag()


def _island_borders(mesh: Mesh) -> np.ndarray:
    """(edges) whether the two faces of an edge differ in material, or lie apart on a UV map."""
    counts, corners = read_faces(mesh)
    face = np.repeat(np.arange(len(counts)), counts)
    first = np.cumsum(counts) - counts
    following = np.arange(len(corners)) + 1
    following[first + counts - 1] = first
    edge = _read(mesh.loops, "edge_index", int)
    order = np.argsort(edge, kind="stable")
    uses = np.bincount(edge, minlength=len(mesh.edges))
    begin = np.cumsum(uses) - uses
    pairs = np.flatnonzero(uses == 2)
    a, b = order[begin[pairs]], order[begin[pairs] + 1]
    material = _read(mesh.polygons, "material_index", int)
    apart = material[face[a]] != material[face[b]]
    same_way = corners[a] == corners[b]
    for layer in mesh.uv_layers:
        places = _read(layer.data, "uv", float, 2)
        start = places[np.where(same_way, b, following[b])] - places[a]
        end = places[np.where(same_way, following[b], b)] - places[following[a]]
        apart |= (np.abs(np.concatenate([start, end], axis=1)) > _ISLAND).any(axis=1)
    borders = np.zeros(len(mesh.edges), dtype=bool)
    borders[pairs[apart]] = True
    return borders


def _read(elements, name: str, kind: type, columns: int = 1) -> np.ndarray:
    """A property of all elements: (n,), or (n, columns)."""
    sort = {float: np.float32, int: np.int32, bool: bool}[kind]
    flat = np.empty(len(elements) * columns, dtype=sort)
    elements.foreach_get(name, flat)
    return flat if columns == 1 else flat.reshape(-1, columns)


def _groups(mesh: Mesh) -> dict[int, np.ndarray]:
    """The weights (n,) of each vertex group that has any vertices, by its index."""
    found: dict[int, np.ndarray] = {}
    for index, vertex in enumerate(mesh.vertices):
        for element in vertex.groups:
            if element.group not in found:
                found[element.group] = np.full(len(mesh.vertices), np.nan)
            found[element.group][index] = element.weight
    return found


def _regions(mesh: Mesh) -> set[str]:
    """The vertex groups that are regions or masks of deformers."""
    deformers = [deformer for user in users_of(mesh) for deformer in user.sinew.deformers]
    regions = {handle.vertex_group for deformer in deformers for handle in deformer.handles}
    return regions | {deformer.mask_group for deformer in deformers}


def _weights(old: np.ndarray, made: Carried, is_region: bool) -> np.ndarray:
    """The weights of a vertex group on the new vertices, NaN for those outside.

    They are mixed, so that all weights of a vertex keep their sum. A region with one weight alone keeps it,
    and some vertex.
    """
    inside = ~np.isnan(old)
    share = made.at_vertices(inside.astype(float))
    new = made.at_vertices(np.where(inside, old, 0.0))
    new[share <= 0.0] = np.nan
    values = np.unique(old[inside])
    if is_region and len(values) == 1:
        new = np.where(share >= 0.5, values[0], np.nan)
        if np.isnan(new).all():
            centre = made.old_points[inside].mean(axis=0)
            new[np.argmax(share) if share.any() else np.argmin(np.sum((made.points - centre) ** 2, 1))] = (
                values[0]
            )
    return new


def _replace(mesh: Mesh, made: Carried, groups: dict[int, np.ndarray], sharp: np.ndarray) -> None:
    """Give the mesh other vertices and faces. Its shape keys stay, with the new points in all of them.

    ``sharp`` are the creases of vertices up to Blender 3.6, (n,) from 0 to 1.
    """
    other = bpy.data.meshes.new(".Sinew Remeshed")
    edit = bmesh.new()
    try:
        other.from_pydata(made.points.tolist(), [], made.faces.tolist())
        edit.from_mesh(other)
        layer = edit.verts.layers.deform.verify()
        edit.verts.ensure_lookup_table()
        for index, weights in groups.items():
            members = np.flatnonzero(~np.isnan(weights))
            for vertex, weight in zip(members.tolist(), weights[members].tolist(), strict=True):
                edit.verts[vertex][layer][index] = weight
        if sharp.any():
            crease = edit.verts.layers.crease.verify()
            for vertex, value in zip(edit.verts, sharp.tolist(), strict=True):
                vertex[crease] = value
        edit.to_mesh(mesh)
    finally:
        edit.free()
        bpy.data.meshes.remove(other)


def _attributes(mesh: Mesh) -> Iterable[tuple[str, str, str, np.ndarray]]:
    """Name, type, domain and values of each attribute that has no other way of being read."""
    for attribute in mesh.attributes:
        name, kind, domain = attribute.name, attribute.data_type, attribute.domain
        if (
            (name.startswith(".") and name not in _SCULPTED)
            or name in _OWN
            or name in mesh.uv_layers
            or kind not in _FIELDS
            or domain == "EDGE"
        ):
            continue
        field, columns, _mixed = _FIELDS[kind]
        sort = float if kind.startswith(("FLOAT", "BYTE")) else bool if kind == "BOOLEAN" else int
        yield name, kind, domain, _read(attribute.data, field, sort, columns)


def _write(mesh: Mesh, name: str, kind: str, domain: str, values: np.ndarray, made: Carried) -> None:
    """Carry an attribute over to the new elements."""
    field, _columns, mixed = _FIELDS[kind]
    carry: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "POINT": made.at_vertices if mixed else made.nearest_at_vertices,
        "CORNER": made.at_corners if mixed else made.nearest_at_corners,
        "FACE": lambda old: old[made.face_sources],
    }
    new = np.ascontiguousarray(carry[domain](values), dtype=values.dtype)
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
    attribute.data.foreach_set(field, new.ravel())


def _edge_indices(mesh: Mesh, pairs: np.ndarray) -> np.ndarray:
    """The index of the edge between each pair of vertices."""
    edges = np.sort(read_edges(mesh).astype(np.int64), axis=1) @ (len(mesh.vertices), 1)
    order = np.argsort(edges)
    wanted = np.sort(pairs.astype(np.int64), axis=1) @ (len(mesh.vertices), 1)
    return order[np.searchsorted(edges[order], wanted)]
