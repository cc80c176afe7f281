# SPDX-License-Identifier: GPL-3.0-or-later
"""One hose, bent by the nonlinear thin shell: a thin wall kinks, a thick one keeps its round."""

from __future__ import annotations

from math import cos, pi, sin

import bpy
import numpy as np
from mathutils import Vector

from . import markers, materials, posing, studio
from .models.objects import Sculpture, to_object
from .posing import REST, Move

POSE_FRAME = 40
SPACING = 2.3
HEIGHT, RADIUS, RINGS, AROUND = 2.4, 0.26, 96, 48
HELD = 0.3
PLAIN = (0.55, 0.40, 0.22)
THICKNESSES = {"Rest": 0.0, "Thickness 0.5 %": 0.005, "2 %": 0.02, "8 %": 0.08}
# The axis becomes an arc of 120 degrees.
FREE = HEIGHT - 2 * HELD
ANGLE = 2 * pi / 3
BEND = Move(
    shift=(FREE / ANGLE * (1 - cos(ANGLE)), 0.0, FREE / ANGLE * sin(ANGLE) - FREE),
    turn=(0.0, 120.0, 0.0),
    pivot=(0.0, 0.0, HEIGHT - HELD),
)
MOVES = {1: REST, POSE_FRAME: BEND, 52: BEND, 96: REST}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Sheets")
    first = hose()
    patches = (("handle", materials.HANDLE_COLOUR, 0.002), ("fixed", materials.FIXED_COLOUR, 0.002))
    first.data.materials.append(materials.patched_material("Hose", PLAIN, patches, roughness=0.5))
    hoses = posing.line_up(first, THICKNESSES, SPACING)
    for obj, thickness in zip(hoses, THICKNESSES.values()):
        if thickness:
            pose(obj, thickness)
    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.5, 0.0, 1.0), distance=28.0, elevation=10.0, width=10.0)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for obj, label in zip(hoses, THICKNESSES):
        studio.add_label(scene, label, (obj.location.x + 0.2, -1.0, 0.0), 0.2)
    studio.set_up_render(scene, samples=32, width=1600, height=480)
    studio.open_at(scene, POSE_FRAME, hoses[-1])
    return scene


def hose() -> bpy.types.Object:
    """A tube open at both ends, with its ends as vertex groups."""
    z, a = np.meshgrid(np.linspace(0, HEIGHT, RINGS + 1), 2 * pi / AROUND * np.arange(AROUND), indexing="ij")
    points = np.stack((RADIUS * np.cos(a), RADIUS * np.sin(a), z), -1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(z.shape)
    beside = np.roll(number, -1, 1)
    quads = np.stack((number[:-1], beside[:-1], beside[1:], number[1:]), -1).reshape(-1, 4)
    fields = {"handle": points[:, 2] - HEIGHT + HELD, "fixed": HELD - points[:, 2]}
    regions = {
        "Head": np.flatnonzero(points[:, 2] >= HEIGHT - HELD),
        "Foot": np.flatnonzero(points[:, 2] <= HELD),
    }
    plain = np.tile(PLAIN, (len(points), 1))
    return to_object("Hose", Sculpture(points, quads, plain, np.zeros(len(quads)), fields, regions))


def pose(obj: bpy.types.Object, thickness: float) -> None:
    posing.add_deformer(obj, "thin_shell_nonlinear", thickness=thickness)
    head = posing.add_region(obj, "HANDLE", "Head")
    posing.add_region(obj, "FIXED", "Foot")
    place = obj.matrix_world
    top = Vector((0, 0, HEIGHT + 0.25))
    markers.add_pin(head.control, place @ top, 0.06, place @ Vector((0, 0, HEIGHT)))
    posing.animate(head.control, MOVES, obj)
    posing.check_posed(obj, 1, POSE_FRAME)
