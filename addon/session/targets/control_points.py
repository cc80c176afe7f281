# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the points of objects that are no meshes, by temporary geometry nodes. Main thread only."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from bpy.types import GeometryNodeTree, Mesh, NodeSocket, Object

from ... import compat
from ...core.point_types import BEZIER, CURVE, POINTCLOUD, SURFACE, PointType
from ...ids import Datablocks
from .node_group import attach
from .nodes import Builder

_PART = ".sinew_part"  # in a mesh of control points: which points a vertex stands for, 0 for a surface
_POINT, _LEFT, _RIGHT, _CLOUD = 1, 2, 3, 4
_POINT_TYPES = {0: SURFACE, _POINT: CURVE, _RIGHT: BEZIER, _CLOUD: POINTCLOUD}  # by the last part in the mesh
_BEZIER = 2.0  # the number of the type of curve


@contextmanager
def showing_points(obj: Object) -> Iterator[Object]:
    """For a while, a mesh object that shows what ``obj``, of another type, is after its modifiers.

    That is the surface where it has one, else its control points as loose vertices, in the order that
    ``PointType`` describes. The handles of a point without handles lie at the point.
    """
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    mesh = bpy.data.meshes.new(Datablocks.REST)
    probe = bpy.data.objects.new(Datablocks.REST, mesh)
    try:
        compat.add_group_input(group, "NodeSocketGeometry", "Geometry")
        compat.add_group_output(group, "NodeSocketGeometry", "Geometry")
        _points_of(group, obj)
        attach(probe.modifiers.new(Datablocks.MODIFIER, "NODES"), group)
        bpy.context.scene.collection.objects.link(probe)
        yield probe
    finally:
        bpy.data.objects.remove(probe)
        bpy.data.meshes.remove(mesh)
        bpy.data.node_groups.remove(group)


def _points_of(group: GeometryNodeTree, obj: Object) -> None:
    build = Builder(group)
    info = build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=obj)
    given = build.out(info, "Geometry")
    components = build.add("GeometryNodeSeparateComponents", Geometry=given).outputs
    position = build.add("GeometryNodeInputPosition").outputs[0]
    index = build.add("GeometryNodeInputIndex").outputs[0]
    curve_type = build.add("GeometryNodeInputNamedAttribute", {"data_type": "INT"}, Name="curve_type")
    is_bezier = build.math("COMPARE", build.out(curve_type, "Attribute"), _BEZIER)
    statistic = {"data_type": "FLOAT", "domain": "POINT"}
    any_bezier = build.out(
        build.add(
            "GeometryNodeAttributeStatistic", statistic, Geometry=components["Curve"], Attribute=is_bezier
        ),
        "Max",
    )
    no_surface = build.math("COMPARE", build.count(given, "MESH"), 0.0)
    points = build.math("MULTIPLY", build.count(given, "CURVE"), no_surface)
    handles = build.math("MULTIPLY", points, any_bezier)

    joined = [components["Mesh"]]
    for part, count in ((_RIGHT, handles), (_LEFT, handles), (_POINT, points)):
        side = {_LEFT: "LEFT", _RIGHT: "RIGHT"}.get(part)
        place = position if side is None else build.switch("VECTOR", is_bezier, position, build.handle(side))
        placed = build.sample(components["Curve"], place, index)
        made = build.add("GeometryNodePoints", Count=count, Position=placed).outputs[0]
        joined.append(_vertices(build, made, part))
    no_points = build.math("MULTIPLY", no_surface, build.math("COMPARE", points, 0.0))
    joined.append(_vertices(build, components["Point Cloud"], _CLOUD, no_points))
    build.feed(build.add("NodeGroupOutput").inputs["Geometry"], build.join(joined))


def _vertices(build: Builder, points: NodeSocket, part: int, selection: object = True) -> NodeSocket:
    """Loose vertices, with an attribute that tells which ``part`` they belong to."""
    made = build.add("GeometryNodePointsToVertices", Points=points, Selection=selection)
    return build.store(build.out(made, "Mesh"), "INT", _PART, part)


def take_point_type(mesh: Mesh) -> PointType:
    """What a mesh made by ``showing_points`` holds. Removes the attribute that tells."""
    attribute = mesh.attributes.get(_PART)
    if attribute is None:
        return SURFACE
    parts = np.empty(len(attribute.data), dtype=np.int32)
    attribute.data.foreach_get("value", parts)
    mesh.attributes.remove(attribute)
    return _POINT_TYPES[int(parts.max(initial=0))]
