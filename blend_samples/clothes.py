# SPDX-License-Identifier: GPL-3.0-or-later
"""A dressed mannequin that runs: by weights for each object, and by a cage around all that bones move."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import mannequins, markers, materials, posing
from .rig import carry_cage

STAND_OFF = 0.014
BUTTON = 0.016
# bone -> turns in degrees about the axes of the figure
RUN = {
    "chest": (6, 0, 10),
    "thigh.L": (-62, 0, 0),
    "shin.L": (70, 0, 0),
    "thigh.R": (28, 0, 0),
    "shin.R": (52, 0, 0),
    "upper.L": (0, 66, 0),
    "upper.R": (0, -66, 0),
    "lower.L": (0, 0, -70),
    "lower.R": (0, 0, 70),
}


def make() -> bpy.types.Scene:
    return mannequins.row(
        "Clothes",
        {"Rest": None, "Weights for each": _by_weights, "Bones move a cage": _by_cage},
        _dress,
        spacing=1.5,
        width=5.6,
        height=640,
        active=2,
    )


def _dress(skin: bpy.types.Object, rig: bpy.types.Object, move) -> None:
    rig.hide_render = True
    skin.parent = rig
    skin.matrix_parent_inverse = rig.matrix_world.inverted()
    bpy.context.view_layer.update()
    clothes = [_suit(skin), _buttons(skin), _cap(skin)]
    for obj in clothes:
        bpy.context.scene.collection.objects.link(obj)
        obj.parent, obj.matrix_parent_inverse = rig, skin.matrix_parent_inverse
        obj.matrix_basis = skin.matrix_basis
    bpy.context.view_layer.update()
    if move is None:
        return
    move(skin, rig, clothes)
    for frame, share in ((1, 0.0), (mannequins.POSE_FRAME, 1.0)):
        for bone, angles in RUN.items():
            joint = rig.pose.bones[bone]
            joint.rotation_mode = "QUATERNION"
            axes = joint.bone.matrix_local.to_quaternion()
            turn = posing.Move(turn=[share * angle for angle in angles]).matrix().to_quaternion()
            joint.rotation_quaternion = axes.inverted() @ turn @ axes
            joint.keyframe_insert("rotation_quaternion", frame=frame)
    for obj in (skin, *clothes):
        if obj.sinew.deformers:
            posing.check_posed(obj, 1, mannequins.POSE_FRAME)
    bpy.context.scene.frame_set(mannequins.POSE_FRAME)
    posing.progress(f"{_entered(skin, clothes)} points of the clothes of {skin.name} are inside the body")


def _by_weights(skin: bpy.types.Object, rig: bpy.types.Object, clothes: list[bpy.types.Object]) -> None:
    """With Automatic Weights for each of them."""
    for obj in (skin, *clothes):
        posing.make_active(rig)
        obj.select_set(True)
        posing.expect(bpy.ops.object.parent_set(type="ARMATURE_AUTO"), "parent_set(type='ARMATURE_AUTO')")


def _by_cage(skin: bpy.types.Object, rig: bpy.types.Object, clothes: list[bpy.types.Object]) -> None:
    posing.make_active(skin)
    for obj in clothes:
        obj.select_set(True)
    posing.expect(bpy.ops.sinew.cage_add(method="green", faces=500), "cage_add()")
    cage = skin.sinew.deformers[0].cage
    carry_cage(cage, rig)
    markers.add_cage_edges(cage, 0.004)


def _shell(
    skin: bpy.types.Object, name: str, keep: np.ndarray, off: float, colour: tuple
) -> bpy.types.Object:
    """The faces of the skin between vertices to ``keep``, bool (n,), at a distance from it."""
    edit = bmesh.new()
    edit.from_mesh(skin.data)
    edit.verts.ensure_lookup_table()
    normals = [vertex.normal.copy() for vertex in edit.verts]
    for vertex, normal in zip(edit.verts, normals):
        vertex.co += off * normal
    lost = [edit.verts[index] for index in np.flatnonzero(~keep)]
    bmesh.ops.delete(edit, geom=lost, context="VERTS")
    mesh = bpy.data.meshes.new(f"{skin.name} {name}")
    edit.to_mesh(mesh)
    edit.free()
    mesh.materials.clear()
    mesh.materials.append(materials.plain_material(name, colour, roughness=0.7))
    return bpy.data.objects.new(mesh.name, mesh)


def _suit(skin: bpy.types.Object) -> bpy.types.Object:
    points = posing.vertices(skin)
    keep = (points[:, 2] > 0.16) & (points[:, 2] < 1.53) & (np.abs(points[:, 0]) < 0.66)
    return _shell(skin, "Suit", keep, STAND_OFF, (0.05, 0.13, 0.32))


def _cap(skin: bpy.types.Object) -> bpy.types.Object:
    return _shell(skin, "Cap", posing.vertices(skin)[:, 2] > 1.75, 0.02, (0.45, 0.04, 0.03))


def _buttons(skin: bpy.types.Object) -> bpy.types.Object:
    """Loose parts on the chest, just in front of the suit."""
    tree = BVHTree.FromPolygons(
        [vertex.co.copy() for vertex in skin.data.vertices], [face.vertices[:] for face in skin.data.polygons]
    )
    edit = bmesh.new()
    for height in (1.08, 1.17, 1.26, 1.35):
        place, normal, _face, _distance = tree.ray_cast(Vector((0.0, -1.0, height)), Vector((0.0, 1.0, 0.0)))
        place += (STAND_OFF + 0.6 * BUTTON) * normal
        made = bmesh.ops.create_uvsphere(edit, u_segments=12, v_segments=8, radius=BUTTON)
        bmesh.ops.translate(edit, verts=made["verts"], vec=place)
    mesh = bpy.data.meshes.new(f"{skin.name} Buttons")
    edit.to_mesh(mesh)
    edit.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(materials.plain_material("Brass", (0.7, 0.45, 0.1), roughness=0.3))
    return bpy.data.objects.new(mesh.name, mesh)


def _entered(skin: bpy.types.Object, clothes: list[bpy.types.Object]) -> int:
    """How many points of the clothes are inside the body, by the side of its nearest face."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    tree = BVHTree.FromObject(skin, depsgraph)
    found = 0
    for obj in clothes:
        to_skin = skin.matrix_world.inverted() @ obj.matrix_world
        for point in posing.shape(obj):
            inside = to_skin @ Vector(point)
            place, normal, _face, _distance = tree.find_nearest(inside)
            found += (inside - place).dot(normal) < 0.0
    return found
