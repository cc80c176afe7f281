# SPDX-License-Identifier: GPL-3.0-or-later
"""The one node group of a file. It shows a shape mesh, and stores what came in for the next solve.

    incoming -> store position and index -> Set Position(mix(incoming, shape, Factor * Mask)) where the
    counts agree

Factor and the kind of shape ride in the last vertex of the shape mesh (``mesh_io/shape.py``).
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import GeometryNodeTree, Modifier, NodesModifier, NodeSocket, Object

from .. import compat
from ..ids import Datablocks, Inputs, Keys

_VERSION = 1


class _Builder:
    """Nodes by type, sockets by name."""

    def __init__(self, group: GeometryNodeTree) -> None:
        self.group = group
        self.column = 0

    def add(self, node_type: str, settings: dict[str, str] | None = None, **inputs):
        """A node with its settings, its inputs set or linked; spaces in names are written ``_``."""
        node = self.group.nodes.new(node_type)
        node.location = (self.column * 180, 0)
        self.column += 1
        for name, value in (settings or {}).items():
            setattr(node, name, value)
        for name, value in inputs.items():
            self.feed(compat.enabled_socket(node.inputs, name.replace("_", " ")), value)
        return node

    def feed(self, socket: NodeSocket, value: object) -> None:
        """Link a socket, or set its value."""
        if isinstance(value, NodeSocket):
            self.group.links.new(value, socket)
        else:
            socket.default_value = value

    def out(self, node, name: str) -> NodeSocket:
        """An output by name."""
        return compat.enabled_socket(node.outputs, name)

    def math(self, operation: str, a: object, b: object) -> NodeSocket:
        """A scalar operation."""
        node = self.add("ShaderNodeMath", {"operation": operation})
        self.feed(node.inputs[0], a)
        self.feed(node.inputs[1], b)
        if operation == "COMPARE":
            node.inputs[2].default_value = 0.5
        return node.outputs[0]

    def store(self, geometry: NodeSocket, kind: str, name: object, value: NodeSocket) -> NodeSocket:
        """The geometry with a point attribute more."""
        node = self.add(
            "GeometryNodeStoreNamedAttribute",
            {"data_type": kind, "domain": "POINT"},
            Geometry=geometry,
            Name=name,
            Value=value,
        )
        return self.out(node, "Geometry")

    def switch(self, kind: str, choose: NodeSocket, no: object, yes: object) -> NodeSocket:
        """``yes`` where ``choose``, else ``no``."""
        sides = {"Switch": choose, "False": no, "True": yes}
        return self.out(self.add("GeometryNodeSwitch", {"input_type": kind}, **sides), "Output")


def ensure() -> GeometryNodeTree:
    """The file's group, made when missing. Recognised by a custom property, never by name."""
    for group in bpy.data.node_groups:
        if group.get(Keys.GROUP_VERSION) == _VERSION and group.library is None and _is_whole(group):
            return group
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    group[Keys.GROUP_VERSION] = _VERSION
    _interface(group)
    _nodes(group)
    return group


def _is_whole(group: GeometryNodeTree) -> bool:
    """Nobody took an input away."""
    names = (Inputs.PROXY_VIEWPORT, Inputs.PROXY_RENDER, Inputs.MASK, Inputs.INCOMING, Inputs.INDEX)
    return group.bl_idname == "GeometryNodeTree" and all(
        compat.has_group_input(group, name) for name in names
    )


def is_ours(modifier: Modifier) -> bool:
    """The modifier shows a deformer."""
    return (
        modifier.type == "NODES"
        and modifier.node_group is not None
        and Keys.GROUP_VERSION in modifier.node_group
    )


def attach(modifier: NodesModifier, group: GeometryNodeTree) -> None:
    """Set a new modifier's group. Blender 3.x gives it an empty group of its own, which goes."""
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


