# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group of a file that shows a refined mesh in place of the control mesh.

    incoming -> where it has as many points as the refined mesh was made for: refined mesh -> Set Position,
    with what the first deformer has stored for the next solve, where modifiers may move the mesh before it

The places are a mesh without faces of their own: Blender copies in every frame what was written.
"""

import bpy
from bpy.types import GeometryNodeTree, Modifier, NodesModifier, Object

from ... import compat
from ...ids import Datablocks, Inputs, Keys
from . import node_group
from .nodes import Builder

_VERSION = 1
_HIDDEN = (Inputs.REFINED, Inputs.REFINED_PLACES, Inputs.REFINED_POINTS, Inputs.KEPT, Inputs.KEPT_INDEX)


def is_refining(modifier: object) -> bool:
    """Whether this modifier shows a refined mesh."""
    return (
        isinstance(modifier, NodesModifier)
        and modifier.node_group is not None
        and Keys.REFINED_GROUP in modifier.node_group
    )


def of(obj: Object) -> NodesModifier | None:
    """The first modifier of an object that shows a refined mesh."""
    return next(filter(is_refining, obj.modifiers), None)


def subdivision_of(obj: Object, modifier: Modifier) -> Modifier | None:
    """The Subdivision modifier right before, which says how to refine."""
    at = obj.modifiers.find(modifier.name) - 1
    return obj.modifiers[at] if at >= 0 and obj.modifiers[at].type == "SUBSURF" else None


def new(obj: Object) -> NodesModifier:
    """A modifier at the end of the stack, for viewports alone. It shows the control mesh."""
    modifier = obj.modifiers.new(Datablocks.REFINED_MODIFIER, "NODES")
    modifier.show_expanded = modifier.show_render = False
    node_group.attach(modifier, _ensure())
    connect(modifier, Inputs.REFINED_POINTS, -1)
    return modifier


def connect(modifier: NodesModifier, name: str, value: object) -> bool:
    """Set an input; whether it had another value."""
    if compat.modifier_input(modifier, name) == value:
        return False
    compat.set_modifier_input(modifier, name, value)
    return True


def _ensure() -> GeometryNodeTree:
    """The file's group, made if missing. Identified by a custom property, not by name."""
    for group in bpy.data.node_groups:
        if group.get(Keys.REFINED_GROUP) == _VERSION and group.library is None:
            return group
    group = bpy.data.node_groups.new(Datablocks.REFINED, "GeometryNodeTree")
    group[Keys.REFINED_GROUP] = _VERSION
    compat.add_group_input(group, "NodeSocketGeometry", "Geometry")
    compat.add_group_input(group, "NodeSocketObject", Inputs.REFINED)
    compat.add_group_input(group, "NodeSocketObject", Inputs.REFINED_PLACES)
    compat.add_group_input(group, "NodeSocketInt", Inputs.REFINED_POINTS)
    compat.add_group_input(group, "NodeSocketString", Inputs.KEPT)
    compat.add_group_input(group, "NodeSocketString", Inputs.KEPT_INDEX)
    compat.add_group_output(group, "NodeSocketGeometry", "Geometry")
    compat.hide_in_modifier(group, _HIDDEN)
    _nodes(Builder(group))
    return group


def _nodes(build: Builder) -> None:
    entry = build.add("NodeGroupInput")
    incoming = entry.outputs["Geometry"]
    index = build.add("GeometryNodeInputIndex").outputs[0]
    position = build.add("GeometryNodeInputPosition").outputs[0]
    shown, places = (
        build.out(
            build.add("GeometryNodeObjectInfo", {"transform_space": "ORIGINAL"}, Object=entry.outputs[name]),
            "Geometry",
        )
        for name in (Inputs.REFINED, Inputs.REFINED_PLACES)
    )
    moved = build.sample(places, position, index)
    refined = build.out(build.add("GeometryNodeSetPosition", Geometry=shown, Position=moved), "Geometry")
    named = build.add(
        "GeometryNodeInputNamedAttribute", {"data_type": "FLOAT_VECTOR"}, Name=entry.outputs[Inputs.KEPT]
    )
    count = build.count(incoming, "MESH")
    kept = build.sample(incoming, build.out(named, "Attribute"), index)
    number = build.switch("INT", build.math("LESS_THAN", index, count), -1, index)
    keeping = build.store(refined, "FLOAT_VECTOR", entry.outputs[Inputs.KEPT], kept)
    keeping = build.store(keeping, "INT", entry.outputs[Inputs.KEPT_INDEX], number)
    length = build.add("FunctionNodeStringLength", String=entry.outputs[Inputs.KEPT]).outputs[0]
    refined = build.switch("GEOMETRY", build.math("GREATER_THAN", length, 0.5), refined, keeping)
    fits = build.math("COMPARE", count, entry.outputs[Inputs.REFINED_POINTS])
    build.feed(
        build.add("NodeGroupOutput").inputs["Geometry"], build.switch("GEOMETRY", fits, incoming, refined)
    )
