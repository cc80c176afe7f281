# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the samples. Textures read attributes of the rest shape, so they stick to the surface."""

from collections.abc import Mapping, Sequence

import bpy
from bpy.types import Material, Node, NodeSocket, NodeTree

HANDLE_COLOUR = (0.85, 0.17, 0.01)
FIXED_COLOUR = (0.04, 0.13, 0.45)


def principled(name: str, roughness: float = 0.5, specular: float = 0.4) -> tuple[Material, Node]:
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Specular"].default_value = specular
    return material, shader


def plain_material(
    name: str, colour: Sequence[float], roughness: float = 0.5, specular: float = 0.4
) -> Material:
    """One colour; made once for each name."""
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    material, shader = principled(name, roughness, specular)
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    material.diffuse_color = (*colour, 1.0)
    return material


def add_node(tree: NodeTree, kind: str, inputs: Mapping[str | int, object], **settings: object) -> NodeSocket:
    """A shader node; of each input a value, or the socket to link it to. Returns its first output in use."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in settings.items():
        setattr(node, name, value)
    for key, value in inputs.items():
        if isinstance(value, NodeSocket):
            tree.links.new(value, node.inputs[key])
        else:
            node.inputs[key].default_value = value
    return next(socket for socket in node.outputs if socket.enabled)


def add_math(tree: NodeTree, operation: str, *inputs: object) -> NodeSocket:
    return add_node(tree, "Math", dict(enumerate(inputs)), operation=operation)


def attribute(material: Material, name: str, output: str = "Fac") -> NodeSocket:
    """An attribute of the mesh; as a colour or a vector by the name of the output."""
    node = material.node_tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = name
    return node.outputs[output]


def smooth_edge(tree: NodeTree, value: NodeSocket, low: float, high: float, least: float = 0.0) -> NodeSocket:
    """From ``least`` where the value is at most ``low`` to 1 where it is at least ``high``."""
    inputs = {"Value": value, "From Min": low, "From Max": high, "To Min": least}
    return add_node(tree, "MapRange", inputs, interpolation_type="SMOOTHSTEP")


def skin_material(name: str, roughness: float, bump: float, grain: float, band: str = "") -> Material:
    """Painted colours (attribute ``Colour``) under a fine grain of the rest position. The attribute ``band``
    shows in the handles' colour, as strongly as the object colour's alpha."""
    material, shader = principled(name, roughness)
    tree = material.node_tree
    colour = attribute(material, "Colour", "Color")
    if band:
        owner = tree.nodes.new("ShaderNodeObjectInfo")
        shown = add_math(tree, "MULTIPLY", attribute(material, band), owner.outputs["Alpha"])
        colour = add_node(tree, "MixRGB", {"Fac": shown, "Color1": colour, "Color2": (*HANDLE_COLOUR, 1.0)})
    tree.links.new(colour, shader.inputs["Base Color"])
    place = attribute(material, "rest", "Vector")
    noise = add_node(tree, "TexNoise", {"Vector": place, "Scale": grain, "Detail": 2.0})
    relief = add_node(tree, "Bump", {"Strength": bump, "Distance": 0.01, "Height": noise})
    tree.links.new(relief, shader.inputs["Normal"])
    return material


def eye_material(name: str, iris: Sequence[float], pupil: float, size: float) -> Material:
    """A wet eyeball; the attribute ``gaze`` is the angle from the line of sight in radians."""
    material, shader = principled(name, 0.08, 0.6)
    tree = material.node_tree
    stops = (
        (0.0, (0.004, 0.004, 0.006)),
        (pupil, (0.004, 0.004, 0.006)),
        (pupil + 0.03, tuple(1.4 * c for c in iris)),
        (size - 0.10, iris),
        (size - 0.03, tuple(0.25 * c for c in iris)),
        (size, tuple(0.20 * c for c in iris)),
        (size + 0.03, (0.80, 0.77, 0.72)),
    )
    angle = add_math(tree, "DIVIDE", attribute(material, "gaze"), 2.0)
    ramp = add_node(tree, "ValToRGB", {0: angle})
    elements = ramp.node.color_ramp.elements
    while len(elements) < len(stops):
        elements.new(0.5)
    for element, (at, colour) in zip(elements, stops):
        element.position, element.color = at / 2.0, (*colour, 1.0)
    tree.links.new(ramp, shader.inputs["Base Color"])
    return material


def patched_material(
    name: str, base: Sequence[float], patches: Sequence[tuple[str, Sequence[float], float]], roughness: float
) -> Material:
    """Colour fields over a base: each (attribute, colour, softness) covers where its attribute is positive.
    The attributes are smooth fields, zero on the border, so that borders are crisp on coarse meshes too."""
    material, shader = principled(name, roughness, specular=0.3)
    tree = material.node_tree
    below = tree.nodes.new("ShaderNodeRGB").outputs[0]
    below.default_value = material.diffuse_color = (*base, 1.0)
    for field, tint, softness in patches:
        edge = smooth_edge(tree, attribute(material, field), -softness, softness)
        below = add_node(tree, "MixRGB", {"Fac": edge, "Color1": below, "Color2": (*tint, 1.0)})
    tree.links.new(below, shader.inputs["Base Color"])
    return material


def region_material(name: str, base: Sequence[float], ruled: bool = False) -> Material:
    """A base on which the fields ``handle`` and ``fixed`` show the regions, with lines if it is ``ruled``."""
    patches = (("handle", HANDLE_COLOUR, 0.002), ("fixed", FIXED_COLOUR, 0.002))
    material = patched_material(name, base, patches, roughness=0.5)
    if ruled:
        rule_lines(material, cell=0.1, line=0.014)
    return material


def rule_lines(material: Material, cell: float, line: float) -> None:
    """Fine darker lines on a material's colour, every ``cell`` units of the rest x and y."""
    tree = material.node_tree
    base = tree.nodes["Principled BSDF"].inputs["Base Color"]
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(attribute(material, "rest", "Vector"), split.inputs[0])
    # 0 on a line, cell / 2 between two
    waves = [add_math(tree, "PINGPONG", split.outputs[axis], cell / 2) for axis in "XY"]
    edge = smooth_edge(tree, add_math(tree, "MINIMUM", *waves), 0.3 * line, 0.6 * line, least=0.5)
    inputs = {"Fac": 1.0, "Color1": base.links[0].from_socket, "Color2": edge}
    tree.links.new(add_node(tree, "MixRGB", inputs, blend_type="MULTIPLY"), base)
