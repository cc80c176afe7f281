# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs and outputs of node groups, and their values on a modifier."""

from bpy.types import ID, NodesModifier, NodeTree


def add_group_input(group: NodeTree, socket_type: str, name: str, description: str = "") -> None:
    """Append an input. Since Blender 4.0, ``group.interface`` holds the inputs and outputs."""
    if hasattr(group, "interface"):
        group.interface.new_socket(name, description=description, in_out="INPUT", socket_type=socket_type)
    else:
        group.inputs.new(socket_type, name).description = description


def add_group_output(group: NodeTree, socket_type: str, name: str) -> None:
    """Append an output."""
    if hasattr(group, "interface"):
        group.interface.new_socket(name, in_out="OUTPUT", socket_type=socket_type)
    else:
        group.outputs.new(socket_type, name)


def _inputs(group: NodeTree) -> list:
    if not hasattr(group, "interface"):
        return list(group.inputs)
    return [
        item for item in group.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "INPUT"
    ]


def hide_in_modifier(group: NodeTree, names: tuple[str, ...]) -> None:
    """Hide inputs in the panel of the modifier. Blender can do this since 4.0."""
    for item in _inputs(group):
        if item.name in names and hasattr(item, "hide_in_modifier"):
            item.hide_in_modifier = True


def _identifier(group: NodeTree, name: str) -> str | None:
    """Asking Blender for one name costs a tenth of reading them all. It shares no name with an output."""
    found = (group.interface.items_tree if hasattr(group, "interface") else group.inputs).get(name)
    return None if found is None else found.identifier


def has_group_input(group: NodeTree, name: str) -> bool:
    """Whether the group has an input of that name."""
    return _identifier(group, name) is not None


def modifier_input(modifier: NodesModifier, name: str) -> object:
    """The value of an input of a modifier's node group; None if the group has no such input."""
    identifier = _identifier(modifier.node_group, name) if modifier.node_group else None
    return None if identifier is None else _value(modifier, identifier)


def modifier_inputs(modifier: NodesModifier) -> list[object]:
    """The values of all inputs of a modifier's node group; None for those without a value."""
    group = modifier.node_group
    return [_value(modifier, item.identifier) for item in _inputs(group)] if group else []


def _value(modifier: NodesModifier, identifier: str) -> object:
    if hasattr(modifier, "properties"):
        return getattr(getattr(modifier.properties.inputs, identifier, None), "value", None)
    return modifier.get(identifier)


def set_modifier_input(modifier: NodesModifier, name: str, value: object) -> None:
    """Set an input of a modifier's node group.

    Blender 5.2 stores the values elsewhere, and notices a new object only after the group is assigned again.
    """
    identifier = _identifier(modifier.node_group, name)
    if hasattr(modifier, "properties"):
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        modifier[identifier] = value
    if isinstance(value, ID):
        modifier.node_group = modifier.node_group


def rename_attribute_inputs(modifier: NodesModifier, old: str, new: str) -> None:
    """Let the inputs of a modifier's node group that read the attribute ``old`` read ``new`` instead."""
    for item in _inputs(modifier.node_group) if modifier.node_group else ():
        if hasattr(modifier, "properties"):
            value = getattr(modifier.properties.inputs, item.identifier, None)
            if getattr(value, "attribute_name", None) == old:
                value.attribute_name = new
        elif modifier.get(f"{item.identifier}_attribute_name") == old:
            modifier[f"{item.identifier}_attribute_name"] = new
