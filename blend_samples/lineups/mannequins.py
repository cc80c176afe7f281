# SPDX-License-Identifier: GPL-3.0-or-later
"""The mannequin, posed by its bones, also in clothes."""

from collections.abc import Callable
from functools import partial
from math import radians

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from .. import markers, posing
from ..lineup import POSE_FRAME, Lineup
from ..materials import plain_material
from ..models import mannequin
from ..models.objects import keep_vertices
from ..studio import Shot

FEET = ("foot.L", "foot.R")
FALLOFF = 2.0
# Degrees about an axis of the figure, parents first
TURNS = {
    "Y": {"spine": 14, "chest": 12, "upper.L": -42, "lower.L": -78, "upper.R": -50, "lower.R": -55},
    "X": {"thigh.L": -68, "shin.L": 88},
}
# bone -> turns in degrees about the axes of the figure
LEGS = {"thigh.L": (-62, 0, 0), "shin.L": (70, 0, 0), "thigh.R": (28, 0, 0), "shin.R": (52, 0, 0)}
ARMS = {"upper.L": (0, 66, 0), "upper.R": (0, -66, 0), "lower.L": (0, 0, -70), "lower.R": (0, 0, 70)}
RUN = {"chest": (6, 0, 10)} | LEGS | ARMS
STAND_OFF, BUTTON = 0.014, 0.016


def puppet(bone: str = "", value: tuple[float, float, float] = (0.0, 0.0, 0.0), **options: object):
    """The bones are handles, the feet are pinned, and a bone is dragged by ``value`` where one is named."""

    def drag(rig: bpy.types.Object) -> None:
        posing.operate(rig, "puppet_pose", bone=bone, value=value, **options)

    def pose(skin: bpy.types.Object) -> None:
        rig = mannequin.rig_of(skin)
        posing.operate(skin, "puppet_rig", armature=rig.name, method="mesh_puppetry")
        for name in FEET:
            rig.pose.bones[name].sinew.pin = True
            limit = rig.pose.bones[name.replace("foot", "shin")]
            limit.use_ik_limit_x, limit.ik_min_x, limit.ik_max_x = True, 0.0, 2.4
            limit.lock_ik_y = limit.lock_ik_z = True
            head = rig.data.bones[name].head_local
            markers.add_pad(rig.matrix_world @ Vector((head.x, head.y - 0.08, 0.0)), 0.105)
        posing.make_active(rig)
        key_bones(rig, drag if bone else None)
        if bone:
            bpy.context.scene.frame_set(POSE_FRAME)
            markers.add_ball(f"{rig.name} Drag", rig.matrix_world @ rig.pose.bones[bone].tail, 0.05)
            posing.check_posed(skin)

    return pose


def space(segments: bool):
    """All bones move the space around them: at their places, or along their length."""

    def pose(skin: bpy.types.Object) -> None:
        rig = mannequin.rig_of(skin)
        posing.make_active(rig)
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="SELECT")
        posing.operate(rig, "point_add", skin, source="SELECTED", method="mls", segments=segments)
        bpy.ops.object.mode_set(mode="OBJECT")
        skin.sinew.active.parameters.alpha = FALLOFF
        key_bones(rig, turn_bones)
        posing.check_posed(skin)

    return pose


def turn_bones(rig: bpy.types.Object) -> None:
    for axis, angles in TURNS.items():
        for name, degrees in angles.items():
            bpy.context.view_layer.update()
            bone = rig.pose.bones[name]
            head, turn = Matrix.Translation(bone.head), Matrix.Rotation(radians(degrees), 4, axis)
            bone.matrix = head @ turn @ head.inverted() @ bone.matrix


def key_bones(rig: bpy.types.Object, pose: Callable[[bpy.types.Object], None] | None) -> None:
    """Key all bones: at rest, as ``pose`` leaves them, and at rest again."""
    for frame in (1, POSE_FRAME, 96):
        bpy.context.scene.frame_set(frame)
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        if pose and frame == POSE_FRAME:
            pose(rig)
        for bone in rig.pose.bones:
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            bone.keyframe_insert("location", frame=frame)