def _nodes(group: GeometryNodeTree) -> None:
    build = _Builder(group)
    entry = build.add("NodeGroupInput")
    position = build.add("GeometryNodeInputPosition").outputs[0]
    index = build.add("GeometryNodeInputIndex").outputs[0]

    kept = entry.outputs["Geometry"]
    for name, kind, value in ((Inputs.INCOMING, "FLOAT_VECTOR", position), (Inputs.INDEX, "INT", index)):
        kept = build.store(kept, kind, entry.outputs[name], value)

    shapes = [
        build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=entry.outputs[name])
        for name in (Inputs.PROXY_RENDER, Inputs.PROXY_VIEWPORT)
    ]
    in_viewport = build.add("GeometryNodeIsViewport").outputs[0]
    shape = build.switch("GEOMETRY", in_viewport, *(build.out(node, "Geometry") for node in shapes))

    count, shape_count = (
        build.out(
            build.add("GeometryNodeAttributeDomainSize", {"component": "MESH"}, Geometry=geometry),
            "Point Count",
        )
        for geometry in (entry.outputs["Geometry"], shape)
    )
    fits = build.math("COMPARE", build.math("ADD", count, 1.0), shape_count)

    def sample(at: NodeSocket) -> NodeSocket:
        settings = {"data_type": "FLOAT_VECTOR", "domain": "POINT"}
        node = build.add("GeometryNodeSampleIndex", settings, Geometry=shape, Value=position, Index=at)
        return build.out(node, "Value")

    moved = sample(index)
    last = build.add("ShaderNodeSeparateXYZ", Vector=sample(count)).outputs
    added = build.add("ShaderNodeVectorMath", {"operation": "ADD"})
    build.feed(added.inputs[0], position)
    build.feed(added.inputs[1], moved)
    is_displacement = build.math("GREATER_THAN", last[1], 0.5)
    goal = build.switch("VECTOR", is_displacement, moved, added.outputs[0])

    mask = build.add(
        "GeometryNodeInputNamedAttribute", {"data_type": "FLOAT"}, Name=entry.outputs[Inputs.MASK]
    )
    exists = build.out(mask, "Exists")
    if exists is None:  # Blender 3.4: an empty name means no mask
        length = build.add("FunctionNodeStringLength", String=entry.outputs[Inputs.MASK]).outputs[0]
        exists = build.math("GREATER_THAN", length, 0.5)
    painted = build.switch("FLOAT", exists, 1.0, build.out(mask, "Attribute"))

    mix = build.add(
        "ShaderNodeMix",
        {"data_type": "VECTOR", "clamp_factor": False},
        Factor=build.math("MULTIPLY", last[0], painted),
        A=position,
        B=goal,
    )
    shown = build.add(
        "GeometryNodeSetPosition", Geometry=kept, Selection=fits, Position=build.out(mix, "Result")
    )
    leave = build.add("NodeGroupOutput")
    build.feed(leave.inputs["Geometry"], build.out(shown, "Geometry"))


@contextmanager
def keeping_weights(obj: Object, groups: dict[str, str]) -> Iterator[None]:
    """For a while, the object's last modifier stores vertex groups as attributes.

    ``groups``: attribute name -> vertex group. Attributes are read a hundred times faster than the groups of
    each vertex.
    """
    if not groups:
        yield
        return
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    try:
        compat.add_group_input(group, "NodeSocketGeometry", "Geometry")
        compat.add_group_output(group, "NodeSocketGeometry", "Geometry")
        build = _Builder(group)
        kept = build.add("NodeGroupInput").outputs["Geometry"]
        for attribute, name in groups.items():
            weights = build.add("GeometryNodeInputNamedAttribute", {"data_type": "FLOAT"}, Name=name)
            kept = build.store(kept, "FLOAT", attribute, build.out(weights, "Attribute"))
        build.feed(build.add("NodeGroupOutput").inputs["Geometry"], kept)
        attach(obj.modifiers.new(Datablocks.MODIFIER, "NODES"), group)
        yield
    finally:
        bpy.data.node_groups.remove(group)
