# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot, the cow by Keenan Crane (CC0), read from ``spot.obj``, with bead eyes and painted patches."""

from math import cos, sin, tau
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector, noise
from mathutils.bvhtree import BVHTree

from .. import posing
from ..materials import patched_material, plain_material
from .objects import add_fields, add_groups, grid_faces, mesh_object
from .sculpt import ball, weld_lists

SOURCE = Path(__file__).with_name("spot.obj")
EYE_RADIUS = 0.055
HIDE, EYE = 0, 1  # material slots
PINK = (0.72, 0.34, 0.27)
PATCHES = (  # what is painted on the hide: field, colour, softness of its border
    ("blot", (0.085, 0.035, 0.018), 0.012),
    ("muzzle", PINK, 0.020),
    ("nostril", (0.16, 0.05, 0.045), 0.006),
    ("ear", PINK, 0.020),
    ("hoof", (0.05, 0.032, 0.025), 0.006),
    ("horn", (0.55, 0.42, 0.26), 0.010),
)
HARNESS = "harness"  # the property that tells how many vertices, the last of the mesh, are the harness
STUD, BAND = 0.036, 0.020  # radii
LEGS = [(x, y, 0.24) for x in (-0.02, -0.78) for y in (0.21, -0.21)]


def read() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3), z up, hooves on the floor, looking along +x; triangles (m, 3)."""
    lines = [line.split() for line in SOURCE.read_text(encoding="ascii").splitlines()]
    points = [[float(number) for number in words[1:]] for words in lines if words[:1] == ["v"]]
    faces = [[int(corner.split("/")[0]) - 1 for corner in words[1:]] for words in lines if words[:1] == ["f"]]
    x, y, z = np.array(points).T
    turned = np.stack((-z, -x, y), 1)
    turned[:, 2] -= turned[:, 2].min()
    return turned, np.array(faces)


def paint(points: np.ndarray) -> dict[str, np.ndarray]:
    """Colour fields (n,): positive where the colour is."""
    x, y, z = points.T
    blot = np.array([noise.noise(Vector(p) * 2.1 + Vector((3.7, 0.4, 1.9))) for p in points])
    muzzle = 0.26 - np.linalg.norm((points - (0.60, 0, 1.02)) * (1.0, 0.80, 1.25), axis=1)
    half = np.column_stack((x, np.abs(y), z))
    ear = 0.075 - np.linalg.norm((half - (0.235, 0.37, 1.40)) * (1.6, 0.8, 1.4), axis=1)
    nostril = 0.030 - np.linalg.norm((np.abs(points) - (0.655, 0.085, 1.06)) * (0.4, 1.0, 1.0), axis=1)
    return {
        "blot": np.minimum(blot - 0.06, 0.6 * np.maximum(z - 0.15, -0.1)),
        "muzzle": muzzle,
        "ear": ear,
        "nostril": nostril,
        "hoof": 0.125 - z,
        "horn": np.minimum(z - 1.545, np.abs(y) - 0.06),
    }


def build(name: str = "Spot") -> bpy.types.Object:
    points, faces = read()
    regions = {
        "Head": np.flatnonzero((points[:, 0] > 0.16) & (points[:, 2] > 1.02)),
        "Hoof": np.flatnonzero((points[:, 2] < 0.17) & (points[:, 0] > -0.2) & (points[:, 1] < 0)),
        "Hooves": np.flatnonzero((points[:, 2] < 0.14) & ((points[:, 0] < -0.2) | (points[:, 1] > 0))),
    }
    tree = BVHTree.FromPolygons(points.tolist(), faces.tolist())
    all_points, all_faces = [points], faces.tolist()
    for side in (1, -1):
        source, way = Vector((1.1, 0.49 * side, 1.37)), Vector((-0.75, -0.30 * side, -0.06))
        place, normal, _, _ = tree.ray_cast(source, way)
        globe, quads = ball(place - 0.45 * EYE_RADIUS * normal, EYE_RADIUS, 6)
        start = sum(len(part) for part in all_points)
        regions["Head"] = np.concatenate((regions["Head"], start + np.arange(len(globe))))
        all_points.append(globe)
        all_faces += (quads + start).tolist()
    fields = paint(points)
    points = np.vstack(all_points)

    hide = patched_material("Hide", (0.80, 0.74, 0.66), PATCHES, roughness=0.5)
    bead = plain_material("Bead", (0.005, 0.004, 0.004), roughness=0.06, specular=0.6)
    slots = [HIDE] * len(faces) + [EYE] * (len(all_faces) - len(faces))
    obj = mesh_object(name, points, all_faces, smooth=True, slots=slots, materials=[hide, bead])
    add_fields(obj.data, fields)
    add_groups(obj, regions)
    return obj


def build_harnessed(name: str = "Spot") -> bpy.types.Object:
    """Spot in a harness: studs, bands and a belt, joined with its mesh as parts of their own."""
    cow = build(name)
    tree = BVHTree.FromObject(cow, bpy.context.evaluated_depsgraph_get())
    shells = [stud(tree, (x, 0.0, 2.5), (0.0, 0.0, -1.0)) for x in np.linspace(-0.70, -0.05, 9)]
    for side in (1.0, -1.0):
        shells += [stud(tree, (x, side, 0.80), (0.0, -side, 0.0)) for x in np.linspace(-0.62, -0.14, 4)]
    shells += [band(tree, leg, (0.0, 0.0, 1.0), 0.19) for leg in LEGS]
    shells.append(band(tree, (-0.36, 0.0, 0.72), (1.0, 0.0, 0.0), 1.5))
    points, faces = weld_lists(shells)
    brass = plain_material("Brass", (0.62, 0.30, 0.05), roughness=0.25, specular=0.8)
    harness = mesh_object("Harness", points, faces, smooth=True, materials=[brass])
    posing.make_active(cow, harness)
    bpy.ops.object.join()
    cow[HARNESS] = len(points)
    return cow


def stud(tree: BVHTree, source: tuple, direction: tuple) -> tuple[np.ndarray, np.ndarray]:
    """Half a ball above the surface that a ray meets: points and quads."""
    place, normal, _face, _distance = tree.ray_cast(Vector(source), Vector(direction))
    return ball(place + 0.1 * STUD * normal, STUD, 4)


def band(tree: BVHTree, centre: tuple, axis: tuple, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """A tube around a limb, which rays from ``reach`` towards ``centre`` across the ``axis`` meet."""
    around, sides = 48, 8
    middle, along = Vector(centre), Vector(axis)
    first = along.orthogonal().normalized()
    second = along.cross(first)
    rings = []
    for angle in tau / around * np.arange(around):
        outward = cos(angle) * first + sin(angle) * second
        place, *_rest = tree.ray_cast(middle + reach * outward, -outward)
        turns = tau / sides * np.arange(sides)
        rings += [place + BAND * (cos(turn) * outward + sin(turn) * along) for turn in turns]
    inner = grid_faces(around + 1, sides, around=True)[:, [0, 3, 2, 1]] % len(rings)
    return np.array(rings), inner
