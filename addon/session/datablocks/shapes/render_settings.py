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
from bpy.types import ID, Modifier, NodesModifier, NodeTree, Object

from ....compat import action_curves, remove_action_curve, remove_data
from ...targets import node_group
from ..modifier_objects import objects_of

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
    """What has such settings: an object with these modifiers, and the objects that they ask for."""
    modifiers = list(modifiers)
    yield from _own(obj, modifiers)
    for other in _reached(modifiers):
        yield from _own(other, other.modifiers)


def _own(obj: Object, modifiers: Iterable[Modifier]) -> Iterator[Any]:
    if obj.data is not None:
        yield obj.data
    yield from modifiers


def _reached(modifiers: Iterable[Modifier]) -> list[Object]:
    """The objects that modifiers ask for, and those that the modifiers of these ask for.

    What is linked, or in a mode of its own, stays as viewports have it.
    """
    found: dict[Object, None] = {}
    waiting = [modifier for modifier in modifiers if not node_group.is_ours(modifier)]
    while waiting:
        for other in (each.original for each in objects_of(waiting.pop())):
            if other not in found and other.library is None and other.mode == "OBJECT":
                found[other] = None
                waiting += [modifier for modifier in other.modifiers if not node_group.is_ours(modifier)]
    return list(found)


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


def differ(obj: Object, modifiers: Iterable[Modifier]) -> bool:
    """Whether other vertices may come out of these modifiers of an object in renders."""
    owners = list(_owners(obj, modifiers))
    limits = _simplified() if any(len(_twins(owner)) > 1 for owner in owners) else []
    render = bpy.context.scene.render
    return (
        any(_differing(owner) for owner in owners)
        or any(getattr(render, shown) != getattr(render, rendered) for shown, rendered in limits)
        or any(_asks(owner.node_group, set()) for owner in owners if _is_foreign(owner))
    )


def _differing(owner: Any) -> list[tuple[str, Any]]:
    """The settings for viewports that have another value for renders, with that value.

    0 for a resolution, for example, is none: it means the one for viewports.
    """
    found = []
    for shown, rendered in _twins(owner):
        value = getattr(owner, rendered)
        least = getattr(owner.bl_rna.properties[shown], "hard_min", value)
        is_curve = isinstance(owner, ID)  # each of its splines may have another one for viewports
        if value >= least and (is_curve or getattr(owner, shown) != value):
            found.append((shown, value))
    return found


def _is_foreign(owner: Any) -> bool:
    return isinstance(owner, NodesModifier) and not node_group.is_ours(owner)


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
    """Context manager: use render settings of the modifiers in the viewport.

    Objects that the modifiers name use theirs, too.
    """
    changed: list[tuple[Any, str, Any]] = []
    made: list[ID] = []

    def put(owner: Any, name: str, value: Any) -> None:
        changed.append((owner, name, getattr(owner, name)))
        setattr(owner, name, value)

    render = bpy.context.scene.render
    others = [other for copy in copies for other in _reached(copy.modifiers)]
    try:
        for shown, rendered in _simplified():
            if getattr(render, shown) != getattr(render, rendered):
                put(render, shown, getattr(render, rendered))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        wanted = {other: _wanted(other) for other in others}
        wanted |= {copy: _wanted(copy.evaluated_get(depsgraph)) for copy in copies}
        for copy in copies:
            _stop_animation(copy, made)
        for obj, its in wanted.items():
            if obj.data is not None and _differing(obj.data):  # it may have other users
                made.append(obj.data.copy())
                put(obj, "data", made[-1])
            for owner, values in zip(_own(obj, obj.modifiers), its, strict=True):
                for shown, value in values:
                    put(owner, shown, value)
                if _is_foreign(owner) and _asks(owner.node_group, set()):
                    put(owner, "node_group", _answered(owner.node_group, made))
        yield
    finally:
        for owner, name, value in reversed(changed):
            setattr(owner, name, value)
        remove_data(made)


def _wanted(obj: Object) -> list[list[tuple[str, Any]]]:
    """What an object and its modifiers are to have for viewports: if evaluated, with animated values."""
    return [_differing(owner) for owner in _own(obj, obj.modifiers)]


def _stop_animation(copy: Object, made: list[ID]) -> None:
    """Let no driver and no key set what a copy has for viewports. All others count."""
    animation = copy.animation_data
    if animation is None:
        return
    ends = tuple(f".{shown}" for modifier in copy.modifiers for shown, _rendered in _twins(modifier))
    for driver in list(animation.drivers):
        if driver.data_path.endswith(ends):
            animation.drivers.remove(driver)
    if animation.action is not None and any(c.data_path.endswith(ends) for _a, c in action_curves(copy)):
        made.append(animation.action.copy())
        animation.action = made[-1]
        for action, curve in action_curves(copy):
            if action == made[-1] and curve.data_path.endswith(ends):
                remove_action_curve(action, curve)


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
