# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes vertex groups of the selection in Edit Mode, and selects groups and elements. Main thread only."""

from collections.abc import Sequence

import bmesh
import numpy as np
from bpy.types import Object

from ...core.elements import Elements, Owner
from ...core.errors import ConstraintError, SinewError
from ...core.methods import Control
from ...properties import SinewDeformer
from ..datablocks import parts
from ..state import sessions
from ..targets import targets
from .handles.region_names import name_of_region


def counts(obj: Object) -> tuple[int, int]:
    """How many vertices of a mesh in Edit Mode are selected, and how many it has; none is looked at."""
    return obj.data.total_vert_sel, len(bmesh.from_edit_mesh(obj.data).verts)


def group_from_selection(obj: Object, role: str, name: str = "") -> str:
    """A new vertex group of the vertices selected in Edit Mode, called after their place without a name."""
    edit = bmesh.from_edit_mesh(obj.data)
    chosen = np.array([vertex.select for vertex in edit.verts], dtype=bool)
    if not chosen.any():
        raise ConstraintError("Nothing is selected - select the vertices of the region first")
    points = np.array([vertex.co for vertex in edit.verts], dtype=np.float64)
    group = obj.vertex_groups.new(name=name or name_of_region(obj, role, points, chosen))
    layer = edit.verts.layers.deform.verify()
    for vertex in edit.verts:
        if vertex.select:
            vertex[layer][group.index] = 1.0
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    return group.name


def group_of(obj: Object, name: str, vertices: Sequence[int]) -> str:
    """A new vertex group of these vertices, outside Edit Mode."""
    group = obj.vertex_groups.new(name=name)
    group.add([int(vertex) for vertex in vertices], 1.0, "REPLACE")
    return group.name


def parts_inside(deformer: SinewDeformer) -> np.ndarray:
    """The vertices of the loose parts that follow the surface and lie inside of it."""
    known = sessions.find(deformer.uid)
    bound = known.bound if known is not None else None
    moves_surface = deformer.definition.control is Control.HANDLES and not deformer.definition.is_space
    if bound is None or not moves_surface or len(bound.rest.points) != targets.size(deformer.id_data):
        return np.zeros(0, dtype=int)
    return parts.inside(bound.rest, bound.factor.report.riding_vertices)


def select_group(obj: Object, vertex_group: str) -> None:
    """Select the vertices of a group, in Edit Mode."""
    group = obj.vertex_groups.get(vertex_group)
    if group is None:
        raise SinewError(f"{obj.name} has no vertex group '{vertex_group}'")
    edit = bmesh.from_edit_mesh(obj.data)
    layer = edit.verts.layers.deform.active
    members = [] if layer is None else [v.index for v in edit.verts if v[layer].get(group.index, 0.0) > 0.0]
    select_elements(obj, Elements(Owner.TARGET, "vertex", members))


def select_elements(obj: Object, elements: Elements) -> int:
    """Select vertices, faces or points of a lattice by index, in Edit Mode; returns how many there are."""
    if obj.type == "LATTICE":
        chosen = set(elements.indices)
        for index, point in enumerate(obj.data.points):
            point.select = index in chosen
        return sum(point.select for point in obj.data.points)
    edit = bmesh.from_edit_mesh(obj.data)
    for vertex in edit.verts:
        vertex.select = False
    edit.select_flush(False)
    sequence = edit.faces if elements.element == "face" else edit.verts
    sequence.ensure_lookup_table()
    wanted = [index for index in elements.indices if index < len(sequence)]
    for index in wanted:
        sequence[index].select = True
    edit.select_flush(True)
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    return len(wanted)
