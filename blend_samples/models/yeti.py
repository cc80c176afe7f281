# SPDX-License-Identifier: GPL-3.0-or-later
"""A young yeti with an armature: clay shapes, locks of fur, and plain linear skin weights."""

from collections.abc import Iterator

import bpy
import numpy as np

from ..materials import skin_material
from ..posing import add_armature, vertices
from .objects import Eyes, Sculpture, add_groups, hollows, layered, lobes, soften, to_object
from .sculpt import Clay, vertex_normals
from .shapes import Ellipsoid, Mirrored, Squashed, Tube, smoothstep

VOXEL = 0.0165
SHOULDER, ELBOW, WRIST = 0.47, 1.00, 1.50  # |y| of the joints; the arms stretch sideways
ARM_HEIGHT = 1.24
EYES = Eyes(
    np.array([(0.335, 0.135, 1.715), (0.335, -0.135, 1.715)]),
    0.088,
    (0.97, 0.12, 0.03),
    (0.10, 0.30, 0.45),
    0.42,
    0.80,
)
FACE = Squashed(Ellipsoid((0.36, 0, 1.63), (0.27, 0.27, 0.235)), (0.36, 0, 1.63), (1, 0, 0), 1.0)
HORNS = Mirrored(Tube([(0.00, 0.24, 1.88), (0.00, 0.36, 1.98), (0.03, 0.38, 2.14)], [0.075, 0.055, 0.012]))
FANG = [(0.405, 0.105, 1.475), (0.435, 0.108, 1.53), (0.43, 0.110, 1.575)]
FANGS = Mirrored(Tube(FANG, [0.030, 0.026, 0.008]))
FINGER = np.array([(1.0, 1.66, 1.235), (1.25, 1.80, 1.235), (1.3, 1.885, 1.205)])
FINGERS = [Mirrored(Tube(FINGER * (x, 1, 1), [0.062, 0.060, 0.050])) for x in (-0.085, 0.005, 0.095)]
THUMB = Mirrored(Tube([(0.10, 1.56, 1.24), (0.18, 1.64, 1.24), (0.20, 1.715, 1.23)], [0.060, 0.058, 0.046]))
PALM = Mirrored(Ellipsoid((0.005, 1.62, 1.235), (0.135, 0.145, 0.100)))
FOOT = Mirrored(Ellipsoid((0.10, 0.30, 0.085), (0.25, 0.165, 0.105)))
NOSE = Ellipsoid((0.455, 0, 1.625), (0.060, 0.080, 0.050))
TOES = [Mirrored(Ellipsoid((0.30, y, 0.070), (0.085, 0.062, 0.070))) for y in (0.20, 0.305, 0.405)]


def model(voxel: float) -> tuple[Clay, Mirrored]:
    """The yeti in clay, and the line of its mouth."""
    clay = Clay((-0.62, -2.00, -0.06), (0.66, 2.00, 2.22), voxel)
    arm = [(0, 0.30, 1.26), *((0, y, ARM_HEIGHT) for y in (0.58, ELBOW, 1.22, 1.56))]
    leg = [(0, 0.24, 0.58), (0.01, 0.28, 0.32), (0.01, 0.29, 0.12)]
    for shape, blend in (
        (Ellipsoid((0, 0, 0.88), (0.42, 0.47, 0.50)), 0.05),
        (Ellipsoid((-0.02, 0, 1.22), (0.36, 0.46, 0.32)), 0.20),  # shoulders
        (Ellipsoid((0.10, 0, 0.78), (0.38, 0.38, 0.36)), 0.15),  # belly
        (Ellipsoid((0.04, 0, 1.64), (0.345, 0.375, 0.330)), 0.14),  # head
        (Ellipsoid((0.00, 0, 1.92), (0.16, 0.15, 0.12)), 0.14),  # tuft
        (Ellipsoid((0.25, 0, 1.55), (0.19, 0.24, 0.14)), 0.08),  # muzzle
        (Mirrored(Tube(arm, [0.22, 0.178, 0.158, 0.182, 0.125])), 0.12),
        (PALM, 0.06),
        *((finger, 0.03) for finger in (*FINGERS, THUMB)),
        (Mirrored(Tube(leg, [0.25, 0.205, 0.165])), 0.12),
        (FOOT, 0.05),
        *((toe, 0.025) for toe in TOES),
        (Mirrored(Ellipsoid((0.05, 0.375, 1.66), (0.075, 0.055, 0.095))), 0.03),  # ears
        (Ellipsoid((0.31, 0, 1.80), (0.11, 0.25, 0.060)), 0.06),  # brow
        (HORNS, 0.03),
    ):
        clay.join(shape, blend)
    for eye, gaze, axes in EYES.frames():
        clay.join(Ellipsoid(eye, (EYES.radius * 1.16,) * 3), 0.05)
        clay.carve(Ellipsoid(eye + 0.07 * gaze, (0.14, 0.086, 0.076), axes), 0.015)
    clay.join(NOSE, 0.03)
    lips = [(0.47, 0.0, 1.500), (0.44, 0.10, 1.505), (0.37, 0.19, 1.530), (0.30, 0.255, 1.585)]
    mouth = clay.carve_line(lips, [0.026, 0.026, 0.024, 0.010])
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

    # locks of fur: cells stretched along the way the hair hangs, each rising towards its tip
    arm = smoothstep(0.42, 0.62, side)[:, None]
    offset, gap, cell = lobes(points * ((1 - arm) * (1.0, 1.0, 0.42) + arm * (1.0, 0.5, 1.0)), 0.062, seed=11)
    tip = np.where(arm[:, 0] > 0.5, np.sign(y) * offset[:, 1], -offset[:, 2]) / 0.062
    lock = smoothstep(0.0, 0.032, gap) * (0.75 + 0.75 * np.clip(tip, -0.6, 0.9))
    fur = 1 - bare
    height = 0.022 * fur * (lock - 0.55) + 0.004 * horn * np.sin(2 * np.pi * z / 0.045)
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
    middle = np.linalg.norm((points - (0.45, 0, 0.82)) / (0.5, 0.40, 0.42), axis=1)
    belly = smoothstep(1.0, 0.75, middle)[:, None]
    colours = colours * (1 - 0.5 * belly) + 0.5 * belly * colours * (1.15, 1.08, 1.0)
    cheek = np.linalg.norm(np.column_stack((x - 0.33, side - 0.205, z - 1.61)), axis=1)
    layers = (
        (bare, (0.10, 0.26, 0.52)),
        (0.6 * smoothstep(0.10, 0.02, cheek), (0.62, 0.20, 0.30)),
        (smoothstep(0.020, -0.005, NOSE.distance(points)), (0.035, 0.075, 0.20)),
        (horn, (0.50, 0.40, 0.30)),
        (smoothstep(0.002, -0.012, mouth.distance(rest_points) - 0.006), (0.045, 0.012, 0.040)),
        (fang, (0.85, 0.80, 0.68)),
        (smoothstep(EYES.radius * 1.12, EYES.radius * 1.02, EYES.distance(rest_points)), (0.02, 0.035, 0.09)),
    )
    colours = layered(colours, layers)
    colours *= np.clip(1 - 1.2 * hollows(points, quads, normals) / voxel, 0.6, 1.2)[:, None]
    made = EYES.put_in(points, quads, colours, 10)
    made.attributes["band"] = sum(elbow_bands(made.points).values())
    return made


