# SPDX-License-Identifier: GPL-3.0-or-later
"""A young yeti with an armature: clay shapes, locks of fur, and plain linear skin weights."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from ..materials import eye_material, skin_material
from ..posing import add_object, vertices
from .objects import Sculpture, add_groups, eye_colours, soften, to_object
from .scatter import lobes
from .sculpt import Clay, ball, neighbour_mean, vertex_normals, weld_lists
from .shapes import Ellipsoid, Mirrored, Squashed, Tube, smoothstep

SKIN, EYE = 0, 1  # material slots
VOXEL = 0.0165
IRIS, PUPIL, IRIS_EDGE = (0.10, 0.30, 0.45), 0.42, 0.80  # colour; angles from the line of sight in radians

SHOULDER, ELBOW, WRIST = 0.47, 1.00, 1.50  # |y| of the joints; the arms stretch sideways
ARM_HEIGHT = 1.24
EYES = np.array([(0.335, 0.135, 1.715), (0.335, -0.135, 1.715)])
EYE_RADIUS = 0.088
GAZE = np.array([(0.97, 0.12, 0.03), (0.97, -0.12, 0.03)]) / np.linalg.norm((0.97, 0.12, 0.03))
FACE = Squashed(Ellipsoid((0.36, 0, 1.63), (0.27, 0.27, 0.235)), (0.36, 0, 1.63), (1, 0, 0), 1.0)
HORNS = Mirrored(Tube([(0.00, 0.24, 1.88), (0.00, 0.36, 1.98), (0.03, 0.38, 2.14)], [0.075, 0.055, 0.012]))
FANGS = Mirrored(
    Tube([(0.405, 0.105, 1.475), (0.435, 0.108, 1.53), (0.43, 0.110, 1.575)], [0.030, 0.026, 0.008])
)
FINGERS = [
    Mirrored(
        Tube([(x, 1.66, 1.235), (x * 1.25, 1.80, 1.235), (x * 1.3, 1.885, 1.205)], [0.062, 0.060, 0.050])
    )
    for x in (-0.085, 0.005, 0.095)
]
THUMB = Mirrored(Tube([(0.10, 1.56, 1.24), (0.18, 1.64, 1.24), (0.20, 1.715, 1.23)], [0.060, 0.058, 0.046]))
PALM = Mirrored(Ellipsoid((0.005, 1.62, 1.235), (0.135, 0.145, 0.100)))
FOOT = Mirrored(Ellipsoid((0.10, 0.30, 0.085), (0.25, 0.165, 0.105)))
TOES = [Mirrored(Ellipsoid((0.30, y, 0.070), (0.085, 0.062, 0.070))) for y in (0.20, 0.305, 0.405)]


def model(voxel: float) -> tuple[Clay, Mirrored]:
    """The yeti in clay, and the line of its mouth."""
    clay = Clay((-0.62, -2.00, -0.06), (0.66, 2.00, 2.22), voxel)
    clay.join(Ellipsoid((0, 0, 0.88), (0.42, 0.47, 0.50)))
    clay.join(Ellipsoid((-0.02, 0, 1.22), (0.36, 0.46, 0.32)), 0.20)  # shoulders
    clay.join(Ellipsoid((0.10, 0, 0.78), (0.38, 0.38, 0.36)), 0.15)  # belly
    clay.join(Ellipsoid((0.04, 0, 1.64), (0.345, 0.375, 0.330)), 0.14)  # head
    clay.join(Ellipsoid((0.00, 0, 1.92), (0.16, 0.15, 0.12)), 0.14)  # tuft
    clay.join(Ellipsoid((0.25, 0, 1.55), (0.19, 0.24, 0.14)), 0.08)  # muzzle
    clay.join(
        Mirrored(
            Tube(
                [
                    (0, 0.30, 1.26),
                    (0, 0.58, ARM_HEIGHT),
                    (0, ELBOW, ARM_HEIGHT),
                    (0, 1.22, ARM_HEIGHT),
                    (0, 1.56, ARM_HEIGHT),
                ],
                [0.22, 0.178, 0.158, 0.182, 0.125],
            )
        ),
        0.12,
    )
    clay.join(PALM, 0.06)
    for finger in (*FINGERS, THUMB):
        clay.join(finger, 0.03)
    clay.join(
        Mirrored(Tube([(0, 0.24, 0.58), (0.01, 0.28, 0.32), (0.01, 0.29, 0.12)], [0.25, 0.205, 0.165])), 0.12
    )
    clay.join(FOOT, 0.05)
    for toe in TOES:
        clay.join(toe, 0.025)
    clay.join(Mirrored(Ellipsoid((0.05, 0.375, 1.66), (0.075, 0.055, 0.095))), 0.03)  # ears
    clay.join(Ellipsoid((0.31, 0, 1.80), (0.11, 0.25, 0.060)), 0.06)  # brow
    clay.join(HORNS, 0.03)
    for eye, gaze in zip(EYES, GAZE):
        side = np.cross((0, 0, 1), gaze) / np.linalg.norm(np.cross((0, 0, 1), gaze))
        frame = np.stack((gaze, side, np.cross(gaze, side)), 1)
        clay.join(Ellipsoid(eye, (EYE_RADIUS * 1.16,) * 3), 0.05)
        clay.carve(Ellipsoid(eye + 0.07 * gaze, (0.14, 0.086, 0.076), frame), 0.015)
    clay.join(Ellipsoid((0.455, 0, 1.625), (0.060, 0.080, 0.050)), 0.03)  # nose
    line = clay.onto([(0.47, 0.0, 1.500), (0.44, 0.10, 1.505), (0.37, 0.19, 1.530), (0.30, 0.255, 1.585)])
    line[0, 1] = 0.0
    mouth = Mirrored(Tube(line, [0.026, 0.026, 0.024, 0.010]))
    clay.carve(mouth, 0.02)
    clay.join(FANGS, 0.008)
    clay.cut_below(0.0)
    return clay, mouth


def sculpture(voxel: float = VOXEL) -> Sculpture:
    clay, mouth = model(voxel)
    points, quads = clay.skin()
    normals = vertex_normals(points, quads)
    x, y, z = points.T
    side = np.abs(y)

    def near(shape, low: float = 0.025, high: float = 0.004) -> np.ndarray:
        return smoothstep(low, high, shape.distance(points))

    horn, fang = near(HORNS), near(FANGS, 0.012, 0.004)
    hand = smoothstep(0.745, 0.765, side + 0.012 * np.sin(9 * np.arctan2(z - ARM_HEIGHT, x)))
    foot = np.maximum(near(FOOT, 0.05, 0.02), np.max([near(toe) for toe in TOES], axis=0)) * (z < 0.3)
    face = smoothstep(0.02, -0.05, FACE.distance(points)) * smoothstep(0.16, 0.24, x)
    bare = soften(np.max([hand, foot, face, horn, fang], axis=0), quads, 2)
    near_eye = np.min([np.linalg.norm(points - eye, axis=1) for eye in EYES], axis=0)

    # locks of fur: cells stretched along the way the hair hangs, each rising towards its tip
    arm = smoothstep(0.42, 0.62, side)[:, None]
    offset, gap, cell = lobes(
        points * ((1 - arm) * (1.0, 1.0, 0.42) + arm * (1.0, 0.50, 1.0)), 0.062, seed=11
    )
    tip = np.where(arm[:, 0] > 0.5, np.sign(y) * offset[:, 1], -offset[:, 2]) / 0.062
    lock = smoothstep(0.0, 0.032, gap) * (0.75 + 0.75 * np.clip(tip, -0.6, 0.9))
    fur = 1 - bare
    height = 0.022 * fur * (lock - 0.55)
    height += 0.004 * horn * np.sin(2 * np.pi * z / 0.045)
    knuckle = (
        smoothstep(1.70, 1.72, side) * smoothstep(1.82, 1.80, side) * smoothstep(0.2, 0.8, normals[:, 2])
    )
    height += 0.003 * np.sin(2 * np.pi * side / 0.022) * knuckle
    rest_points, points = points, points + height[:, None] * normals
    points[:, 2] = np.maximum(points[:, 2], 0.0)

    shade = np.random.default_rng(5).uniform(-1, 1, cell.max() + 1)[cell]
    low = smoothstep(1.1, 0.1, z)[:, None]
    colours = (1 - low) * (0.76, 0.80, 0.86) + low * (0.50, 0.60, 0.78)
    colours *= (1 + 0.07 * shade - 0.42 * (1 - smoothstep(0.0, 0.035, gap)))[:, None]
    belly = smoothstep(1.0, 0.75, np.linalg.norm((points - (0.45, 0, 0.82)) / (0.5, 0.40, 0.42), axis=1))[
        :, None
    ]
    colours = colours * (1 - 0.5 * belly) + 0.5 * belly * colours * (1.15, 1.08, 1.0)
    cheek = smoothstep(
        0.10, 0.02, np.linalg.norm(np.column_stack((x - 0.33, side - 0.205, z - 1.61)), axis=1)
    )
    skin = np.array((0.10, 0.26, 0.52))
    for weight, colour in (
        (bare, skin),
        (0.6 * cheek, (0.62, 0.20, 0.30)),
        (
            smoothstep(0.020, -0.005, Ellipsoid((0.455, 0, 1.625), (0.060, 0.080, 0.050)).distance(points)),
            (0.035, 0.075, 0.20),
        ),
        (horn, (0.50, 0.40, 0.30)),
        (smoothstep(0.002, -0.012, mouth.distance(rest_points) - 0.006), (0.045, 0.012, 0.040)),
        (fang, (0.85, 0.80, 0.68)),
        (smoothstep(EYE_RADIUS * 1.12, EYE_RADIUS * 1.02, near_eye), (0.02, 0.035, 0.09)),
    ):
        blend = np.asarray(weight)[:, None]
        colours = (1 - blend) * colours + blend * np.asarray(colour)
    hollow = np.einsum("ij,ij->i", neighbour_mean(points, quads) - points, normals) / voxel
    colours *= np.clip(1 - 1.2 * soften(hollow, quads, 1), 0.6, 1.2)[:, None]

    balls = [ball(eye, EYE_RADIUS, 10) for eye in EYES]
    all_points, all_quads = weld_lists([(points, quads), *balls])
    angle = np.full(len(all_points), np.pi)
    start = len(points)
    for (globe, _), eye, gaze in zip(balls, EYES, GAZE):
        angle[start : start + len(globe)] = np.arccos(np.clip((globe - eye) @ gaze / EYE_RADIUS, -1, 1))
        start += len(globe)
    return Sculpture(
        points=all_points,
        quads=all_quads,
        colours=np.vstack((colours, eye_colours(angle[len(points) :], IRIS, PUPIL, IRIS_EDGE))),
        materials=np.where(np.arange(len(all_quads)) < len(quads), SKIN, EYE),
        attributes={"gaze": angle, "band": sum(elbow_bands(all_points).values())},
    )


# name: (head, tail, parent); arms and legs once, the other side is mirrored
CENTRE_BONES = {
    "hips": ((0, 0, 0.45), (0, 0, 0.75), None),
    "spine": ((0, 0, 0.75), (0, 0, 1.36), "hips"),
    "head": ((0, 0, 1.36), (0, 0, 1.95), "spine"),
}
SIDE_BONES = {
    "upper_arm": ((0, SHOULDER, ARM_HEIGHT), (0, ELBOW, ARM_HEIGHT), "spine"),
    "forearm": ((0, ELBOW, ARM_HEIGHT), (0, WRIST, ARM_HEIGHT), "upper_arm"),
    "hand": ((0, WRIST, ARM_HEIGHT), (0, 1.80, ARM_HEIGHT), "forearm"),
    "elbow": (
        (0, ELBOW, ARM_HEIGHT),
        (0, ELBOW + 0.2, ARM_HEIGHT),
        "upper_arm",
    ),  # turns half as far as the forearm
    "thigh": ((0, 0.26, 0.50), (0.01, 0.29, 0.14), "hips"),
}


def elbow_bands(points: np.ndarray) -> dict[str, np.ndarray]:
    """Masks (n,) of the handles: the outside of the left elbow, which bends; a ring at the right."""
    _, y, z = points.T
    ring = smoothstep(0.044, 0.036, np.abs(np.abs(y) - ELBOW))
    outside = smoothstep(ARM_HEIGHT + 0.03, ARM_HEIGHT + 0.02, z)
    return {".L": (y > 0) * ring * outside, ".R": (y < 0) * ring}


def skin_weights(points: np.ndarray) -> dict[str, np.ndarray]:
    """Bone name -> (n,) weights that sum to one: blends across each joint, as a painter would start."""
    _, y, z = points.T
    side = np.abs(y)
    arm = smoothstep(0.40, 0.64, side) * smoothstep(0.78, 0.98, z)
    fore = smoothstep(ELBOW - 0.14, ELBOW + 0.14, side)
    hand = smoothstep(WRIST - 0.09, WRIST + 0.06, side)
    head = smoothstep(1.34, 1.50, z) * (1 - arm)
    upper = smoothstep(0.55, 0.95, z)
    thigh = smoothstep(0.52, 0.30, z) * smoothstep(0.02, 0.10, side)
    weights = {
        "head": head,
        "spine": (1 - arm - head) * upper,
        "hips": (1 - arm - head) * (1 - upper) * (1 - thigh),
    }
    for suffix, here in ((".L", y > 0), (".R", y <= 0)):
        weights["upper_arm" + suffix] = here * arm * (1 - fore)
        weights["forearm" + suffix] = here * arm * fore * (1 - hand)
        weights["hand" + suffix] = here * arm * fore * hand
        weights["thigh" + suffix] = here * (1 - arm - head) * (1 - upper) * thigh
    return weights


def build(name: str = "Yeti", voxel: float = VOXEL) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The mesh with its skin weights and elbow regions, and the armature that carries it."""
    body = to_object(name, sculpture(voxel))
    body.data.materials.append(skin_material("Skin", roughness=0.5, bump=0.2, grain=70.0, band="band"))
    body.data.materials.append(eye_material("Eye", IRIS, PUPIL, IRIS_EDGE))
    points = vertices(body)
    for bone, values in skin_weights(points).items():
        group = body.vertex_groups.new(name=bone)
        steps = np.round(np.clip(values, 0, 1) * 64).astype(int)  # one call per level, not per vertex
        for step in range(1, 65):
            group.add(np.flatnonzero(steps == step).tolist(), step / 64, "REPLACE")
    bands = elbow_bands(points).items()
    add_groups(body, {"Elbow" + suffix: np.flatnonzero(band > 0.5) for suffix, band in bands})
    add_groups(body, {"Joints": np.flatnonzero(np.abs(np.abs(points[:, 1]) - ELBOW) < 0.30)})

    armature = add_armature(f"{name} Rig")
    body.parent = armature
    skin = body.modifiers.new("Armature", "ARMATURE")
    skin.object = armature
    return body, armature


