# SPDX-License-Identifier: GPL-3.0-or-later
"""A mannequin whose bones bend space: as places they pull at the joints, as segments along their length."""

from __future__ import annotations

from math import radians

import bpy
from mathutils import Matrix, Vector

from . import posing, studio
from .puppet import mannequin

POSE_FRAME = 40
SPACING = 2.1
FALLOFF = 2.0
# Label -> whether bones act along their length; None for rest.
FIGURES = {"Rest": None, "Bones as places": False, "Bones as segments": True}
# Bone -> degrees about an axis of the figure, parents first.
TURNS = {
    "spine": (14.0, (0.0, 1.0, 0.0)),
    "chest": (12.0, (0.0, 1.0, 0.0)),
    "upper.L": (-42.0, (0.0, 1.0, 0.0)),
    "lower.L": (-78.0, (0.0, 1.0, 0.0)),
    "upper.R": (-50.0, (0.0, 1.0, 0.0)),
    "lower.R": (-55.0, (0.0, 1.0, 0.0)),
    "thigh.L": (-68.0, (1.0, 0.0, 0.0)),
    "shin.L": (88.0, (1.0, 0.0, 0.0)),
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Segments")
    places = [SPACING * (k - 0.5 * (len(FIGURES) - 1)) for k in range(len(FIGURES))]
    skins = []
    for (label, whole), x in zip(FIGURES.items(), places):
        skin, rig = mannequin(label)
        skin.location.x = rig.location.x = x
        bpy.context.view_layer.update()
        skins.append(skin)
        if whole is not None:
            pose(skin, rig, whole)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.0, 0.0, 0.92), distance=26.0, elevation=10.0, width=6.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for label, x in zip(FIGURES, places):
        studio.add_label(scene, label, (x, -1.1, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, height=640)
    studio.open_at(scene, POSE_FRAME, skins[-1])
    return scene


def pose(skin: bpy.types.Object, rig: bpy.types.Object, whole: bool) -> None:
    """Let all bones move the space around them, and key the figure at rest and posed."""
    posing.make_active(rig)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.select_all(action="SELECT")
    skin.select_set(True)
    answer = bpy.ops.sinew.point_add(source="SELECTED", method="mls", segments=whole)
    posing.expect(answer, f"{skin.name}: point_add")
    bpy.ops.object.mode_set(mode="OBJECT")
    skin.sinew.active.parameters.alpha = FALLOFF
    for frame, turns in ((1, {}), (POSE_FRAME, TURNS), (96, {})):
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        for name, (degrees, axis) in turns.items():
            turn(rig, name, Matrix.Rotation(radians(degrees), 4, Vector(axis)))
        for bone in rig.pose.bones:
            bone.keyframe_insert("rotation_quaternion", frame=frame)
    posing.check_posed(skin, 1, POSE_FRAME)


def turn(rig: bpy.types.Object, name: str, rotation: Matrix) -> None:
    """Turn a bone about its head."""
    bpy.context.view_layer.update()
    bone = rig.pose.bones[name]
    head = Matrix.Translation(bone.head)
    bone.matrix = head @ rotation @ head.inverted() @ bone.matrix
