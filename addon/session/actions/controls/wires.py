# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes curves that become wires: from edges, or from a drawn line. Main thread only."""

from collections import defaultdict
from collections.abc import Sequence

import bmesh
import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix

from ....compat import read_edges, read_positions
from ....core.errors import SinewError
from ....core.geometry import frames
from ....core.geometry.polylines import lengths, lines_of
from ...datablocks.parts import ShownParts
from ...state import sessions
from ...targets import targets
from ...targets.modified import evaluated_mesh
from .around import follow

_OF_LENGTH, _OF_PART = 0.35, 0.15  # the radius of a new wire, and the most of the part beside it
_RESOLUTION = 16  # places per segment of a Bezier curve: a wire is as smooth as these are near


def wire_from_edges(obj: Object, points: int) -> Object:
    """A new curve along the edges of a mesh that are selected in Edit Mode: a spline per row or ring of them.

    ``points`` as in ``wire_through``.
    """
    edit = bmesh.from_edit_mesh(obj.data) if obj.mode == "EDIT" else bmesh.new()
    try:
        if obj.mode != "EDIT":
            edit.from_mesh(obj.data)
        chosen = [edge for edge in edit.edges if edge.select and not edge.hide]
        if not chosen:
            raise SinewError("No edges are selected - select a row or a ring of edges in Edit Mode")
        lines = _chains([tuple(vertex.index for vertex in edge.verts) for edge in chosen])
        edit.verts.ensure_lookup_table()
        places = [
            (np.array([edit.verts[index].co[:] for index in line], dtype=np.float64), closed)
            for line, closed in lines
        ]
    finally:
        if obj.mode != "EDIT":
            edit.free()
    return wire_through(obj, places, points)


def wire_radius(length: float, size: float) -> float:
    """The radius that fits a wire of a length, on a part of a size."""
    return min(_OF_LENGTH * length, _OF_PART * size)


def fitting_radius(obj: Object, wire: Object) -> float:
    """The radius that fits a curve and the part of ``obj`` beside its middle, as a length of the curve.

    0 if it is no curve, or has no length.
    """
    if not targets.is_path(wire):
        return 0.0
    depsgraph = bpy.context.evaluated_depsgraph_get()
    with evaluated_mesh(wire, depsgraph) as mesh:
        points = read_positions(mesh).astype(np.float64)
        lines = lines_of(len(points), read_edges(mesh))
    world = np.array(wire.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    places, scale = frames.transformed(world, points), wire.matrix_world.median_scale
    if lines is None or not lines.counts or scale == 0.0:
        return 0.0
    size = ShownParts(obj, depsgraph).size_at(places[len(places) // 2])
    return wire_radius(max(lengths(places, lines)), size) / scale


def _chains(edges: Sequence[tuple[int, int]]) -> list[tuple[list[int], bool]]:
    """The vertices along each row of edges, and whether it is a ring. Refuses edges that meet in a fork."""
    beside: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        beside[a].append(b)
        beside[b].append(a)
    forks = [vertex for vertex, others in beside.items() if len(others) > 2]
    if forks:
        raise SinewError(
            f"The selected edges meet in {len(forks):,} forks - select rows or rings that do not touch"
        )
    found, seen = [], set()
    ends = [vertex for vertex, others in beside.items() if len(others) == 1]
    for start in (*ends, *beside):
        if start in seen:
            continue
        line = [start]
        seen.add(start)
        while (after := next((v for v in beside[line[-1]] if v not in seen), None)) is not None:
            line.append(after)
            seen.add(after)
        found.append((line, len(line) > 2 and start in beside[line[-1]]))
    return found


@sessions.suspended()
def wire_through(
    obj: Object, lines: Sequence[tuple[np.ndarray, bool]], points: int, in_world: bool = False
) -> Object:
    """A new curve through lines of places (k, 3), each perhaps closed. It follows ``obj``.

    The places are in the space of ``obj``, or in the world. ``points``: a smooth Bezier curve with so many
    points per line at most; 0 for a straight one through all.
    """
    data = bpy.data.curves.new(f"{obj.name} Wire", "CURVE")
    data.dimensions, data.resolution_u = "3D", _RESOLUTION
    for places, closed in lines:
        _add_spline(data, places, closed, points)
    wire = bpy.data.objects.new(data.name, data)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(wire)
    wire.show_in_front = True
    follow(wire, obj)
    if in_world:
        bpy.context.view_layer.update()
        data.transform(Matrix(wire.matrix_world).inverted_safe())
    bpy.context.view_layer.update()
    return wire


def _add_spline(data: bpy.types.Curve, places: np.ndarray, closed: bool, points: int) -> None:
    spline = data.splines.new("BEZIER" if points else "POLY")
    spline.use_cyclic_u = closed
    if not points:
        spline.points.add(len(places) - 1)
        spline.points.foreach_set("co", np.column_stack((places, np.ones(len(places)))).ravel())
        return
    chosen = _spread(places, closed, points)
    spline.bezier_points.add(len(chosen) - 1)
    spline.bezier_points.foreach_set("co", chosen.ravel())
    for point in spline.bezier_points:
        point.handle_left_type = point.handle_right_type = "AUTO"


def _spread(places: np.ndarray, closed: bool, count: int) -> np.ndarray:
    """At most ``count`` of the places (k, 3), about evenly along the line; of an open one with both ends."""
    count = min(max(count, 3 if closed else 2), len(places))
    around = np.concatenate((places, places[:1])) if closed else places
    ways = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))))
    wanted = np.linspace(0.0, ways[-1], count, endpoint=not closed)
    nearest = np.abs(ways[: len(places), None] - wanted).argmin(axis=0)
    return places[np.unique(nearest)]
