# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups of a file, one per point type. They show a shape mesh.

The group for vertices also stores the incoming positions, which the next solve reads.

    incoming -> store position and index -> Set Position(mix(incoming, shape, Factor * Mask)) where the
    counts agree

The last vertex of the shape mesh holds Factor and the type of shape (``mesh_io/shape.py``).
"""

from collections.abc import Callable
from functools import partial, reduce

import bpy
from bpy.types import GeometryNodeTree, Modifier, NodesModifier, NodeSocket

from ... import compat
from ...core.point_types import BEZIER, MESH, PointType
from ...ids import Datablocks, Inputs, Keys
from .nodes import Builder

_VERSION = 1
_SIDES = ("LEFT", "RIGHT")
_COMPONENTS = {"MESH": "Mesh", "CURVE": "Curve", "POINTCLOUD": "Point Cloud"}  # as sockets are called


def ensure(point_type: PointType) -> GeometryNodeTree:
    """The file's group for a point type, made if missing. Identified by a custom property, not by name."""
    for group in bpy.data.node_groups:
        is_current = group.get(Keys.GROUP_VERSION) == _VERSION and group.library is None
        if is_current and _fits(group, point_type) and _is_whole(group):
            return group
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    group[Keys.GROUP_VERSION] = _VERSION
    group[Keys.GROUP_POINT_TYPE] = _name(point_type)
    _interface(group)
    _nodes(group, point_type)
    return group


def shows(modifier: NodesModifier, point_type: PointType) -> bool:
    """The modifier has the group for this point type."""
    return modifier.node_group is not None and _fits(modifier.node_group, point_type)


def _fits(group: GeometryNodeTree, point_type: PointType) -> bool:
    return group.get(Keys.GROUP_POINT_TYPE, _name(MESH)) == _name(point_type)


def _name(point_type: PointType) -> str:
    """What a group is known by: point types with the same name share a group."""
    return f"{point_type.component} {point_type.points_per_element}"


def _is_whole(group: GeometryNodeTree) -> bool:
    """Whether the group still has all its inputs."""
    names = (Inputs.PROXY_VIEWPORT, Inputs.PROXY_RENDER, Inputs.MASK, Inputs.INCOMING, Inputs.INDEX)
    return group.bl_idname == "GeometryNodeTree" and all(
        compat.has_group_input(group, name) for name in names
    )


def is_ours(modifier: Modifier) -> bool:
    """Whether the modifier shows a deformer."""
    return (
        modifier.type == "NODES"
        and modifier.node_group is not None
        and Keys.GROUP_VERSION in modifier.node_group
    )


def attach(modifier: NodesModifier, group: GeometryNodeTree) -> None:
    """Set the group of a new modifier. Blender 3.x has given it an empty group, which is removed."""
    empty = modifier.node_group
    modifier.node_group = group
    if empty is not None:
        bpy.data.node_groups.remove(empty)


def _interface(group: GeometryNodeTree) -> None:
    compat.add_group_input(group, "NodeSocketGeometry", "Geometry")
    compat.add_group_input(group, "NodeSocketObject", Inputs.PROXY_VIEWPORT, "The shape shown in viewports")
    compat.add_group_input(group, "NodeSocketObject", Inputs.PROXY_RENDER, "The shape shown in renders")
    compat.add_group_input(group, "NodeSocketString", Inputs.MASK, "Vertex group that limits the deformation")
    compat.add_group_input(
        group, "NodeSocketString", Inputs.INCOMING, "Where the incoming positions are kept"
    )
    compat.add_group_input(group, "NodeSocketString", Inputs.INDEX, "Where the incoming indices are kept")
    compat.add_group_output(group, "NodeSocketGeometry", "Geometry")
    compat.hide_in_modifier(
        group, (Inputs.PROXY_VIEWPORT, Inputs.PROXY_RENDER, Inputs.INCOMING, Inputs.INDEX)
    )


