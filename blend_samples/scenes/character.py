# SPDX-License-Identifier: GPL-3.0-or-later
"""A yeti with an armature: its elbows collapse under linear skinning, and a Sinew deformer restores them."""

from math import radians

import bpy

from .. import posing
from ..models import yeti
from ..studio import Shot, empty_scene, open_at

POSE_FRAME = 36
SPACING, HEADING = 2.95, -84.0
SHOT = Shot((-0.08, 0.0, 0.98), width=6.9, elevation=7.0, lit=1.0, light=7.0, text=0.19, front=-1.75)
# bone -> frame -> Euler angles in degrees; the left arm flexes, the right forearm twists
FLEX = {
    "upper_arm.L": {1: (0, 0, 0), POSE_FRAME: (0, 0, 12), 60: (0, 0, 12), 96: (0, 0, 0)},
    "forearm.L": {1: (0, 0, 0), POSE_FRAME: (0, 0, 118), 48: (0, 0, 84), 60: (0, 0, 118), 96: (0, 0, 0)},
    "upper_arm.R": {1: (0, 0, 0), POSE_FRAME: (0, 0, 34), 60: (0, 0, 34), 96: (0, 0, 0)},
    "forearm.R": {1: (0, 0, 0), POSE_FRAME: (0, 140, 0), 48: (0, 90, 0), 60: (0, 140, 0), 96: (0, 0, 0)},
    "head": {1: (0, 0, 0), POSE_FRAME: (0, 14, 8), 60: (0, 14, -6), 96: (0, 0, 0)},
    "spine": {1: (0, 0, 0), POSE_FRAME: (0, -6, -4), 60: (0, -6, 4), 96: (0, 0, 0)},
}


def make() -> bpy.types.Scene:
    scene = empty_scene()
    first, rig = yeti.build()
    second, second_rig = first.copy(), rig.copy()
    second.parent = second.modifiers["Armature"].object = second_rig
    for joint in second_rig.pose.bones:
        for constraint in joint.constraints:
            constraint.target = second_rig
    for obj in (second, second_rig):
        scene.collection.objects.link(obj)
    bodies = {"Armature": (first, rig), "Armature + Sinew": (second, second_rig)}
    places = posing.places(2, SPACING)
    for (label, (body, bones)), x in zip(bodies.items(), places):
        body.name, bones.name = f"Yeti {label}", f"Rig {label}"
        bones.location.x, bones.rotation_euler.z = x, radians(HEADING)
    bpy.context.view_layer.update()
    first.color[3], second.color[3] = 0.0, 1.0  # the band of the handle shows on the corrected one only
    correct_elbows(second, second_rig)
    for bones in (rig, second_rig):
        for bone, keys in FLEX.items():
            posing.key_angles(bones.pose.bones[bone], keys)
        bones.hide_render = True
    posing.check_posed(second, 1, POSE_FRAME)
    SHOT.set_up(scene, zip(bodies, places))
    open_at(scene, POSE_FRAME, second)
    return scene


def correct_elbows(body: bpy.types.Object, rig: bpy.types.Object) -> None:
    """A band of skin at each elbow rides on a bone that turns half as far as the forearm. Around it the
    correction fades out smoothly; the rest of the body stays as the armature poses it."""
    posing.add_deformer(body, "thin_shell")
    for suffix in (".L", ".R"):
        bone = "elbow" + suffix
        ring = posing.add_region(body, "HANDLE", "Elbow" + suffix, control_object=rig.name, bone=bone)
        ring.from_rest = True  # the bone carries the ring all the way: it replaces the collapsed skin
    posing.add_region(body, "SUPPORT", "Joints")
