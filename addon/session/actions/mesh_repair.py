# SPDX-License-Identifier: GPL-3.0-or-later
"""Repairs of a mesh, one function per defect. They use Blender's own operations on a ``BMesh``.

``elements`` are the indices of the defective elements, as ``diagnosis_of`` numbers them.
"""

import bmesh
import numpy as np
from bmesh.types import BMesh, BMFace, BMLayerItem, BMVert
from mathutils import Vector

from ...backend import Diagnosis, diagnose
from ...core.geometry import frames

_EXACT = 1e-7  # of the largest coordinate


def diagnosis_of(edit: BMesh) -> Diagnosis:
    """The defects of the mesh. This renumbers its elements."""
    _number(edit)
    points = np.array([tuple(vertex.co) for vertex in edit.verts], dtype=np.float64).reshape(-1, 3)
    counts = np.array([len(face.verts) for face in edit.faces], dtype=np.int32)
    corners = np.array([vertex.index for face in edit.faces for vertex in face.verts], dtype=np.int32)
    if len(points) == 0:
        none = np.zeros(0, dtype=int)
        return Diagnosis(none, none, none, none, none, np.zeros((0, 2), dtype=int))
    return diagnose(points, (counts, corners))


def _number(edit: BMesh) -> None:
    for sequence in (edit.verts, edit.edges, edit.faces):
        sequence.index_update()
        sequence.ensure_lookup_table()


def _exact(edit: BMesh) -> float:
    """The distance below which two positions may be the same in float32."""
    return _EXACT * max((max(map(abs, v.co)) for v in edit.verts if _is_finite(v.co)), default=1.0)


def _is_finite(place) -> bool:
    return all(abs(coordinate) < frames.FARTHEST for coordinate in place)


def give_positions(edit: BMesh) -> int:
    """Move vertices without a finite position to the mean of their neighbours; remove those without any.

    This is done for each shape key separately. Returns how many vertices there were.
    """
    mended: set[BMVert] = set()
    alone: set[BMVert] = set()
    for layer in (None, *edit.verts.layers.shape.values()):
        lost = {vertex for vertex in edit.verts if not _is_finite(_position(vertex, layer))}
        mended |= lost
        left = _fill(lost, layer)
        alone = alone if layer else left
        for vertex in left - alone:
            vertex[layer] = vertex.co
    if alone:
        bmesh.ops.delete(edit, geom=list(alone), context="VERTS")
    return len(mended)


def _position(vertex: BMVert, layer: BMLayerItem | None) -> Vector:
    """The position of a vertex in a shape key, or in the mesh itself."""
    return vertex[layer] if layer else vertex.co


def _fill(lost: set[BMVert], layer: BMLayerItem | None) -> set[BMVert]:
    """Move lost vertices to the mean of neighbours that are not lost, ring by ring; those not reached."""
    while lost:
        found = {}
        for vertex in lost:
            around = [edge.other_vert(vertex) for edge in vertex.link_edges]
            known = [_position(other, layer).copy() for other in around if other not in lost]
            if known:
                found[vertex] = sum(known[1:], known[0]) / len(known)
        if not found:
            break
        for vertex, place in found.items():
            if layer:
                vertex[layer] = place
            else:
                vertex.co = place
        lost = lost.difference(found)
    return lost


def _merge(edit: BMesh, _elements: np.ndarray, distance: float) -> None:
    """Merge vertices of open borders only: closed parts that touch are meant to be separate."""
    border = [vertex for vertex in edit.verts if vertex.is_boundary]
    bmesh.ops.remove_doubles(edit, verts=border, dist=max(distance, _exact(edit)))


def _dissolve(edit: BMesh, elements: np.ndarray, _distance: float) -> None:
    """Collapse faces without area. If that fails, remove the face, which leaves no visible hole."""
    edges = {edge for index in elements for edge in edit.faces[index].edges}
    bmesh.ops.dissolve_degenerate(edit, edges=list(edges), dist=_exact(edit))
    left = diagnosis_of(edit).degenerate_faces
    _delete_faces(edit, [edit.faces[index] for index in left])


def _delete_faces(edit: BMesh, faces: list[BMFace]) -> None:
    """Remove faces, and the edges and vertices that belong to no other face."""
    bmesh.ops.delete(edit, geom=faces, context="FACES")


def _drop_duplicates(edit: BMesh, elements: np.ndarray, _distance: float) -> None:
    bmesh.ops.delete(edit, geom=[edit.faces[index] for index in elements], context="FACES_ONLY")


def _part_edges(edit: BMesh, _elements: np.ndarray, _distance: float) -> None:
    """Remove fins and inner walls, so that at most two faces are left on their edges."""
    fins = [face for face in edit.faces if _is_fin(face)]
    sole = set(fins)
    _delete_faces(edit, [face for face in fins if _leaves_surface(face, sole)])
    walls = [face for face in edit.faces if all(len(edge.link_faces) > 2 for edge in face.edges)]
    for face in walls:
        if all(len(edge.link_faces) > 2 for edge in face.edges):
            _delete_faces(edit, [face])


def _is_fin(face: BMFace) -> bool:
    """Whether one edge of the face lies on more than two faces, and the others on no other face."""
    numbers = sorted(len(edge.link_faces) for edge in face.edges)
    return numbers[-1] > 2 and numbers[-2] == 1


def _leaves_surface(fin: BMFace, fins: set[BMFace]) -> bool:
    """Whether two faces remain on the edge of a fin when all fins are removed."""
    return any(
        len(edge.link_faces) > 2 and sum(face not in fins for face in edge.link_faces) == 2
        for edge in fin.edges
    )


def _drop_loose(edit: BMesh, elements: np.ndarray, _distance: float) -> None:
    """Remove loose vertices, but not from a mesh without faces, which is meant to be a wire."""
    if len(edit.faces):
        loose: list[BMVert] = [edit.verts[index] for index in elements]
        bmesh.ops.delete(edit, geom=loose, context="VERTS")


def _turn(edit: BMesh, elements: np.ndarray, _distance: float) -> None:
    """Turn faces over that look the other way than the rest of their part, or into a closed one."""
    bmesh.ops.reverse_faces(edit, faces=[edit.faces[index] for index in elements])


def _part_fans(edit: BMesh, elements: np.ndarray, _distance: float) -> None:
    """Give each fan of faces around a vertex a vertex of its own."""
    for vertex in [edit.verts[index] for index in elements]:
        bmesh.utils.vert_separate(vertex, [])


def _fill_holes(edit: BMesh, _elements: np.ndarray, _distance: float) -> None:
    """Close each border by a face."""
    bmesh.ops.holes_fill(edit, edges=[edge for edge in edit.edges if edge.is_boundary], sides=0)


STEPS = {
    "coincident": _merge,
    "degenerate": _dissolve,
    "duplicate": _drop_duplicates,
    "non_manifold": _part_edges,
    "loose": _drop_loose,
}
# What an artist chooses: these change the mesh more than Repair does.
CHOSEN = {"flipped": _turn, "pinched": _part_fans, "border": _fill_holes}