# name: (head, tail, parent); arms and legs once, the other side is mirrored
BONES = {
    "hips": ((0, 0, 0.45), (0, 0, 0.75), ""),
    "spine": ((0, 0, 0.75), (0, 0, 1.36), "hips"),
    "head": ((0, 0, 1.36), (0, 0, 1.95), "spine"),
    "upper_arm.L": ((0, SHOULDER, ARM_HEIGHT), (0, ELBOW, ARM_HEIGHT), "spine"),
    "forearm.L": ((0, ELBOW, ARM_HEIGHT), (0, WRIST, ARM_HEIGHT), "upper_arm.L"),
    "hand.L": ((0, WRIST, ARM_HEIGHT), (0, 1.80, ARM_HEIGHT), "forearm.L"),
    "elbow.L": ((0, ELBOW, ARM_HEIGHT), (0, ELBOW + 0.2, ARM_HEIGHT), "upper_arm.L"),  # turns half as far
    "thigh.L": ((0, 0.26, 0.50), (0.01, 0.29, 0.14), "hips"),
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
    skin = skin_material("Skin", roughness=0.5, bump=0.2, grain=70.0, band="band")
    body = to_object(name, sculpture(voxel), [skin, EYES.material()])
    points = vertices(body)
    for bone, values in skin_weights(points).items():
        group = body.vertex_groups.new(name=bone)
        steps = np.round(np.clip(values, 0, 1) * 64).astype(int)  # one call per level, not per vertex
        for step in range(1, 65):
            group.add(np.flatnonzero(steps == step).tolist(), step / 64, "REPLACE")
    bands = elbow_bands(points).items()
    add_groups(body, {"Elbow" + suffix: np.flatnonzero(band > 0.5) for suffix, band in bands})
    add_groups(body, {"Joints": np.flatnonzero(np.abs(np.abs(points[:, 1]) - ELBOW) < 0.30)})

    rig = add_armature(f"{name} Rig", all_bones(), side=(1, 0, 0))
    rig.show_in_front = True
    for suffix in (".L", ".R"):
        rig.data.bones["elbow" + suffix].use_deform = False
        half = rig.pose.bones["elbow" + suffix].constraints.new("COPY_ROTATION")
        half.target, half.subtarget = rig, "forearm" + suffix
        half.influence = 0.5
        half.owner_space = half.target_space = "LOCAL"
        rig.pose.bones["elbow" + suffix].rotation_mode = "QUATERNION"
    body.parent = rig
    body.modifiers.new("Armature", "ARMATURE").object = rig
    return body, rig


def all_bones() -> Iterator[tuple[str, tuple, tuple, str]]:
    for bone, (head, tail, parent) in BONES.items():
        yield bone, head, tail, parent
        if bone.endswith(".L"):
            mirrored = [(x, -y, z) for x, y, z in (head, tail)]
            yield bone.replace(".L", ".R"), *mirrored, parent.replace(".L", ".R")
