# SPDX-License-Identifier: GPL-3.0-or-later
"""A yeti whose brows and mouth follow wires: curves on the face, with one shape key per expression."""

from __future__ import annotations

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

# in the yeti's own frame, as it looks along x: y to its left, z up
BROW = [(0.05, 1.80), (0.12, 1.835), (0.20, 1.82), (0.27, 1.77)]
MOUTH = [(-0.20, 1.50), (-0.11, 1.485), (0.0, 1.48), (0.11, 1.485), (0.20, 1.50)]
BROW_MOVES = [(0.03, 0.0, 0.11), (0.02, 0.0, 0.06), (0.0, 0.0, 0.0), (0.0, 0.0, -0.03)]  # raised inside
MOUTH_MOVES = [
    (-0.01, -0.04, 0.09),
    (0.01, -0.01, 0.03),
    (0.02, 0, -0.02),
    (0.01, 0.01, 0.03),
    (-0.01, 0.04, 0.09),
]
RADII = {"Brow.L": 0.13, "Brow.R": 0.13, "Mouth": 0.15}


def make() -> bpy.types.Scene:
    return Lineup(
        title="Wires",
        build=bust,
        row={"Rest": expression(), "Angry": expression(-1.0, -0.9), "Happy": expression(0.8, 1.0)},
        spacing=1.32,
        heading=-90.0,
        shot=Shot(
            (0.0, 0.0, 1.66),
            width=4.2,
            elevation=4.0,
            distance=20.0,
            lit=1.7,
            light=5.0,
            picture=(1440, 540),
            text=0.11,
            front=-0.55,
            floor=1.03,
        ),
    ).make()


def expression(brows: float = 0.0, mouth: float = 0.0):
    """Wires on a face, which move it where they move at all."""

    def pose(head: bpy.types.Object) -> None:
        wires = [draw(head, name, places) for name, places in features().items()]
        for wire in wires:
            mark(wire)
        if mouth:
            steer(head, wires, {"Brows": brows, "Mouth": mouth})
            posing.check_posed(head, 1, POSE_FRAME)

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


def features() -> dict[str, list[tuple[float, float]]]:
    """The wires by name: places on the face, from the front."""
    other = [(-y, z) for y, z in BROW]
    return {"Brow.L": BROW, "Brow.R": other, "Mouth": MOUTH}


def draw(head: bpy.types.Object, name: str, places: Sequence[tuple[float, float]]) -> bpy.types.Object:
    """A curve on the face, which follows the head."""
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
    wire = posing.add_object(data.name, data, head)
    wire.show_in_front = True
    bpy.context.view_layer.update()
    return wire


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


def steer(head: bpy.types.Object, wires: Sequence[bpy.types.Object], values: dict[str, float]) -> None:
    """Let the wires move the face, and key their expressions."""
    for wire, (name, radius) in zip(wires, RADII.items()):
        posing.make_active(head)
        posing.expect(bpy.ops.sinew.wire_add(curve=wire.name, radius=radius), f"{head.name}: wire_add")
        moves = np.array(MOUTH_MOVES if name == "Mouth" else BROW_MOVES)
        if name == "Brow.R":
            moves = moves * (1.0, -1.0, 1.0)
        wire.shape_key_add(name="Rest")
        key = wire.shape_key_add(name="Expression")
        key.slider_min = -1.0
        for point, move in zip(key.data, moves):
            for corner in ("co", "handle_left", "handle_right"):
                setattr(point, corner, getattr(point, corner) + Vector(move))
        posed = values["Mouth" if name == "Mouth" else "Brows"]
        for frame, share in ((1, 0.0), (POSE_FRAME, posed), (96, 0.0)):
            key.value = share
            key.keyframe_insert("value", frame=frame)
