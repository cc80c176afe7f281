# SPDX-License-Identifier: GPL-3.0-or-later
"""A dragon whose armature carries a cage of 500 faces instead of a mesh of 88,000 vertices."""

from __future__ import annotations

import itertools

import bpy
from mathutils import Vector

from .. import markers, posing
from ..lineup import POSE_FRAME, Lineup
from ..models import creature
from ..studio import Shot

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
    return Lineup(
        title="Rig",
        build=creature.build,
        row={"Rest": None, "Armature, Cage, Harmonic": pose},
        spacing=3.0,
        heading=-49.0,
        shot=Shot(
            (-0.06, 0.0, 0.90), 6.6, 13.0, 26.0, light=8.0, picture=(1080, 520), front=-1.55, aside=0.12
        ),
    ).make()


def pose(dragon: bpy.types.Object) -> None:
    cage = posing.add_cage(dragon, "harmonic", faces=500)
    rig = add_armature(dragon)
    posing.carry_cage(cage, rig)
    for bone, keys in TURNS.items():
        posing.key_turns(rig.pose.bones[bone], keys)
    markers.add_cage_edges(cage, 0.006)
    posing.check_posed(dragon, 1, POSE_FRAME)


def add_armature(dragon: bpy.types.Object) -> bpy.types.Object:
    """One bone for each piece of the chains, in the frame of the dragon; legs on both sides."""
    data = bpy.data.armatures.new("Dragon Rig")
    data.display_type = "STICK"
    rig = posing.add_object("Dragon Rig", data, dragon)
    rig.show_in_front, rig.hide_render = True, True
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
