# SPDX-License-Identifier: GPL-3.0-or-later
"""A young dragon: soft shapes joined in clay, then scales, belly plates and folds pressed into its skin."""

from dataclasses import replace

import bpy
import numpy as np

from ..materials import skin_material
from .objects import Eyes, Sculpture, hollows, layered, lobes, soften, to_object
from .sculpt import Clay, vertex_normals
from .shapes import Ellipsoid, Mirrored, Squashed, Tube, path_length, rotation, smoothstep

PIECES, SHRUNK = 400, 0.9  # of a shattered dragon; each piece has this share of its size, so that gaps show
BACK_X = (-2.02, -1.86, -1.52, -1.08, -0.62, -0.10, 0.34, 0.66, 0.92)  # of joints from the tail to the neck
BACK_Z = (0.74, 0.50, 0.35, 0.42, 0.62, 0.66, 0.76, 0.97, 1.24)
THICKNESS = (0.036, 0.082, 0.145, 0.225, 0.335, 0.395, 0.350, 0.250, 0.220)
SPINE = Tube(np.stack((BACK_X, np.zeros(9), BACK_Z), 1), THICKNESS, steps=5)
EYES = Eyes(
    np.array([(1.215, 0.215, 1.43), (1.215, -0.215, 1.43)]),
    0.135,
    (0.84, 0.52, 0.06),
    (0.75, 0.33, 0.03),
    0.46,
    0.92,
)
HORN = Mirrored(Tube([(0.98, 0.17, 1.60), (0.86, 0.215, 1.75), (0.70, 0.225, 1.82)], [0.078, 0.054, 0.010]))
EAR_ROOT, EAR_SIDE = np.array((0.95, 0.285, 1.42)), (0.50, 0.10, 0.86)
EAR_LINE = EAR_ROOT + ((0, 0, 0), (-0.10, 0.12, 0.05), (-0.29, 0.27, 0.14))
EAR = Mirrored(Squashed(Tube(EAR_LINE, [0.060, 0.125, 0.030]), EAR_ROOT, EAR_SIDE, 2.8))
HOLLOW_LINE = EAR_ROOT + ((-0.04, 0.07, 0.06), (-0.10, 0.13, 0.09), (-0.20, 0.21, 0.13))
HOLLOW_MIDDLE = EAR_ROOT + (-0.10, 0.12, 0.085)
EAR_HOLLOW = Mirrored(Squashed(Tube(HOLLOW_LINE, [0.030, 0.080, 0.020]), HOLLOW_MIDDLE, EAR_SIDE, 2.6))
FORELEG, HINDLEG = (0.20, 0.135, 0.115), (0.17, 0.115, 0.105)  # radii
TAIL_END = [(-2.00, 0, 0.70), (-2.06, 0, 0.82), (-2.10, 0, 0.92), (-2.16, 0, 1.10)]
SPADE = Squashed(Tube(TAIL_END, [0.040, 0.130, 0.110, 0.010]), (-2.05, 0, 0.80), (0.96, 0, 0.26), 2.6)
TOES = ((0.645, 0.29), (0.675, 0.375), (0.645, 0.46), (-0.385, 0.34), (-0.355, 0.43), (-0.385, 0.52))
CLAW = np.array([(0.045, 0, 0.055), (0.105, 0, 0.045), (0.135, 0, 0.018)])
CLAWS = [Mirrored(Tube(CLAW + (x, y, 0.0), [0.036, 0.026, 0.006])) for x, y in TOES]


def spikes() -> list[Squashed]:
    """The row of spikes from the nape to the tail, large over the shoulders."""
    curve, radii = SPINE.path()
    length = path_length(curve)
    row = []
    for place in np.linspace(0.10, 0.93, 13):
        *at, radius = (np.interp(place * length[-1], length, c) for c in (*curve.T, radii))
        ahead = np.array([np.interp(place * length[-1] + 0.05, length, c) for c in curve.T]) - at
        along = ahead / np.linalg.norm(ahead)
        up = np.array((-along[2], 0.0, along[0]))
        size = 0.55 + 0.75 * np.sin(np.pi * place**1.15) ** 1.5
        foot = at + up * (radius - 0.03)
        rises = ((0, 0), (0.12, 0.02), (0.21, 0.085))
        line = [foot + size * (rise * up - back * along) for rise, back in rises]
        thorn = Tube(line, [0.082 * size, 0.056 * size, 0.008])
        row.append(Squashed(thorn, foot, (0, 1, 0), 1.8))
    return row


