# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds geometry nodes by their type. Sockets are found by name."""

from collections.abc import Iterable, Mapping

from bpy.types import GeometryNodeTree, NodeSocket

from ... import compat


class Builder:
    """Adds nodes to a group and links them, from left to right."""

    def __init__(self, group: GeometryNodeTree) -> None:
        self.group = group
        self.column = 0

    def add(self, node_type: str, settings: Mapping[str, object] | None = None, **inputs):
        """A new node with these settings, and its inputs set or linked. Spaces in names are written ``_``."""
        node = self.group.nodes.new(node_type)
        node.location = (self.column * 180, 0)
        self.column += 1
        for name, value in (settings or {}).items():
            setattr(node, name, value)
        for name, value in inputs.items():
            self.feed(compat.enabled_socket(node.inputs, name.replace("_", " ")), value)
        return node

    def feed(self, socket: NodeSocket, value: object) -> None:
        """Link a socket to an output, or set its value."""
        if isinstance(value, NodeSocket):
            self.group.links.new(value, socket)
        else:
            socket.default_value = value

    def out(self, node, name: str) -> NodeSocket:
        """The enabled output of this name."""
        return compat.enabled_socket(node.outputs, name)

    def math(self, operation: str, a: object, b: object) -> NodeSocket:
        """The output of an operation with two numbers."""
        node = self.add("ShaderNodeMath", {"operation": operation})
        self.feed(node.inputs[0], a)
        self.feed(node.inputs[1], b)
        if operation == "COMPARE":
            node.inputs[2].default_value = 0.5
        return node.outputs[0]

    def store(self, geometry: NodeSocket, data_type: str, name: object, value: NodeSocket) -> NodeSocket:
        """The geometry with one more attribute of its points."""
        node = self.add(
            "GeometryNodeStoreNamedAttribute",
            {"data_type": data_type, "domain": "POINT"},
            Geometry=geometry,
            Name=name,
            Value=value,
        )
        return self.out(node, "Geometry")

    def count(self, geometry: NodeSocket, component: str) -> NodeSocket:
        """How many points, or instances, a component of the geometry has."""
        node = self.add("GeometryNodeAttributeDomainSize", {"component": component}, Geometry=geometry)
        return self.out(node, "Instance Count" if component == "INSTANCES" else "Point Count")

    def sample(self, geometry: NodeSocket, value: NodeSocket, at: NodeSocket) -> NodeSocket:
        """A vector of the point number ``at`` of the geometry."""
        settings = {"data_type": "FLOAT_VECTOR", "domain": "POINT"}
        node = self.add("GeometryNodeSampleIndex", settings, Geometry=geometry, Value=value, Index=at)
        return self.out(node, "Value")

    def join(self, geometries: Iterable[NodeSocket]) -> NodeSocket:
        """The geometries joined into one."""
        node = self.add("GeometryNodeJoinGeometry")
        for geometry in geometries:
            self.feed(node.inputs[0], geometry)
        return self.out(node, "Geometry")

    def handle(self, side: str) -> NodeSocket:
        """The position of the LEFT or RIGHT handle of each point of a curve."""
        return self.add("GeometryNodeInputCurveHandlePositions").outputs[side.title()]

    def switch(self, input_type: str, choose: NodeSocket, no: object, yes: object) -> NodeSocket:
        """``yes`` where ``choose`` is true, else ``no``."""
        sides = {"Switch": choose, "False": no, "True": yes}
        return self.out(self.add("GeometryNodeSwitch", {"input_type": input_type}, **sides), "Output")
