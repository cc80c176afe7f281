# SPDX-License-Identifier: GPL-3.0-or-later
"""The yeti's head, whose brows and mouth follow curves on its face."""

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector

from .. import posing
from ..lineup import POSE_FRAME, Lineup
from ..markers import handle_material
from ..materials import skin_material
from ..models import yeti
from ..models.objects import keep_vertices
from ..studio import Shot

# In the yeti's own frame, as it looks along x: y to its left, z up. The inner ends of the brows are raised.
BROW = [(0.05, 1.80), (0.12, 1.835), (0.20, 1.82), (0.27, 1.77)]
BROW_MOVES = [(0.03, 0.0, 0.11), (0.02, 0.0, 0.06), (0.0, 0.0, 0.0), (0.0, 0.0, -0.03)]
MOUTH = [(0.0, 1.48), (0.11, 1.485), (0.20, 1.50)]
MOUTH_MOVES = [(0.02, 0, -0.02), (0.01, 0.01, 0.03), (-0.01, 0.04, 0.09)]


def mirrored(half: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """Places (y, z) or moves (x, y, z) on the other side of the face."""
    return [(*rest, -y, z) for *rest, y, z in half]


# The curves: their places from the front, the moves of their points, the radius
WIRES = {
    "Brow.L": (BROW, BROW_MOVES, 0.13),
    "Brow.R": (mirrored(BROW), mirrored(BROW_MOVES), 0.13),
    "Mouth": (mirrored(MOUTH)[:0:-1] + MOUTH, mirrored(MOUTH_MOVES)[:0:-1] + MOUTH_MOVES, 0.15),
}


def expression(brows: float = 0.0, mouth: float = 0.0):
    """Wires on a face, which move it where they move at all."""

    def pose(head: bpy.types.Object) -> None:
        drawn = draw_wires(head)
        for wire in drawn:
            mark(wire)
        for wire, (name, (_places, moves, radius)) in zip(drawn, WIRES.items()):
            if mouth:
                posing.operate(head, "wire_add", curve=wire.name, radius=radius)
                steer(wire, moves, mouth if name == "Mouth" else brows)
        if mouth:
            posing.check_posed(head)

    return pose


def bust(voxel: float = yeti.VOXEL) -> bpy.types.Object:
    """The yeti without its rig, and without what lies below its shoulders."""
    body, rig = yeti.build(voxel=voxel)
    bpy.data.objects.remove(rig)
    body.modifiers.clear()
    points = posing.vertices(body)
    keep_vertices(body.data, (points[:, 2] >= 1.16) & (np.abs(points[:, 1]) <= 0.52))
    body.data.materials[0] = skin_material("Fur", roughness=0.6, bump=0.2, grain=90.0)
    return body


def draw_wires(head: bpy.types.Object) -> list[bpy.types.Object]:
    """Curves on the face, which follow the head."""
    drawn = []
    for name, (places, _moves, _radius) in WIRES.items():
        data = bpy.data.curves.new(f"{head.name} {name}", "CURVE")
        data.dimensions, data.resolution_u = "3D", 16
        spline = data.splines.new("BEZIER")
        spline.bezier_points.add(len(places) - 1)
        for point, (y, z) in zip(spline.bezier_points, places):
            met, place, _normal, _face = head.ray_cast(Vector((2.0, y, z)), Vector((-1.0, 0.0, 0.0)))
            if not met:
                raise posing.SampleError(f"{head.name} has no face at {y}, {z}")
            point.co = place + Vector((0.012, 0.0, 0.0))
            point.handle_left_type = point.handle_right_type = "AUTO"
        drawn.append(posing.add_object(data.name, data, head))
        drawn[-1].show_in_front = True
    bpy.context.view_layer.update()
    return drawn


def mark(wire: bpy.types.Object) -> None:
    """Show the wire in the picture, as a thin tube of its own: a wire itself has no bevel."""
    tube = posing.add_object(f"{wire.name} Tube", bpy.data.meshes.new(f"{wire.name} Tube"))
    tube.hide_select = True
    group = bpy.data.node_groups.new("Tube", "GeometryNodeTree")
    group.outputs.new("NodeSocketGeometry", "Geometry")
    nodes, links = group.nodes, group.links
    info, circle = nodes.new("GeometryNodeObjectInfo"), nodes.new("GeometryNodeCurvePrimitiveCircle")
    swept, coloured = nodes.new("GeometryNodeCurveToMesh"), nodes.new("GeometryNodeSetMaterial")
    info.transform_space, info.inputs["Object"].default_value = "RELATIVE", wire
    circle.inputs["Radius"].default_value = 0.009
    coloured.inputs["Material"].default_value = handle_material()
    links.new(info.outputs["Geometry"], swept.inputs["Curve"])
    links.new(circle.outputs["Curve"], swept.inputs["Profile Curve"])
    links.new(swept.outputs["Mesh"], coloured.inputs["Geometry"])
    links.new(coloured.outputs["Geometry"], nodes.new("NodeGroupOutput").inputs["Geometry"])
    tube.modifiers.new("Tube", "NODES").node_group = group


def steer(wire: bpy.types.Object, moves: Sequence[Sequence[float]], strength: float) -> None:
    """Key an expression of the wire, of so much strength."""
    wire.shape_key_add(name="Rest")
    posed = wire.shape_key_add(name="Expression")
    posed.slider_min = -1.0
    for point, move in zip(posed.data, moves):
        for corner in ("co", "handle_left", "handle_right"):
            setattr(point, corner, getattr(point, corner) + Vector(move))
    posing.key(posed, "value", {1: 0.0, POSE_FRAME: strength, 96: 0.0})


LINEUPS = {
    "wires": Lineup(
        about="A yeti whose brows and mouth follow wires: curves on the face, a shape key per expression.",
        build=bust,
        row={"Rest": expression(), "Angry": expression(-1.0, -0.9), "Happy": expression(0.8, 1.0)},
        spacing=1.32,
        heading=-90.0,
        shot=Shot((0, 0, 1.66), 4.2, 4, 20, 1.7, 5, picture=(1440, 540), text=0.11, front=-0.55, floor=1.03),
    ),
}
