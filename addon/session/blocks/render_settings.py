# SPDX-License-Identifier: GPL-3.0-or-later
"""What renders do otherwise than viewports before Sinew: settings that Blender has twice.

Blender evaluates the modifiers of renders in renders only. So a copy of an object gets the values for renders
in its settings for viewports, by their names: ``render_levels`` and ``levels``, ``show_render`` and
``show_viewport``, ``resolution`` and ``viewport_resolution``. No type of modifier is known here.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import bpy
from bpy.types import ID, Modifier, NodeTree, Object

from ...compat import remove_data
from . import node_group

_SIMPLIFY = "simplify_"
_ASKS = "GeometryNodeIsViewport"  # a node that tells viewports and renders apart


def _twins(owner: Any) -> tuple[tuple[str, str], ...]:
    """The names of the settings that Blender has twice: the one for viewports, and the one for renders."""
    return _twins_of(owner.bl_rna.identifier)


@cache
def _twins_of(kind: str) -> tuple[tuple[str, str], ...]:
    names = getattr(bpy.types, kind).bl_rna.properties.keys()
    found = []
    for name in names:
        if "render" in name:
            ways = (("render", "viewport"), ("render_", ""), ("_render", ""))
            others = (name.replace(*way) for way in ways)
            found += [(other, name) for other in others if other in names and other != name][:1]
        elif "viewport_" in name and (other := name.replace("viewport_", "")) in names:
            found.append((name, other))
    return tuple(found)


def _owners(obj: Object, modifiers: Iterable[Modifier]) -> Iterator[Any]:
    if obj.data is not None:
        yield obj.data
    yield from modifiers


def _simplified() -> list[tuple[str, str]]:
    """The limits that Simplify has twice, while it is on."""
    render = bpy.context.scene.render
    return [pair for pair in _twins(render) if pair[0].startswith(_SIMPLIFY)] if render.use_simplify else []


def signature(obj: Object, modifiers: Iterable[Modifier]) -> tuple:
    """The settings for renders of an object with these modifiers, for comparison.

    Blender calls nobody when they change, since no viewport does.
    """
    return tuple(rendered for _shown, rendered in _values(obj, modifiers))


def both(obj: Object, modifiers: Iterable[Modifier]) -> tuple:
    """The same, with the settings for viewports beside them."""
    return tuple(_values(obj, modifiers))


def _values(obj: Object, modifiers: Iterable[Modifier]) -> Iterator[tuple[Any, Any]]:
    pairs = [(bpy.context.scene.render, *names) for names in _simplified()]
    pairs += [(owner, *names) for owner in _owners(obj, modifiers) for names in _twins(owner)]
    return ((getattr(owner, shown), getattr(owner, rendered)) for owner, shown, rendered in pairs)


def differ(obj: Object, modifiers: Sequence[Modifier]) -> bool:
    """Whether other vertices may come out of these modifiers of an object in renders."""
    render = bpy.context.scene.render
    pairs = [(render, shown, rendered) for shown, rendered in _simplified()]
    pairs += [
        (owner, shown, rendered)
        for owner in _owners(obj, modifiers)
        for shown, rendered in _twins(owner)
        if _counts(owner, shown, getattr(owner, rendered))
    ]
    return any(getattr(owner, shown) != getattr(owner, rendered) for owner, shown, rendered in pairs) or any(
        _asks(modifier.node_group, set()) for modifier in modifiers if _is_foreign(modifier)
    )


def _counts(owner: Any, shown: str, value: Any) -> bool:
    """Whether a value for renders is one; 0 for a resolution, for example, means the one for viewports."""
    limit = getattr(owner.bl_rna.properties[shown], "hard_min", value)
    return value >= limit


def _is_foreign(modifier: Modifier) -> bool:
    return modifier.type == "NODES" and not node_group.is_ours(modifier)


def _asks(tree: NodeTree | None, known: set[NodeTree]) -> bool:
    """Whether nodes ask if they are evaluated for a viewport."""
    if not isinstance(tree, NodeTree) or tree in known:
        return False
    known.add(tree)
    return any(
        node.bl_idname == _ASKS or (node.type == "GROUP" and _asks(node.node_tree, known))
        for node in tree.nodes
    )


@contextmanager
def applied(copies: Sequence[Object]) -> Iterator[None]:
    """For a while, the modifiers of the copies do in viewports what they do in renders."""
    render = bpy.context.scene.render
    limits = [(shown, getattr(render, shown), getattr(render, other)) for shown, other in _simplified()]
    replaced: list[tuple[Object, ID]] = []
    made: list[ID] = []
    for copy in copies:
        data = copy.data
        if differ(copy, ()):
            copy.data = data.copy()
            replaced.append((copy, data))
        for owner in _owners(copy, copy.modifiers):
            for shown, rendered in _twins(owner):
                value = getattr(owner, rendered)
                if _counts(owner, shown, value) and getattr(owner, shown) != value:
                    setattr(owner, shown, value)
        for modifier in copy.modifiers:
            if _is_foreign(modifier) and _asks(modifier.node_group, set()):
                modifier.node_group = _answered(modifier.node_group, made)
    for shown, value, rendered in limits:
        if value != rendered:
            setattr(render, shown, rendered)
    try:
        yield
    finally:
        for shown, value, rendered in limits:
            if value != rendered:
                setattr(render, shown, value)
        for copy, data in replaced:
            own_data, copy.data = copy.data, data
            remove_data((own_data,))
        for tree in made:
            bpy.data.node_groups.remove(tree)


def _answered(tree: NodeTree, made: list[ID]) -> NodeTree:
    """A copy of nodes in which those that ask for a viewport are told that there is none."""
    copy = tree.copy()
    made.append(copy)
    for node in list(copy.nodes):
        if node.type == "GROUP" and _asks(node.node_tree, set()):
            node.node_tree = _answered(node.node_tree, made)
        elif node.bl_idname == _ASKS:
            answer = copy.nodes.new("FunctionNodeInputBool").outputs[0]  # false
            for link in list(node.outputs[0].links):
                copy.links.new(answer, link.to_socket)
    return copy