def dress(skin: bpy.types.Object) -> list[bpy.types.Object]:
    """Put clothes on a mannequin; they and the skin belong to its bones."""
    rig = mannequin.rig_of(skin)
    rig.hide_render = True
    points = posing.vertices(skin)
    body = (points[:, 2] > 0.16) & (points[:, 2] < 1.53) & (np.abs(points[:, 0]) < 0.66)
    clothes = [
        _shell(skin, "Suit", body, STAND_OFF, (0.05, 0.13, 0.32)),
        _buttons(skin),
        _shell(skin, "Cap", points[:, 2] > 1.75, 0.02, (0.45, 0.04, 0.03)),
    ]
    for obj in clothes:
        obj.matrix_basis = skin.matrix_basis
    for obj in (skin, *clothes):
        obj.parent, obj.matrix_parent_inverse = rig, rig.matrix_world.inverted()
    bpy.context.view_layer.update()
    return clothes


def run(by_cage: bool):
    """A run in clothes: bones carry skin and clothes, by weights for each, or a cage around them all."""

    def pose(skin: bpy.types.Object) -> None:
        clothes, rig = dress(skin), mannequin.rig_of(skin)
        if by_cage:
            cage = posing.operate(skin, "cage_add", *clothes, method="green", faces=500).cage
            posing.carry_cage(cage, rig)
            markers.add_cage_edges(cage, 0.004)
        for obj in () if by_cage else (skin, *clothes):
            posing.weigh(obj, rig)
        for bone, angles in RUN.items():
            posing.key_turns(rig.pose.bones[bone], {1: (0, 0, 0), POSE_FRAME: angles})
        for obj in (skin, *clothes):
            if obj.sinew.deformers:
                posing.check_posed(obj)
        bpy.context.scene.frame_set(POSE_FRAME)
        posing.progress(f"{_entered(skin, clothes)} points of the clothes of {skin.name} are inside the body")

    return pose


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


def _buttons(skin: bpy.types.Object) -> bpy.types.Object:
    """Loose parts on the chest, just in front of the suit."""
    edit = bmesh.new()
    for height in (1.08, 1.17, 1.26, 1.35):
        _met, place, normal, _face = skin.ray_cast(Vector((0.0, -1.0, height)), Vector((0.0, 1.0, 0.0)))
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
    tree = BVHTree.FromObject(skin, bpy.context.evaluated_depsgraph_get())
    found = 0
    for obj in clothes:
        to_skin = skin.matrix_world.inverted() @ obj.matrix_world
        for point in posing.shape(obj):
            inside = to_skin @ Vector(point)
            place, normal, _face, _distance = tree.find_nearest(inside)
            found += (inside - place).dot(normal) < 0.0
    return found


SHOT = partial(Shot, (0.0, 0.0, 0.92), distance=26.0, light=10.0, front=-1.1)
Mannequins = partial(Lineup, build=mannequin.build, anew=True)

LINEUPS = {
    "puppet": Mannequins(
        about="A mannequin as a puppet: a hand or the hip is dragged, and its feet are pinned.",
        row={
            "Rest": puppet(),
            "Hand": puppet("hand.L", (-0.25, -0.45, 0.45)),
            "Hip": puppet("hip", (0.0, 0.08, -0.38), part="WHOLE"),
            "Hand, with balance": puppet("hand.L", (0.0, -0.75, -0.75), balance=True),
        },
        spacing=2.0,
        active=1,
        shot=SHOT(width=8.4, picture=(1440, 480)),
    ),
    "segments": Mannequins(
        about="A mannequin whose bones bend space: as places at their joints, or as segments.",
        row={"Rest": None, "Bones as places": space(False), "Bones as segments": space(True)},
        spacing=2.1,
        shot=SHOT(width=6.6, picture=(1440, 640)),
    ),
    "clothes": Mannequins(
        about="A dressed mannequin that runs: by weights for each object, or by a cage around all.",
        row={"Rest": dress, "Weights for each": run(by_cage=False), "Bones move a cage": run(by_cage=True)},
        spacing=1.5,
        shot=SHOT(width=5.6, picture=(1440, 640)),
    ),
}
