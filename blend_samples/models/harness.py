# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot in a harness: studs, bands and a belt, joined with its mesh as parts of their own."""

from math import cos, sin, tau

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from .. import posing
from ..materials import plain_material
from . import spot
from .objects import grid_faces, mesh_object
from .sculpt import ball, weld_lists

COUNT = "harness"  # the property that tells how many vertices, the last of the mesh, are the harness
STUD, BAND = 0.036, 0.020  # radii
LEGS = [(x, y, 0.24) for x in (-0.02, -0.78) for y in (0.21, -0.21)]


def build(name: str = "Spot") -> bpy.types.Object:
    cow = spot.build(name)
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
    cow[COUNT] = len(points)
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
