# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh after all modifiers, with a map from its vertices to those of the deformer.

Later modifiers may add vertices: copies (Mirror, Array, Solidify), or new ones in between (Subdivision).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...compat import read_edges, read_positions, read_triangles
from ...core import status
from ...core.status import Level
from ...mesh_io import read_attributes, read_incoming
from ...properties import SinewDeformer
from ..datablocks import refined
from ..state.evaluation import is_shown
from ..targets import modified, targets
from .result import Result


@dataclass(frozen=True)
class FinalMesh:
    """``points`` are float32 (m, 3) in object space, ``triangles`` int32 (t, 3).

    If later modifiers added vertices, ``origin`` int32 (m,) is the vertex of the deformer that each vertex is
    or copies, and -1 for vertices in between, which the ``edges`` (e, 2) connect to the others. Else both are
    None.
    """

    points: np.ndarray
    triangles: np.ndarray
    origin: np.ndarray | None = None
    edges: np.ndarray | None = None


def find(obj: Object, depsgraph: Depsgraph, deformer: SinewDeformer, result: Result) -> FinalMesh:
    """The mesh as shown now, or the shape after the deformer if later modifiers lose the order of vertices.

    In Edit Mode Blender gives no access to the final mesh, so there it is the shape after the deformer too.
    """
    evaluated, count = obj.evaluated_get(depsgraph), len(result.points)
    if obj.mode == "EDIT" or evaluated.type != "MESH":
        return FinalMesh(result.points, result.triangles)
    with _final_mesh(obj, evaluated) as mesh:
        if refined.keeps_nothing(obj):
            origin = np.full(len(mesh.vertices), -1, dtype=np.int32)
            origin[:count] = np.arange(count)
            return FinalMesh(read_positions(mesh), read_triangles(mesh), origin, read_edges(mesh))
        names = modified.attribute_names(deformer.uid)
        if read_incoming(mesh, *names, count).points is None:
            return FinalMesh(result.points, result.triangles)
        if len(mesh.vertices) == count:
            return FinalMesh(read_positions(mesh), result.triangles)
        incoming, index = read_attributes(mesh, *names)
        inside = np.clip(index, 0, count - 1)
        copies = (index == inside) & (incoming == incoming[inside]).all(axis=1)
        origin = np.where(copies, inside, -1)
        return FinalMesh(read_positions(mesh), read_triangles(mesh), origin, read_edges(mesh))


def is_current(obj: Object, deformer: SinewDeformer) -> bool:
    """Whether the mesh is the one that was bound: no error, and no vertices added or removed in Edit Mode."""
    if status.current(deformer.uid).level is Level.ERROR:
        return False
    if obj.mode != "EDIT":
        return True
    return targets.is_mesh(obj) and len(bmesh.from_edit_mesh(obj.data).verts) == len(obj.data.vertices)


@contextmanager
def _final_mesh(obj: Object, evaluated: Object) -> Iterator[Mesh]:
    """The evaluated mesh. After a Subdivision it may be on the graphics card only, so this makes a copy."""
    visible = [modifier for modifier in obj.modifiers if is_shown(modifier, "VIEWPORT")]
    if not visible or visible[-1].type != "SUBSURF":
        yield evaluated.data
        return
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()