def model(voxel: float) -> tuple[Clay, Mirrored]:
    """The dragon in clay, and the line of its mouth."""
    clay = Clay((-2.35, -0.75, -0.06), (1.85, 0.75, 1.96), voxel)
    for shape, blend in (
        (SPINE, 0.05),
        (Ellipsoid((0.10, 0, 0.56), (0.46, 0.34, 0.30)), 0.15),  # belly
        (Ellipsoid((1.08, 0, 1.36), (0.350, 0.335, 0.300)), 0.12),  # head
        (Ellipsoid((1.41, 0, 1.265), (0.280, 0.215, 0.150), rotation(y=6)), 0.13),  # snout
        (Ellipsoid((1.34, 0, 1.150), (0.270, 0.185, 0.095), rotation(y=2)), 0.08),  # lower jaw
        (Mirrored(Ellipsoid((1.13, 0.205, 1.22), (0.17, 0.14, 0.13))), 0.10),  # cheeks
        (Mirrored(Ellipsoid((1.60, 0.090, 1.345), (0.075, 0.065, 0.060))), 0.06),  # nose
        (Mirrored(Tube([(0.36, 0.24, 0.70), (0.42, 0.35, 0.45), (0.42, 0.37, 0.18)], FORELEG)), 0.10),
        (Mirrored(Tube([(-0.52, 0.36, 0.44), (-0.66, 0.42, 0.26), (-0.62, 0.43, 0.12)], HINDLEG)), 0.10),
        (Mirrored(Ellipsoid((-0.46, 0.30, 0.50), (0.27, 0.17, 0.27), rotation(y=20))), 0.10),  # thigh
        (Mirrored(Ellipsoid((0.50, 0.375, 0.08), (0.175, 0.14, 0.095))), 0.07),
        (Mirrored(Ellipsoid((-0.54, 0.430, 0.08), (0.190, 0.14, 0.095))), 0.07),
        *((Mirrored(Ellipsoid((x + 0.02, y, 0.065), (0.085, 0.048, 0.060))), 0.025) for x, y in TOES),
        (EAR, 0.05),
    ):
        clay.join(shape, blend)
    clay.carve(EAR_HOLLOW, 0.03)
    for shape in (SPADE, *spikes(), HORN):
        clay.join(shape, 0.03)
    for claw in CLAWS:
        clay.join(claw, 0.008)
    for eye, gaze, axes in EYES.frames():
        clay.join(Ellipsoid(eye, (EYES.radius * 1.13,) * 3), 0.06)  # lids
        clay.join(Ellipsoid(eye + (-0.03, 0, 0.095), (0.15, 0.13, 0.080), rotation(y=-12)), 0.05)  # brow
        clay.carve(Ellipsoid(eye + 0.10 * gaze - (0, 0, 0.012), (0.20, 0.128, 0.104), axes), 0.018)
    lips = [(1.70, 0, 1.2), (1.63, 0.13, 1.195), (1.45, 0.22, 1.18), (1.26, 0.29, 1.195), (1.13, 0.36, 1.275)]
    mouth = clay.carve_line(lips, [0.024, 0.023, 0.022, 0.020, 0.010])
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
    smooth_parts = np.max([(0.8 if key == "ear" else 1.0) * part for key, part in mask.items()], axis=0)
    near_eye = EYES.distance(points)
    face = smoothstep(1.02, 1.22, x)
    # the underside: below the spine's axis, from the chin to the tail, and the lower jaw
    curve, _ = SPINE.path()
    axis_z = np.interp(x, curve[:, 0], curve[:, 2])
    below = np.degrees(np.arctan2(np.abs(y), axis_z - z))
    belly = smoothstep(62, 48, below)
    belly *= smoothstep(0.05, 0.02, spine_distance - 0.06 * smoothstep(0.62, 0.40, z))
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
    rest_points, points = points, points + height[:, None] * normals
    points[:, 2] = np.maximum(points[:, 2], 0.0)

    # colours
    shade = np.random.default_rng(3).uniform(-1, 1, cell.max() + 1)[cell]
    back = smoothstep(-0.2, 0.95, normals[:, 2])[:, None]
    colours = (1 - back) * (0.060, 0.300, 0.230) + back * (0.012, 0.130, 0.150)
    spots = smoothstep(0.35, 0.75, shade)[:, None] * scaly[:, None]
    colours = colours * (1 + 0.22 * (shade * scaly)[:, None]) + spots * (0.00, 0.10, 0.07)
    colours *= (1 - 0.55 * scaly * (1 - smoothstep(0.0, 0.022, gap)))[:, None]
    cream = np.array((0.80, 0.56, 0.30)) * (0.72 + 0.28 * np.clip(plate, 0, 1) ** 0.4)[:, None]
    cheeks = np.linalg.norm(np.abs(points) - (1.17, 0.33, 1.26), axis=1)
    layers = (
        (belly, cream),
        (mask["ear"], (0.62, 0.16, 0.09)),
        (mask["spade"], (0.64, 0.10, 0.03)),
        (mask["spike"], (0.64, 0.10, 0.03)),
        (mask["horn"], (0.62, 0.47, 0.30)),
        (mask["claw"], (0.45, 0.33, 0.22)),
        (0.55 * smoothstep(0.13, 0.03, cheeks), (0.75, 0.2, 0.12)),
        (smoothstep(0.004, -0.012, mouth.distance(rest_points) - 0.006), (0.10, 0.020, 0.020)),
        (smoothstep(EYES.radius * 1.14, EYES.radius * 1.02, near_eye), (0.012, 0.020, 0.022)),
    )
    colours = layered(colours, layers)
    colours *= np.clip(1 - 1.6 * hollows(points, quads, normals) / voxel, 0.55, 1.25)[:, None]
    made = EYES.put_in(points, quads, colours, 12)
    x, _, z = made.points.T
    made.regions = {
        "Head": np.flatnonzero((x - 0.92) * 0.80 + (z - 1.24) * 0.60 > 0.0),
        "Tail": np.flatnonzero(x < -1.80),
        "Feet": np.flatnonzero((z < 0.15) & (x > -1.0)),
    }
    return made


