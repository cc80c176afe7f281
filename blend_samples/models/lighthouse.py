# SPDX-License-Identifier: GPL-3.0-or-later
"""A lighthouse of few faces from a lathe: a Subdivision makes it smooth, creases keep its rims sharp."""

from math import pi

import bpy
import numpy as np

from ..materials import plain_material
from .objects import mesh_object

SEGMENTS = 16
WALL, STRIPE, STONE, GLASS, DARK = range(5)  # material slots
HEIGHT = 2.3

# from the ground up: radius, height, how sharp the rim is, material of the ring of faces above
PROFILE = (
    (0.52, 0.00, 1.0, STONE),
    (0.52, 0.10, 0.9, STONE),
    (0.42, 0.12, 0.9, WALL),
    (0.395, 0.34, 0.0, WALL),
    (0.375, 0.50, 0.0, STRIPE),
    (0.355, 0.66, 0.0, STRIPE),
    (0.335, 0.82, 0.0, WALL),
    (0.315, 0.98, 0.0, WALL),
    (0.298, 1.14, 0.0, STRIPE),
    (0.283, 1.30, 0.0, STRIPE),
    (0.270, 1.46, 0.0, WALL),
    (0.262, 1.58, 0.9, STONE),
    (0.385, 1.62, 0.9, STONE),
    (0.385, 1.69, 0.9, STONE),
    (0.215, 1.70, 0.9, GLASS),
    (0.215, 1.98, 0.9, STRIPE),
    (0.300, 1.99, 0.9, STRIPE),
    (0.200, 2.12, 0.0, STRIPE),
    (0.075, 2.20, 0.6, STONE),
    (0.060, 2.26, 0.0, STONE),
)
WINDOWS = ((4, 11), (7, 12), (9, 11))  # ring of faces, segment
DOOR = (2, 13)


def build(name: str = "Lighthouse") -> bpy.types.Object:
    angle = 2 * pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.stack((np.cos(angle), np.sin(angle)), 1)
    rows = [np.column_stack((radius * ring, np.full(SEGMENTS, z))) for radius, z, *_ in PROFILE]
    points = np.vstack((*rows, [(0, 0, 0), (0, 0, HEIGHT)]))
    bottom, top = len(points) - 2, len(points) - 1
    faces, slots, sharp = [], [], {}
    for k, (_, _, sharpness, slot) in enumerate(PROFILE):
        for s in range(SEGMENTS):
            here, beside = k * SEGMENTS + s, k * SEGMENTS + (s + 1) % SEGMENTS
            sharp[min(here, beside), max(here, beside)] = sharpness
            last = k + 1 == len(PROFILE)
            faces.append((here, beside, top) if last else (here, beside, beside + SEGMENTS, here + SEGMENTS))
            opening = (k, s) in WINDOWS or (k, s) == DOOR
            slots.append(DARK if opening else slot)
    faces += [((s + 1) % SEGMENTS, s, bottom) for s in range(SEGMENTS)]
    slots += [STONE] * SEGMENTS

    surfaces = [
        plain_material("Wall", (0.80, 0.77, 0.71), roughness=0.6),
        plain_material("Stripe", (0.42, 0.035, 0.025), roughness=0.5),
        plain_material("Stone", (0.27, 0.25, 0.23), roughness=0.7),
        plain_material("Glass", (0.85, 0.62, 0.20), roughness=0.1, specular=0.6),
        plain_material("Opening", (0.02, 0.022, 0.03), roughness=0.3),
    ]
    obj = mesh_object(name, points, faces, smooth=True, slots=slots, materials=surfaces)
    for edge in obj.data.edges:
        edge.crease = sharp.get(tuple(sorted(edge.vertices)), 0.0)
    return obj
