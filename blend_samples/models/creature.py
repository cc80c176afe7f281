# SPDX-License-Identifier: GPL-3.0-or-later
"""A young dragon: soft shapes joined in clay, then scales, belly plates and folds pressed into its skin."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ..materials import eye_material, skin_material
from ..posing import make_active, vertices
from .objects import Sculpture, eye_colours, soften, to_object
from .scatter import lobes
from .sculpt import Clay, ball, neighbour_mean, vertex_normals, weld_lists
from .shapes import Ellipsoid, Mirrored, Squashed, Tube, rotation, smoothstep

PIECES, SHRUNK = 400, 0.9  # of a shattered dragon; each piece has this share of its size, so that gaps show
SKIN, EYE = 0, 1  # material slots
IRIS, PUPIL, IRIS_EDGE = (0.75, 0.33, 0.03), 0.46, 0.92  # colour; angles from the line of sight in radians

SPINE = Tube(
    [
        (-2.02, 0, 0.74),
        (-1.86, 0, 0.50),
        (-1.52, 0, 0.35),
        (-1.08, 0, 0.42),
        (-0.62, 0, 0.62),
        (-0.10, 0, 0.66),
        (0.34, 0, 0.76),
        (0.66, 0, 0.97),
        (0.92, 0, 1.24),
    ],
    [0.036, 0.082, 0.145, 0.225, 0.335, 0.395, 0.350, 0.250, 0.220],
    steps=5,
)
EYES = np.array([(1.215, 0.215, 1.43), (1.215, -0.215, 1.43)])
EYE_RADIUS = 0.135
GAZE = np.array([(0.84, 0.52, 0.06), (0.84, -0.52, 0.06)]) / np.linalg.norm((0.84, 0.52, 0.06))
HORN = Mirrored(Tube([(0.98, 0.17, 1.60), (0.86, 0.215, 1.75), (0.70, 0.225, 1.82)], [0.078, 0.054, 0.010]))
EAR_ROOT, EAR_SIDE = np.array((0.95, 0.285, 1.42)), (0.50, 0.10, 0.86)
EAR = Mirrored(
    Squashed(
        Tube(
            [EAR_ROOT, EAR_ROOT + (-0.10, 0.12, 0.05), EAR_ROOT + (-0.29, 0.27, 0.14)], [0.060, 0.125, 0.030]
        ),
        EAR_ROOT,
        EAR_SIDE,
        2.8,
    )
)
EAR_HOLLOW = Mirrored(
    Squashed(
        Tube(
            [EAR_ROOT + (-0.04, 0.07, 0.06), EAR_ROOT + (-0.10, 0.13, 0.09), EAR_ROOT + (-0.20, 0.21, 0.13)],
            [0.030, 0.080, 0.020],
        ),
        EAR_ROOT + (-0.10, 0.12, 0.085),
        EAR_SIDE,
        2.6,
    )
)
SPADE = Squashed(
    Tube(
        [(-2.00, 0, 0.70), (-2.06, 0, 0.82), (-2.10, 0, 0.92), (-2.16, 0, 1.10)], [0.040, 0.130, 0.110, 0.010]
    ),
    (-2.05, 0, 0.80),
    (0.96, 0, 0.26),
    2.6,
)
CLAWS = [
    Mirrored(
        Tube([(x + 0.045, y, 0.055), (x + 0.105, y, 0.045), (x + 0.135, y, 0.018)], [0.036, 0.026, 0.006])
    )
    for x, y in ((0.645, 0.29), (0.675, 0.375), (0.645, 0.46), (-0.385, 0.34), (-0.355, 0.43), (-0.385, 0.52))
]


def spikes() -> list[Squashed]:
    """The row of spikes from the nape to the tail, large over the shoulders."""
    curve, radii = SPINE.path()
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))
    row = []
    for place in np.linspace(0.10, 0.93, 13):
        at = [np.interp(place * length[-1], length, c) for c in (*curve.T, radii)]
        ahead = [np.interp(place * length[-1] + 0.05, length, c) for c in curve.T]
        along = (np.array(ahead) - at[:3]) / np.linalg.norm(np.array(ahead) - at[:3])
        up = np.array((-along[2], 0.0, along[0]))
        size = 0.55 + 0.75 * np.sin(np.pi * place**1.15) ** 1.5
        foot = np.array(at[:3]) + up * (at[3] - 0.03)
        tip = foot + size * (0.21 * up - 0.085 * along)
        middle = foot + size * (0.12 * up - 0.020 * along)
        thorn = Tube([foot, middle, tip], [0.082 * size, 0.056 * size, 0.008])
        row.append(Squashed(thorn, foot, (0, 1, 0), 1.8))
    return row


def model(voxel: float) -> tuple[Clay, Mirrored]:
    """The dragon in clay, and the line of its mouth."""
    clay = Clay((-2.35, -0.75, -0.06), (1.85, 0.75, 1.96), voxel)
    clay.join(SPINE)
    clay.join(Ellipsoid((0.10, 0, 0.56), (0.46, 0.34, 0.30)), 0.15)  # belly
    head = Ellipsoid((1.08, 0, 1.36), (0.350, 0.335, 0.300))
    clay.join(head, 0.12)
    clay.join(Ellipsoid((1.41, 0, 1.265), (0.280, 0.215, 0.150), rotation(y=6)), 0.13)  # snout
    clay.join(Ellipsoid((1.34, 0, 1.150), (0.270, 0.185, 0.095), rotation(y=2)), 0.08)  # lower jaw
    clay.join(Mirrored(Ellipsoid((1.13, 0.205, 1.22), (0.17, 0.14, 0.13))), 0.10)  # cheeks
    clay.join(Mirrored(Ellipsoid((1.60, 0.090, 1.345), (0.075, 0.065, 0.060))), 0.06)  # nose
    for leg, thick in (
        ([(0.36, 0.24, 0.70), (0.42, 0.35, 0.45), (0.42, 0.37, 0.18)], [0.20, 0.135, 0.115]),
        ([(-0.52, 0.36, 0.44), (-0.66, 0.42, 0.26), (-0.62, 0.43, 0.12)], [0.17, 0.115, 0.105]),
    ):
        clay.join(Mirrored(Tube(leg, thick)), 0.10)
    clay.join(Mirrored(Ellipsoid((-0.46, 0.30, 0.50), (0.27, 0.17, 0.27), rotation(y=20))), 0.10)  # thigh
    clay.join(Mirrored(Ellipsoid((0.50, 0.375, 0.08), (0.175, 0.14, 0.095))), 0.07)
    clay.join(Mirrored(Ellipsoid((-0.54, 0.430, 0.08), (0.190, 0.14, 0.095))), 0.07)
    for claw in CLAWS:
        x, y, _ = claw.shape.points[0]
        clay.join(Mirrored(Ellipsoid((x - 0.025, y, 0.065), (0.085, 0.048, 0.060))), 0.025)  # toe
    clay.join(EAR, 0.05)
    clay.carve(EAR_HOLLOW, 0.03)
    clay.join(SPADE, 0.03)
    for spike in spikes():
        clay.join(spike, 0.03)
    clay.join(HORN, 0.03)
    for claw in CLAWS:
        clay.join(claw, 0.008)
    for eye, gaze in zip(EYES, GAZE):
        side = np.cross((0, 0, 1), gaze) / np.linalg.norm(np.cross((0, 0, 1), gaze))
        frame = np.stack((gaze, side, np.cross(gaze, side)), 1)
        clay.join(Ellipsoid(eye, (EYE_RADIUS * 1.13,) * 3), 0.06)  # lids
        clay.join(Ellipsoid(eye + (-0.03, 0, 0.095), (0.15, 0.13, 0.080), rotation(y=-12)), 0.05)  # brow
        clay.carve(Ellipsoid(eye + 0.10 * gaze - (0, 0, 0.012), (0.20, 0.128, 0.104), frame), 0.018)
    line = clay.onto(
        [
            (1.70, 0.0, 1.200),
            (1.63, 0.13, 1.195),
            (1.45, 0.22, 1.180),
            (1.26, 0.29, 1.195),
            (1.13, 0.36, 1.275),
        ]
    )
    line[0, 1] = 0.0
    mouth = Mirrored(Tube(line, [0.024, 0.023, 0.022, 0.020, 0.010]))
    clay.carve(mouth, 0.02)
    clay.carve(Mirrored(Ellipsoid((1.665, 0.092, 1.372), (0.036, 0.024, 0.026))), 0.02)  # nostrils
    clay.cut_below(0.0)
    return clay, mouth


def sculpture(voxel: float = 0.0135) -> Sculpture:
    clay, mouth = model(voxel)
    points, quads = clay.skin()
    normals = vertex_normals(points, quads)
    x, y, z = points.T
    # finer than the clay needs: the place along a coarse curve would jump from corner to corner
    spine_distance, along = replace(SPINE, steps=24).nearest(points)

    hard = {
        "spike": np.min([spike.distance(points) for spike in spikes()], axis=0),
        "horn": HORN.distance(points),
        "claw": np.min([claw.distance(points) for claw in CLAWS], axis=0),
        "ear": EAR.distance(points),
        "spade": SPADE.distance(points),
    }
    mask = {key: smoothstep(0.022, 0.006, distance) for key, distance in hard.items()}
    smooth_parts = np.max(
        [mask["spike"], mask["horn"], mask["claw"], mask["spade"], 0.8 * mask["ear"]], axis=0
    )
    near_eye = np.min([np.linalg.norm(points - eye, axis=1) for eye in EYES], axis=0)
    face = smoothstep(1.02, 1.22, x)
    # the underside: below the spine's axis, from the chin to the tail, and the lower jaw
    curve, _ = SPINE.path()
    axis_z = np.interp(x, curve[:, 0], curve[:, 2])
    below = np.degrees(np.arctan2(np.abs(y), axis_z - z))
    belly = smoothstep(62, 48, below) * smoothstep(
        0.05, 0.02, spine_distance - 0.06 * smoothstep(0.62, 0.40, z)
    )
    belly *= (1 - face) * smoothstep(-1.75, -1.35, x) * (1 - smooth_parts)
    jaw = smoothstep(1.205, 1.175, z + 0.12 * (1.2 - x) * (x < 1.2)) * smoothstep(0.80, 0.95, x)
    belly = soften(np.maximum(belly, jaw), quads, 5)

    # scales: domes of cells around scattered centres
    offset, gap, cell = lobes(points, 0.062, seed=7)
    dome = smoothstep(0.0, 0.030, gap) * (1.0 - 0.35 * (offset**2).sum(1) / 0.062**2)
    scaly = (1 - belly) * (1 - smooth_parts) * smoothstep(0.17, 0.24, near_eye)
    scaly *= (1 - 0.85 * face) * smoothstep(0.10, 0.22, z + 2 * smoothstep(-0.9, -1.2, x))
    scaly = soften(scaly, quads, 4)

    # plates across the belly; folds of skin at the neck; rings on the horns
    plate = 0.5 - 0.5 * np.cos(2 * np.pi * along * 44)
    plates = soften(belly * smoothstep(1.10, 0.9, x), quads, 2) * (plate**0.35 - 0.75)
    ripple = np.sin(2 * np.pi * (along * 46 + 0.35 * np.sin(7 * y + 3 * z)))
    folds = smoothstep(0.74, 0.80, along) * smoothstep(0.95, 0.88, along) * (1 - belly) * (1 - smooth_parts)
    joints = smoothstep(0.16, 0.19, z) * smoothstep(0.32, 0.26, z) * smoothstep(0.03, 0.08, spine_distance)
    knuckles = np.sin(2 * np.pi * z / 0.045) * joints * smoothstep(-0.95, -0.85, x) * (1 - belly)
    rings = np.sin(2 * np.pi * np.linalg.norm(points - (1.02, 0, 1.5), axis=1) / 0.042) * mask["horn"]
    height = 0.0105 * scaly * (dome - 0.5) * (1 - 0.7 * folds) + 0.011 * plates
    height += 0.006 * folds * ripple + 0.004 * knuckles + 0.0028 * rings
    points = points + height[:, None] * normals
    points[:, 2] = np.maximum(points[:, 2], 0.0)

    # colours
    shade = np.random.default_rng(3).uniform(-1, 1, cell.max() + 1)[cell]
    back = smoothstep(-0.2, 0.95, normals[:, 2])[:, None]
    colours = (1 - back) * (0.060, 0.300, 0.230) + back * (0.012, 0.130, 0.150)
    spots = smoothstep(0.35, 0.75, shade)[:, None] * scaly[:, None]
    colours = colours * (1 + 0.22 * (shade * scaly)[:, None]) + spots * (0.00, 0.10, 0.07)
    colours *= (1 - 0.55 * scaly * (1 - smoothstep(0.0, 0.022, gap)))[:, None]
    cream = np.array((0.80, 0.56, 0.30)) * (0.72 + 0.28 * np.clip(plate, 0, 1) ** 0.4)[:, None]
    for weight, colour in (
        (belly, cream),
        (mask["ear"], (0.62, 0.16, 0.09)),
        (mask["spade"], (0.64, 0.10, 0.03)),
        (mask["spike"], (0.64, 0.10, 0.03)),
        (mask["horn"], (0.62, 0.47, 0.30)),
        (mask["claw"], (0.45, 0.33, 0.22)),
        (
            0.55 * smoothstep(0.13, 0.03, np.linalg.norm(np.abs(points) - (1.17, 0.33, 1.26), axis=1)),
            (0.75, 0.2, 0.12),
        ),
        (
            smoothstep(0.004, -0.012, mouth.distance(points - height[:, None] * normals) - 0.006),
            (0.10, 0.020, 0.020),
        ),
        (smoothstep(EYE_RADIUS * 1.14, EYE_RADIUS * 1.02, near_eye), (0.012, 0.020, 0.022)),
    ):
        blend = np.asarray(weight)[:, None]
        colours = (1 - blend) * colours + blend * np.asarray(colour)
    # hollows darker, ridges lighter
    hollow = np.einsum("ij,ij->i", neighbour_mean(points, quads) - points, normals) / voxel
    colours *= np.clip(1 - 1.6 * soften(hollow, quads, 1), 0.55, 1.25)[:, None]

    skin_count = len(points)
    balls = [ball(eye, EYE_RADIUS, 12) for eye in EYES]
    all_points, all_quads = weld_lists([(points, quads), *balls])
    angle = np.full(len(all_points), np.pi)
    for k, (eye, gaze) in enumerate(zip(EYES, GAZE)):
        size = len(balls[k][0])
        local = balls[k][0] - eye
        angle[skin_count + k * size : skin_count + (k + 1) * size] = np.arccos(
            np.clip(local @ gaze / EYE_RADIUS, -1, 1)
        )
    all_colours = np.vstack((colours, eye_colours(angle[skin_count:], IRIS, PUPIL, IRIS_EDGE)))

    px, _, pz = all_points.T
    return Sculpture(
        points=all_points,
        quads=all_quads,
        colours=all_colours,
        materials=np.where(np.arange(len(all_quads)) < len(quads), SKIN, EYE),
        attributes={"gaze": angle},
        regions={
            "Head": np.flatnonzero((px - 0.92) * 0.80 + (pz - 1.24) * 0.60 > 0.0),
            "Tail": np.flatnonzero(px < -1.80),
            "Feet": np.flatnonzero((pz < 0.15) & (px > -1.0)),
        },
    )


def build(name: str = "Dragon") -> bpy.types.Object:
    dragon = to_object(name, sculpture())
    dragon.data.materials.append(skin_material("Skin", roughness=0.42, bump=0.25, grain=90.0))
    dragon.data.materials.append(eye_material("Eye", IRIS, PUPIL, IRIS_EDGE))
    return dragon


def build_shattered(name: str = "Dragon") -> bpy.types.Object:
    """The skin cut into pieces that share no vertex, as scans of many parts are, each shrunk a little."""
    dragon = build(name)
    mesh = dragon.data
    centres = np.empty((len(mesh.polygons), 3), np.float32)
    mesh.polygons.foreach_get("center", centres.ravel())
    seeds = centres[np.random.default_rng(5).choice(len(centres), PIECES, replace=False)]
    piece = np.concatenate(
        [((part[:, None] - seeds) ** 2).sum(-1).argmin(1) for part in np.array_split(centres, 64)]
    )
    counts, of_corner = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    mesh.loops.foreach_get("edge_index", of_corner)
    lowest, highest = np.full(len(mesh.edges), PIECES), np.full(len(mesh.edges), -1)
    np.minimum.at(lowest, of_corner, np.repeat(piece, counts))
    np.maximum.at(highest, of_corner, np.repeat(piece, counts))
    for elements in (mesh.polygons, mesh.vertices):
        elements.foreach_set("select", np.zeros(len(elements), dtype=bool))
    mesh.edges.foreach_set("select", lowest != highest)
    make_active(dragon)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.edge_split(type="EDGE")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.tool_settings.mesh_select_mode = (True, False, False)

    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    owner = np.zeros(len(mesh.vertices), dtype=int)
    owner[corners] = np.repeat(piece, counts)
    points = vertices(dragon)
    sums = np.stack([np.bincount(owner, points[:, axis], PIECES) for axis in range(3)], -1)
    middles = sums / np.maximum(np.bincount(owner, minlength=PIECES), 1)[:, None]
    points = middles[owner] + SHRUNK * (points - middles[owner])
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.update()
    return dragon