def build(name: str = "Dragon") -> bpy.types.Object:
    return _dressed(name, sculpture())


def _dressed(name: str, made: Sculpture) -> bpy.types.Object:
    return to_object(name, made, [skin_material("Skin", 0.42, bump=0.25, grain=90.0), EYES.material()])


def build_shattered(name: str = "Dragon") -> bpy.types.Object:
    """The skin cut into pieces that share no vertex, as scans of many parts are, each shrunk a little."""
    made = sculpture()
    centres = made.points[made.quads].mean(1)
    seeds = centres[np.random.default_rng(5).choice(len(centres), PIECES, replace=False)]
    nearest = [((part[:, None] - seeds) ** 2).sum(-1).argmin(1) for part in np.array_split(centres, 64)]
    corners = made.quads + len(made.points) * np.concatenate(nearest)[:, None]
    keys, corners = np.unique(corners, return_inverse=True)  # one vertex for each piece at an old one
    piece, old = np.divmod(keys, len(made.points))
    points = made.points[old]
    sums = np.stack([np.bincount(piece, column, PIECES) for column in points.T], -1)
    middles = (sums / np.bincount(piece, minlength=PIECES)[:, None])[piece]
    made.points, made.quads = middles + SHRUNK * (points - middles), corners.reshape(-1, 4)
    made.colours = made.colours[old]
    made.attributes = {key: values[old] for key, values in made.attributes.items()}
    made.regions = {key: np.flatnonzero(np.isin(old, held)) for key, held in made.regions.items()}
    return _dressed(name, made)
