# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks that show controls in a picture: orange pins, orange cage edges, blue pads on fixed regions."""

from collections.abc import Sequence

import bpy
from mathutils import Vector

from .materials import FIXED_COLOUR, HANDLE_COLOUR, plain_material
from .posing import add_object


def handle_material() -> bpy.types.Material:
    return plain_material("Handle", HANDLE_COLOUR, roughness=0.3)


def add_ball(name: str, place: Sequence[float], radius: float) -> bpy.types.Object:
    """A ball in the handles' colour that cannot be selected."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=radius, location=place)
    return dress(name, handle_material(), smooth=True)


def add_pin(
    control: bpy.types.Object, tip: Sequence[float], radius: float, foot: Sequence[float] | None = None
) -> None:
    """A ball at ``tip`` on a thin stem from ``foot`` (world space), carried by the control."""
    bpy.context.view_layer.update()
    parts = [add_ball(f"{control.name} Pin", tip, radius)]
    if foot is not None:
        way = Vector(tip) - Vector(foot)
        stem = {"radius": 0.16 * radius, "depth": way.length, "location": Vector(foot) + way / 2}
        turn = way.to_track_quat("Z", "Y").to_euler()
        bpy.ops.mesh.primitive_cylinder_add(vertices=16, rotation=turn, **stem)
        parts.append(dress(f"{control.name} Stem", handle_material(), smooth=True))
    for part in parts:
        part.parent, part.matrix_parent_inverse = control, control.matrix_world.inverted()


def add_lattice_points(lattice: bpy.types.Object, radius: float, frame: int) -> None:
    """A ball at each point of the top layer of a lattice that has moved at a frame."""
    bpy.context.scene.frame_set(frame)
    evaluated = lattice.evaluated_get(bpy.context.evaluated_depsgraph_get())
    top = evaluated.data.points[-lattice.data.points_u * lattice.data.points_v :]
    moved = [point.co_deform for point in top if (point.co_deform - point.co).length > 1e-3]
    places = [lattice.matrix_world @ place for place in moved]
    mesh = bpy.data.meshes.new(f"{lattice.name} Points")
    mesh.from_pydata(places, [], [])
    carrier = add_object(mesh.name, mesh)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=radius)
    ball = bpy.context.object
    ball.data.materials.append(handle_material())
    ball.parent, carrier.instance_type = carrier, "VERTS"
    for obj in (carrier, ball):
        obj.hide_select = True


def add_cage_edges(cage: bpy.types.Object, thickness: float) -> None:
    """The edges of a cage: a twin that shares its mesh, and so its poses, with a Wireframe on top."""
    if not cage.data.materials:
        cage.data.materials.append(handle_material())
    edges = cage.copy()
    edges.name = f"{cage.name} Edges"
    bpy.context.scene.collection.objects.link(edges)
    frame = edges.modifiers.new("Wireframe", "WIREFRAME")
    frame.thickness, frame.use_even_offset, frame.use_boundary = thickness, False, False
    edges.hide_render, edges.hide_select, edges.display_type = False, True, "SOLID"
    edges.visible_shadow = False
    edges.hide_set(True)  # the cage itself is edited, not these edges


def dress(name: str, material: bpy.types.Material, smooth: bool = False) -> bpy.types.Object:
    """Name and paint the object that an operator has just added; it cannot be selected."""
    marker = bpy.context.object
    marker.name, marker.hide_select = name, True
    marker.data.materials.append(material)
    marker.data.polygons.foreach_set("use_smooth", [smooth] * len(marker.data.polygons))
    return marker


def add_pad(centre: Sequence[float], radius: float, height: float = 0.012) -> None:
    """A thin disc on the floor under a part that stays where it is."""
    middle = (centre[0], centre[1], height / 2)
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=radius, depth=height, location=middle)
    pad = dress("Fixed", plain_material("Fixed", FIXED_COLOUR, roughness=0.35))
    bevel = pad.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.4 * height, 2