def add_armature(name: str) -> bpy.types.Object:
    data = bpy.data.armatures.new(name)
    data.display_type = "STICK"
    rig = add_object(name, data)
    rig.show_in_front = True
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones = dict(CENTRE_BONES)
    for bone, (head, tail, parent) in SIDE_BONES.items():
        for suffix, flip in ((".L", 1), (".R", -1)):
            above = parent + suffix if parent in SIDE_BONES else parent
            bones[bone + suffix] = (
                (head[0], flip * head[1], head[2]),
                (tail[0], flip * tail[1], tail[2]),
                above,
            )
    for bone, (head, tail, parent) in bones.items():
        edit = data.edit_bones.new(bone)
        edit.head, edit.tail = Vector(head), Vector(tail)
        edit.align_roll(Vector((1, 0, 0)))
        edit.parent = data.edit_bones[parent] if parent else None
        edit.use_deform = not bone.startswith("elbow")
    bpy.ops.object.mode_set(mode="OBJECT")
    for suffix in (".L", ".R"):
        half = rig.pose.bones["elbow" + suffix].constraints.new("COPY_ROTATION")
        half.target, half.subtarget = rig, "forearm" + suffix
        half.influence = 0.5
        half.owner_space = half.target_space = "LOCAL"
        rig.pose.bones["elbow" + suffix].rotation_mode = "QUATERNION"
    return rig
