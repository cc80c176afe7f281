# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot in harness: studs, bands and a belt are parts of their own, which ride on the hide or stay behind."""

from __future__ import annotations

from math import cos, sin, tau

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import animals, materials, posing, spot, studio
from .models.sculpt import ball

POSE_FRAME = spot.POSE_FRAME
SPACING, HEADING = 2.30, -52.0
LABELS = ("Rest", "Loose Parts: Stay", "Loose Parts: Follow")
STUD, BAND = 0.036, 0.020  # radii
LEGS = [(x, y, 0.24) for x in (-0.02, -0.78) for y in (0.21, -0.21)]


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Loose parts")
    cow = animals.cow()
    harness = dress(cow)
    cows = posing.line_up(cow, LABELS, SPACING, HEADING)
    for other, choice in zip(cows[1:], ("STAY", "FOLLOW")):
        spot.pose(other)
        other.sinew.active.loose_parts = choice
    scene.frame_set(POSE_FRAME)
    follows = posing.shape(cows[2])[-harness:]
    if np.abs(follows - posing.shape(cows[1])[-harness:]).max() < 0.05:
        raise SystemExit("The harness does not follow")

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.05, 0.0, 0.88), distance=24.0, elevation=12.0, width=7.2)
    studio.add_lights(scene, target=(0.0, 0.0, 0.8), size=7.0)
    for obj, label in zip(cows, LABELS):
        studio.add_label(scene, label, (obj.location.x, -1.30, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1280, height=460)
    studio.open_at(scene, POSE_FRAME, cows[-1])
    return scene


def dress(cow: bpy.types.Object) -> int:
    """Join studs, bands and a belt with the mesh; returns how many vertices they have."""
    tree = BVHTree.FromObject(cow, bpy.context.evaluated_depsgraph_get())
    shells = [stud(tree, (x, 0.0, 2.5), (0.0, 0.0, -1.0)) for x in np.linspace(-0.70, -0.05, 9)]
    for side in (1.0, -1.0):
        shells += [stud(tree, (x, side, 0.80), (0.0, -side, 0.0)) for x in np.linspace(-0.62, -0.14, 4)]
    shells += [band(tree, leg, (0.0, 0.0, 1.0), 0.19) for leg in LEGS]
    shells.append(band(tree, (-0.36, 0.0, 0.72), (1.0, 0.0, 0.0), 1.5))
    points = np.concatenate([part for part, _faces in shells])
    starts = np.cumsum([0, *(len(part) for part, _faces in shells)])
    mesh = bpy.data.meshes.new("Harness")
    faces = [face for (_part, own), start in zip(shells, starts) for face in (own + start).tolist()]
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    brass = materials.plain_material("Brass", (0.62, 0.30, 0.05), roughness=0.25, specular=0.8)
    mesh.materials.append(brass)
    harness = bpy.data.objects.new("Harness", mesh)
    bpy.context.scene.collection.objects.link(harness)
    posing.make_active(cow)
    harness.select_set(True)
    bpy.ops.object.join()
    return len(points)


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
    turns = [tau * number / sides for number in range(sides)]
    for number in range(around):
        angle = tau * number / around
        outward = cos(angle) * first + sin(angle) * second
        place, *_rest = tree.ray_cast(middle + reach * outward, -outward)
        rings += [place + BAND * (cos(turn) * outward + sin(turn) * along) for turn in turns]
    k, j = np.meshgrid(np.arange(around), np.arange(sides), indexing="ij")
    k1, j1 = (k + 1) % around, (j + 1) % sides
    quads = np.stack((k * sides + j, k1 * sides + j, k1 * sides + j1, k * sides + j1), axis=-1)
    return np.array(rings), quads.reshape(-1, 4)
