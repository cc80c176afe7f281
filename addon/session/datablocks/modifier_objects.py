# SPDX-License-Identifier: GPL-3.0-or-later
"""The other objects that a modifier asks for."""

from collections.abc import Iterator
from functools import cache
from typing import Any

from bpy.types import Collection, Modifier, NodeTree, Object

from ... import compat


def objects_of(modifier: Modifier) -> Iterator[Object]:
    """The objects, and those of the collections, that a modifier or its nodes name."""
    named = _in_nodes(modifier) if modifier.type == "NODES" else _in_settings(modifier)
    for value in named:
        if isinstance(value, Collection):
            yield from value.all_objects
        elif isinstance(value, Object):
            yield value


def _in_settings(modifier: Modifier) -> list[Any]:
    return [getattr(modifier, name) for name in _pointers(modifier.__class__)]


@cache
def _pointers(kind: Any) -> tuple[str, ...]:
    """The properties of a type of modifier that name an object or a collection."""
    return tuple(
        row.identifier
        for row in kind.bl_rna.properties
        if row.type == "POINTER" and row.fixed_type.identifier in ("Object", "Collection")
    )


def _in_nodes(modifier: Modifier) -> list[Any]:
    """The values of the node group of a modifier: in its nodes, or given to its inputs."""
    named = list(compat.modifier_inputs(modifier))
    waiting, known = [modifier.node_group], set()
    while waiting:
        tree = waiting.pop()
        if not isinstance(tree, NodeTree) or tree in known:
            continue
        known.add(tree)
        for node in tree.nodes:
            if node.type == "GROUP":
                waiting.append(node.node_tree)
            if node.type in ("GROUP", "OBJECT_INFO", "COLLECTION_INFO"):
                named += [getattr(socket, "default_value", None) for socket in node.inputs]
    return named