def _nodes(group: GeometryNodeTree, point_type: PointType) -> None:
    build = Builder(group)
    entry = build.add("NodeGroupInput")
    position = build.add("GeometryNodeInputPosition").outputs[0]
    index = build.add("GeometryNodeInputIndex").outputs[0]

    kept = entry.outputs["Geometry"]
    if point_type.component == MESH.component:
        for name, typ, value in ((Inputs.INCOMING, "FLOAT_VECTOR", position), (Inputs.INDEX, "INT", index)):
            kept = build.store(kept, typ, entry.outputs[name], value)
    else:
        kept, rejoin = _apart(build, kept, point_type.component)
    alone = kept

    shapes = [
        build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=entry.outputs[name])
        for name in (Inputs.PROXY_RENDER, Inputs.PROXY_VIEWPORT)
    ]
    in_viewport = build.add("GeometryNodeIsViewport").outputs[0]
    shape = build.switch("GEOMETRY", in_viewport, *(build.out(node, "Geometry") for node in shapes))

    points = build.count(entry.outputs["Geometry"], point_type.component)
    per_element = point_type.points_per_element
    count = points if per_element == 1 else build.math("MULTIPLY", points, float(per_element))
    fits = build.math("COMPARE", build.math("ADD", count, 1.0), build.count(shape, "MESH"))
    last = build.add("ShaderNodeSeparateXYZ", Vector=build.sample(shape, position, count)).outputs
    is_displacement = build.math("GREATER_THAN", last[1], 0.5)

    mask = build.add(
        "GeometryNodeInputNamedAttribute", {"data_type": "FLOAT"}, Name=entry.outputs[Inputs.MASK]
    )
    exists = build.out(mask, "Exists")
    if exists is None:  # Blender 3.4: an empty name means no mask
        length = build.add("FunctionNodeStringLength", String=entry.outputs[Inputs.MASK]).outputs[0]
        exists = build.math("GREATER_THAN", length, 0.5)
    painted = build.switch("FLOAT", exists, 1.0, build.out(mask, "Attribute"))
    share = build.math("MULTIPLY", last[0], painted)

    def moved(before: NodeSocket, part: int) -> NodeSocket:
        """Where the positions ``before`` are moved to by this part of the shape mesh."""
        at = index if part == 0 else build.math("ADD", index, build.math("MULTIPLY", points, float(part)))
        sampled = build.sample(shape, position, at)
        added = build.add("ShaderNodeVectorMath", {"operation": "ADD"})
        build.feed(added.inputs[0], before)
        build.feed(added.inputs[1], sampled)
        goal = build.switch("VECTOR", is_displacement, sampled, added.outputs[0])
        settings = {"data_type": "VECTOR", "clamp_factor": True}  # painted weights may be a little above 1
        return build.out(build.add("ShaderNodeMix", settings, Factor=share, A=before, B=goal), "Result")

    if point_type is BEZIER:  # handles of other types would follow rules of their own
        settings = {"handle_type": "FREE", "mode": {"LEFT", "RIGHT"}}
        kept = build.out(
            build.add("GeometryNodeCurveSetHandles", settings, Curve=kept, Selection=fits), "Curve"
        )
    node = build.add("GeometryNodeSetPosition", Geometry=kept, Selection=fits, Position=moved(position, 0))
    shown = build.out(node, "Geometry")
    for part, side in enumerate(_SIDES[: point_type.points_per_element - 1], 1):
        handle = build.handle(side)
        before = build.sample(alone, handle, index)  # in ``shown`` points took their handles along
        node = build.add(
            "GeometryNodeSetCurveHandlePositions",
            {"mode": side},
            Curve=shown,
            Selection=fits,
            Position=moved(before, part),
        )
        shown = build.out(node, "Curve")
    if point_type.component != MESH.component:
        shown = rejoin(shown)
    build.feed(build.add("NodeGroupOutput").inputs["Geometry"], shown)


def _apart(
    build: Builder, geometry: NodeSocket, component: str
) -> tuple[NodeSocket, Callable[[NodeSocket], NodeSocket]]:
    """Separate one geometry component; returns it and a function that joins the others back.

    If there are no others, nothing is taken apart, because sculpting needs the geometry as it is. Meshes are
    never taken apart, as that may cost a copy.
    """
    parts = build.add("GeometryNodeSeparateComponents", Geometry=geometry).outputs
    counts = [build.count(geometry, other) for other in (*_COMPONENTS, "INSTANCES") if other != component]
    has_others = build.math("GREATER_THAN", reduce(partial(build.math, "ADD"), counts), 0.5)

    def rejoin(moved: NodeSocket) -> NodeSocket:
        others = [part for part in parts if part.name != _COMPONENTS[component]]
        return build.switch("GEOMETRY", has_others, moved, build.join((moved, *others)))

    return build.switch("GEOMETRY", has_others, geometry, parts[_COMPONENTS[component]]), rejoin
