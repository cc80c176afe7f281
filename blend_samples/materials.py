# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the samples. Textures read attributes of the rest shape, so they stick to the surface."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

HANDLE_COLOUR = (0.85, 0.17, 0.01)
FIXED_COLOUR = (0.04, 0.13, 0.45)


def principled(
    name: str, roughness: float = 0.5, specular: float = 0.4
) -> tuple[bpy.types.Material, bpy.types.Node]:
    """A new material and its Principled BSDF."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Specular"].default_value = specular
    return material, shader


def plain_material(
    name: str, colour: Sequence[float], roughness: float = 0.5, specular: float = 0.4
) -> bpy.types.Material:
    """One colour; made once for each name."""
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    material, shader = principled(name, roughness, specular)
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    material.diffuse_color = (*colour, 1.0)
    return material


def backdrop_material(tint: Sequence[float]) -> bpy.types.Material:
    return plain_material("Backdrop", tint, roughness=0.9, specular=0.1)


def ink_material() -> bpy.types.Material:
    return plain_material("Ink", (0.035, 0.035, 0.04), roughness=0.8, specular=0.1)


def attribute(material: bpy.types.Material, name: str) -> bpy.types.Node:
    node = material.node_tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = name
    return node


def skin_material(
    name: str, roughness: float, bump: float, grain: float, band: str = ""
) -> bpy.types.Material:
    """Painted colours (attribute ``Colour``) under a fine grain of the rest position.

    The attribute ``band`` shows in the handles' colour, as strongly as the object colour's alpha.
    """
    material, shader = principled(name, roughness)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    colour = attribute(material, "Colour").outputs["Color"]
    if band:
        mark, owner, shown = (nodes.new(f"ShaderNode{kind}") for kind in ("MixRGB", "ObjectInfo", "Math"))
        mark.inputs["Color2"].default_value = (*HANDLE_COLOUR, 1.0)
        shown.operation = "MULTIPLY"
        links.new(attribute(material, band).outputs["Fac"], shown.inputs[0])
        links.new(owner.outputs["Alpha"], shown.inputs[1])
        links.new(shown.outputs[0], mark.inputs["Fac"])
        links.new(colour, mark.inputs["Color1"])
        colour = mark.outputs["Color"]
    links.new(colour, shader.inputs["Base Color"])
    noise = nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = grain
    noise.inputs["Detail"].default_value = 2.0
    relief = nodes.new("ShaderNodeBump")
    relief.inputs["Strength"].default_value = bump
    relief.inputs["Distance"].default_value = 0.01
    links.new(attribute(material, "rest").outputs["Vector"], noise.inputs["Vector"])
    links.new(noise.outputs["Fac"], relief.inputs["Height"])
    links.new(relief.outputs["Normal"], shader.inputs["Normal"])
    return material


def eye_material(name: str, iris: Sequence[float], pupil: float, size: float) -> bpy.types.Material:
    """A wet eyeball; the attribute ``gaze`` is the angle from the line of sight in radians."""
    material, shader = principled(name, 0.08, 0.6)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    scale = nodes.new("ShaderNodeMath")
    scale.operation = "DIVIDE"
    scale.inputs[1].default_value = 2.0
    ramp = nodes.new("ShaderNodeValToRGB")
    stops = (
        (0.0, (0.004, 0.004, 0.006)),
        (pupil, (0.004, 0.004, 0.006)),
        (pupil + 0.03, tuple(1.4 * c for c in iris)),
        (size - 0.10, iris),
        (size - 0.03, tuple(0.25 * c for c in iris)),
        (size, tuple(0.20 * c for c in iris)),
        (size + 0.03, (0.80, 0.77, 0.72)),
    )
    elements = ramp.color_ramp.elements
    while len(elements) < len(stops):
        elements.new(0.5)
    for element, (angle, colour) in zip(elements, stops):
        element.position, element.color = angle / 2.0, (*colour, 1.0)
    links.new(attribute(material, "gaze").outputs["Fac"], scale.inputs[0])
    links.new(scale.outputs[0], ramp.inputs[0])
    links.new(ramp.outputs[0], shader.inputs["Base Color"])
    return material


def patched_material(
    name: str, base: Sequence[float], patches: Sequence[tuple[str, Sequence[float], float]], roughness: float
) -> bpy.types.Material:
    """Colour fields over a base: each (attribute, colour, softness) covers where its attribute is positive.

    The attributes are smooth fields, zero on the border, so that borders are crisp on coarse meshes too.
    """
    material, shader = principled(name, roughness, specular=0.3)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    colour = nodes.new("ShaderNodeRGB")
    colour.outputs[0].default_value = (*base, 1.0)
    material.diffuse_color = (*base, 1.0)
    below = colour.outputs[0]
    for field, tint, softness in patches:
        edge = nodes.new("ShaderNodeMapRange")
        edge.interpolation_type = "SMOOTHSTEP"
        edge.inputs["From Min"].default_value, edge.inputs["From Max"].default_value = -softness, softness
        mix = nodes.new("ShaderNodeMixRGB")
        mix.inputs["Color2"].default_value = (*tint, 1.0)
        links.new(attribute(material, field).outputs["Fac"], edge.inputs["Value"])
        links.new(edge.outputs[0], mix.inputs["Fac"])
        links.new(below, mix.inputs["Color1"])
        below = mix.outputs[0]
    links.new(below, shader.inputs["Base Color"])
    return material


def region_material(name: str, base: Sequence[float], ruled: bool = False) -> bpy.types.Material:
    """A base on which the fields ``handle`` and ``fixed`` show the regions, with lines if it is ``ruled``."""
    patches = (("handle", HANDLE_COLOUR, 0.002), ("fixed", FIXED_COLOUR, 0.002))
    material = patched_material(name, base, patches, roughness=0.5)
    if ruled:
        rule_lines(material, cell=0.1, line=0.014)
    return material


def rule_lines(material: bpy.types.Material, cell: float, line: float) -> None:
    """Fine darker lines on a material's colour, every ``cell`` units of the rest x and y."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    base = nodes["Principled BSDF"].inputs["Base Color"]
    split = nodes.new("ShaderNodeSeparateXYZ")
    links.new(attribute(material, "rest").outputs["Vector"], split.inputs[0])
    near = nodes.new("ShaderNodeMath")
    near.operation = "MINIMUM"
    for k, axis in enumerate("XY"):
        wave = nodes.new("ShaderNodeMath")  # 0 on a line, cell / 2 between two
        wave.operation = "PINGPONG"
        wave.inputs[1].default_value = cell / 2
        links.new(split.outputs[axis], wave.inputs[0])
        links.new(wave.outputs[0], near.inputs[k])
    edge = nodes.new("ShaderNodeMapRange")
    edge.interpolation_type = "SMOOTHSTEP"
    edge.inputs["From Min"].default_value, edge.inputs["From Max"].default_value = 0.3 * line, 0.6 * line
    edge.inputs["To Min"].default_value = 0.5
    links.new(near.outputs[0], edge.inputs["Value"])
    mix = nodes.new("ShaderNodeMixRGB")
    mix.blend_type = "MULTIPLY"
    mix.inputs["Fac"].default_value = 1.0
    links.new(base.links[0].from_socket, mix.inputs["Color1"])
    links.new(edge.outputs[0], mix.inputs["Color2"])
    links.new(mix.outputs[0], base)
