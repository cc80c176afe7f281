# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups of a file, one for each kind of points. They show a shape mesh.

That of vertices also stores what came in for the next solve.

    incoming -> store position and index -> Set Position(mix(incoming, shape, Factor * Mask)) where the
    counts agree

Factor and the kind of shape ride in the last vertex of the shape mesh (``mesh_io/shape.py``).
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial, reduce

import bpy
import numpy as np
from bpy.types import GeometryNodeTree, Mesh, Modifier, NodesModifier, NodeSocket, Object

from .. import compat
from ..core.kinds import BEZIER, CURVE, MESH, POINTCLOUD, SURFACE, Kind
from ..ids import Datablocks, Inputs, Keys

_VERSION = 1
_PART = ".sinew_part"  # in a mesh of control points: which part of which kind a vertex is, 0 for a surface
_POINT, _LEFT, _RIGHT, _CLOUD = 1, 2, 3, 4
_KINDS = {0: SURFACE, _POINT: CURVE, _RIGHT: BEZIER, _CLOUD: POINTCLOUD}  # by the last part there is
_SIDES = ("LEFT", "RIGHT")
_COMPONENTS = {"MESH": "Mesh", "CURVE": "Curve", "POINTCLOUD": "Point Cloud"}  # as sockets are called
_BEZIER = 2.0  # the number of the type of curve


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
        """All of them in one."""
        node = self.add("GeometryNodeJoinGeometry")
        for geometry in geometries:
            self.feed(node.inputs[0], geometry)
        return self.out(node, "Geometry")

    def handle(self, side: str) -> NodeSocket:
        """Where the handle of each point of a curve is, LEFT or RIGHT."""
        return self.add("GeometryNodeInputCurveHandlePositions").outputs[side.title()]

    def vertices(self, points: NodeSocket, part: int, selection: object = True) -> NodeSocket:
        """Loose vertices, which remember what ``part`` they are."""
        made = self.add("GeometryNodePointsToVertices", Points=points, Selection=selection)
        return self.store(self.out(made, "Mesh"), "INT", _PART, part)

    def switch(self, kind: str, choose: NodeSocket, no: object, yes: object) -> NodeSocket:
        """``yes`` where ``choose``, else ``no``."""
        sides = {"Switch": choose, "False": no, "True": yes}
        return self.out(self.add("GeometryNodeSwitch", {"input_type": kind}, **sides), "Output")


def ensure(kind: Kind) -> GeometryNodeTree:
    """The file's group for a kind, made when missing. Recognised by custom properties, never by name."""
    for group in bpy.data.node_groups:
        is_current = group.get(Keys.GROUP_VERSION) == _VERSION and group.library is None
        if is_current and _fits(group, kind) and _is_whole(group):
            return group
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    group[Keys.GROUP_VERSION] = _VERSION
    group[Keys.GROUP_KIND] = _name(kind)
    _interface(group)
    _nodes(group, kind)
    return group


def shows(modifier: NodesModifier, kind: Kind) -> bool:
    """The modifier has the group for this kind."""
    return modifier.node_group is not None and _fits(modifier.node_group, kind)


def _fits(group: GeometryNodeTree, kind: Kind) -> bool:
    return group.get(Keys.GROUP_KIND, _name(MESH)) == _name(kind)


def _name(kind: Kind) -> str:
    """Kinds of one name share a group."""
    return f"{kind.component} {kind.parts}"


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


