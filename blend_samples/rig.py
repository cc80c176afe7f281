# SPDX-License-Identifier: GPL-3.0-or-later
"""A dragon whose armature carries a cage of 500 faces instead of a mesh of 88,000 vertices."""

from __future__ import annotations

import itertools

import bpy
from mathutils import Vector

from . import animals, markers, posing, studio

POSE_FRAME = 40
SPACING, HEADING = 3.0, -49.0
LABELS = ("Rest", "Armature, Cage, Harmonic")

# in the dragon's own frame: x ahead, y to its left
CHAINS = {
    "body": [(-0.60, 0.0, 0.62), (0.36, 0.0, 0.76)],
    "neck": [(0.36, 0.0, 0.76), (0.66, 0.0, 0.97), (0.92, 0.0, 1.24)],
    "head": [(0.92, 0.0, 1.24), (1.55, 0.0, 1.30)],
    "tail": [
        (-0.60, 0.0, 0.62),
        (-1.08, 0.0, 0.42),
        (-1.52, 0.0, 0.35),
        (-1.86, 0.0, 0.50),
        (-2.08, 0.0, 0.95),
    ],
    "foreleg": [(0.40, 0.30, 0.55), (0.45, 0.37, 0.05)],
    "hindleg": [(-0.56, 0.36, 0.44), (-0.58, 0.43, 0.05)],
}
PARENTS = {"neck": "body", "head": "neck.002", "tail": "body", "foreleg": "body", "hindleg": "body"}
PAIRS = ("foreleg", "hindleg")
# bone -> frame -> turns in degrees about the dragon's own axes
TURNS = {
    "neck.001": {1: (0, 0, 0), POSE_FRAME: (0, -6, -10), 64: (0, 6, 10), 96: (0, 0, 0)},
    "neck.002": {1: (0, 0, 0), POSE_FRAME: (0, -8, -12), 64: (0, 6, 12), 96: (0, 0, 0)},
    "head": {1: (0, 0, 0), POSE_FRAME: (14, -2, -16), 64: (-12, 6, 14), 96: (0, 0, 0)},
    "tail.001": {1: (0, 0, 0), POSE_FRAME: (0, 10, 10), 64: (0, 4, -14), 96: (0, 0, 0)},
    "tail.002": {1: (0, 0, 0), POSE_FRAME: (0, 16, 14), 64: (0, 6, -20), 96: (0, 0, 0)},
    "tail.003": {1: (0, 0, 0), POSE_FRAME: (0, 22, 16), 64: (0, 8, -24), 96: (0, 0, 0)},
    "tail.004": {1: (0, 0, 0), POSE_FRAME: (0, 20, 14), 64: (0, 8, -20), 96: (0, 0, 0)},
}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Rig")
    dragons = posing.line_up(animals.dragon(), LABELS, SPACING, HEADING)
    posed = dragons[-1]
    cage = posing.add_cage(posed, "harmonic", faces=500)
    rig = add_armature(posed)
    carry_cage(cage, rig)
    key_bones(rig)
    markers.add_cage_edges(cage, 0.006)
    posing.check_posed(posed, 1, POSE_FRAME)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.06, 0.0, 0.90), distance=26.0, elevation=13.0, width=6.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=8.0)
    for dragon, label in zip(dragons, LABELS):
        studio.add_label(scene, label, (dragon.location.x + 0.12, -1.55, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1080, height=520)
    studio.open_at(scene, POSE_FRAME, posed)
    return scene


def add_armature(dragon: bpy.types.Object) -> bpy.types.Object:
    """One bone for each piece of the chains, in the frame of the dragon; legs on both sides."""
    data = bpy.data.armatures.new("Dragon Rig")
    data.display_type = "STICK"
    rig = bpy.data.objects.new("Dragon Rig", data)
    rig.show_in_front, rig.hide_render = True, True
    rig.parent = dragon
    bpy.context.scene.collection.objects.link(rig)
    posing.make_active(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for chain, joints in CHAINS.items():
        for suffix, side in ((".L", 1), (".R", -1)) if chain in PAIRS else (("", 1),):
            above = data.edit_bones.get(PARENTS.get(chain, ""))
            for k, (head, tail) in enumerate(itertools.pairwise(joints), 1):
                number = f".{k:03}" if len(joints) > 2 else ""
                bone = data.edit_bones.new(chain + number + suffix)
                bone.head, bone.tail = (Vector((x, side * y, z)) for x, y, z in (head, tail))
                bone.align_roll(Vector((0, 1, 0)))
                bone.parent = above
                above = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def carry_cage(cage: bpy.types.Object, rig: bpy.types.Object) -> None:
    """Parent the cage to the armature as Ctrl P, With Automatic Weights does."""
    posing.make_active(rig)
    cage.select_set(True)
    bpy.context.view_layer.update()
    place = cage.matrix_world.copy()
    posing.expect(bpy.ops.object.parent_set(type="ARMATURE_AUTO"), "parent_set(type='ARMATURE_AUTO')")
    bpy.context.view_layer.update()
    if (cage.matrix_world.translation - place.translation).length > 1e-4:
        raise posing.SampleError("The cage did not stay in its place")
    if any(not vertex.groups for vertex in cage.data.vertices):
        raise posing.SampleError("The armature leaves vertices of the cage behind")


def key_bones(rig: bpy.types.Object) -> None:
    for bone, keys in TURNS.items():
        joint = rig.pose.bones[bone]
        joint.rotation_mode = "QUATERNION"
        axes = joint.bone.matrix_local.to_quaternion()
        for frame, angles in keys.items():
            turn = posing.Move(turn=angles).matrix().to_quaternion()
            joint.rotation_quaternion = axes.inverted() @ turn @ axes
            joint.keyframe_insert("rotation_quaternion", frame=frame)
