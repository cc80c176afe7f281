# SPDX-License-Identifier: GPL-3.0-or-later
"""A dressed mannequin that runs: by weights for each object, and by a cage around all that bones move."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from .. import markers, posing
from ..lineup import POSE_FRAME, Lineup
from ..materials import plain_material
from ..models import mannequin
from ..models.objects import keep_vertices
from ..studio import Shot

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
    return Lineup(
        title="Clothes",
        build=mannequin.build,
        anew=True,
        row={"Rest": _dress, "Weights for each": _run(_by_weights), "Bones move a cage": _run(_by_cage)},
        spacing=1.5,
        shot=Shot((0.0, 0.0, 0.92), width=5.6, distance=26.0, light=10.0, picture=(1440, 640), front=-1.1),
    ).make()


def _dress(skin: bpy.types.Object) -> list[bpy.types.Object]:
    """Put clothes on a mannequin; they and the skin belong to its bones."""
    rig = mannequin.rig_of(skin)
    rig.hide_render = True
    clothes = [_suit(skin), _buttons(skin), _cap(skin)]
    for obj in clothes:
        obj.matrix_basis = skin.matrix_basis
    for obj in (skin, *clothes):
        obj.parent, obj.matrix_parent_inverse = rig, rig.matrix_world.inverted()
    bpy.context.view_layer.update()
    return clothes


def _run(move):
    """Poses a dressed mannequin; ``move`` makes skin and clothes follow the bones."""

    def pose(skin: bpy.types.Object) -> None:
        clothes, rig = _dress(skin), mannequin.rig_of(skin)
        move(skin, rig, clothes)
        for bone, angles in RUN.items():
            posing.key_turns(rig.pose.bones[bone], {1: (0, 0, 0), POSE_FRAME: angles})
        for obj in (skin, *clothes):
            if obj.sinew.deformers:
                posing.check_posed(obj, 1, POSE_FRAME)
        bpy.context.scene.frame_set(POSE_FRAME)
        posing.progress(f"{_entered(skin, clothes)} points of the clothes of {skin.name} are inside the body")

    return pose


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
    posing.carry_cage(cage, rig)
    markers.add_cage_edges(cage, 0.004)


def _shell(
    skin: bpy.types.Object, name: str, keep: np.ndarray, off: float, colour: tuple
) -> bpy.types.Object:
    """The faces of the skin between vertices to ``keep``, bool (n,), at a distance from it."""
    mesh = skin.data.copy()
    mesh.name = f"{skin.name} {name}"
    normals = posing.stored(mesh.vertices, "normal")
    mesh.vertices.foreach_set("co", (posing.vertices(skin) + off * normals).astype(np.float32).ravel())
    keep_vertices(mesh, keep)
    mesh.materials.clear()
    mesh.materials.append(plain_material(name, colour, roughness=0.7))
    return posing.add_object(mesh.name, mesh)


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
    mesh.materials.append(plain_material("Brass", (0.7, 0.45, 0.1), roughness=0.3))
    return posing.add_object(mesh.name, mesh)


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