def _nodes(group: GeometryNodeTree, kind: Kind) -> None:
    build = _Builder(group)
    entry = build.add("NodeGroupInput")
    position = build.add("GeometryNodeInputPosition").outputs[0]
    index = build.add("GeometryNodeInputIndex").outputs[0]

    kept = entry.outputs["Geometry"]
    if kind.component == MESH.component:
        for name, typ, value in ((Inputs.INCOMING, "FLOAT_VECTOR", position), (Inputs.INDEX, "INT", index)):
            kept = build.store(kept, typ, entry.outputs[name], value)
    else:
        kept, rejoin = _apart(build, kept, kind.component)
    alone = kept

    shapes = [
        build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=entry.outputs[name])
        for name in (Inputs.PROXY_RENDER, Inputs.PROXY_VIEWPORT)
    ]
    in_viewport = build.add("GeometryNodeIsViewport").outputs[0]
    shape = build.switch("GEOMETRY", in_viewport, *(build.out(node, "Geometry") for node in shapes))

    points = build.count(entry.outputs["Geometry"], kind.component)
    count = points if kind.parts == 1 else build.math("MULTIPLY", points, float(kind.parts))
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
        """Where ``before`` goes, by this part of the shape."""
        at = index if part == 0 else build.math("ADD", index, build.math("MULTIPLY", points, float(part)))
        sampled = build.sample(shape, position, at)
        added = build.add("ShaderNodeVectorMath", {"operation": "ADD"})
        build.feed(added.inputs[0], before)
        build.feed(added.inputs[1], sampled)
        goal = build.switch("VECTOR", is_displacement, sampled, added.outputs[0])
        settings = {"data_type": "VECTOR", "clamp_factor": False}
        return build.out(build.add("ShaderNodeMix", settings, Factor=share, A=before, B=goal), "Result")

    if kind is BEZIER:  # handles of other types would follow rules of their own
        settings = {"handle_type": "FREE", "mode": {"LEFT", "RIGHT"}}
        kept = build.out(
            build.add("GeometryNodeCurveSetHandles", settings, Curve=kept, Selection=fits), "Curve"
        )
    node = build.add("GeometryNodeSetPosition", Geometry=kept, Selection=fits, Position=moved(position, 0))
    shown = build.out(node, "Geometry")
    for part, side in enumerate(_SIDES[: kind.parts - 1], 1):
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
    if kind.component != MESH.component:
        shown = rejoin(shown)
    build.feed(build.add("NodeGroupOutput").inputs["Geometry"], shown)


def _apart(
    build: _Builder, geometry: NodeSocket, component: str
) -> tuple[NodeSocket, Callable[[NodeSocket], NodeSocket]]:
    """One component alone, and what joins the others to it again: instances, say, are not moved by its shape.

    Where there are no others, nothing is taken apart, which keeps what sculpting needs. Meshes never are: it
    might cost a copy.
    """
    parts = build.add("GeometryNodeSeparateComponents", Geometry=geometry).outputs
    counts = [build.count(geometry, other) for other in (*_COMPONENTS, "INSTANCES") if other != component]
    has_others = build.math("GREATER_THAN", reduce(partial(build.math, "ADD"), counts), 0.5)

    def rejoin(moved: NodeSocket) -> NodeSocket:
        others = [part for part in parts if part.name != _COMPONENTS[component]]
        return build.switch("GEOMETRY", has_others, moved, build.join((moved, *others)))

    return build.switch("GEOMETRY", has_others, geometry, parts[_COMPONENTS[component]]), rejoin


@contextmanager
def showing_points(obj: Object) -> Iterator[Object]:
    """For a while, a mesh object that shows what ``obj``, of another type, is after its modifiers.

    That is the surface where it has one, else its control points as loose vertices, in parts as ``Kind``
    says. Where a point has no handles, they are where it is.
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
    build = _Builder(group)
    info = build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=obj)
    given = build.out(info, "Geometry")
    components = build.add("GeometryNodeSeparateComponents", Geometry=given).outputs
    position = build.add("GeometryNodeInputPosition").outputs[0]
    index = build.add("GeometryNodeInputIndex").outputs[0]
    kind = build.add("GeometryNodeInputNamedAttribute", {"data_type": "INT"}, Name="curve_type")
    is_bezier = build.math("COMPARE", build.out(kind, "Attribute"), _BEZIER)
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
        joined.append(build.vertices(made, part))
    no_points = build.math("MULTIPLY", no_surface, build.math("COMPARE", points, 0.0))
    joined.append(build.vertices(components["Point Cloud"], _CLOUD, no_points))
    build.feed(build.add("NodeGroupOutput").inputs["Geometry"], build.join(joined))


def take_kind(mesh: Mesh) -> Kind:
    """What a mesh made by ``showing_points`` holds. The attribute that tells goes."""
    attribute = mesh.attributes.get(_PART)
    if attribute is None:
        return SURFACE
    parts = np.empty(len(attribute.data), dtype=np.int32)
    attribute.data.foreach_get("value", parts)
    mesh.attributes.remove(attribute)
    return _KINDS[int(parts.max(initial=0))]


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
