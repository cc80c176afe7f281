# SPDX-License-Identifier: GPL-3.0-or-later
"""One oval ridge by lattices of rising resolution: the rows of a lattice show as steps in the surface."""

from __future__ import annotations

import bpy
import numpy as np

from . import markers, materials, posing, studio
from .models import plate

POSE_FRAME = 40
SPACING = 2.45
SETTINGS = (
    ("8 x 8 points", 8, {"degree": 3}),
    ("16 x 16 points, degree 1", 16, {"degree": 1}),
    ("32 x 32 points, degree 3", 32, {"degree": 3}),
)
HEIGHT = 0.4
VALUES = {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 80: -0.4, 96: 0.0}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Free-Form Deformation")
    first = plate.build()
    surface = materials.patched_material("Plate", plate.PLAIN, (), roughness=0.5)
    materials.rule_lines(surface, cell=0.1, line=0.014)
    first.data.materials.append(surface)
    first.location.z = 0.05
    plates = posing.line_up(first, (label for label, *_ in SETTINGS), SPACING)
    for obj, (_, count, settings) in zip(plates, SETTINGS):
        pose(obj, count, settings)

    studio.add_backdrop(scene, behind=14.0, tint=(0.30, 0.27, 0.235))
    studio.add_camera(scene, target=(0.0, 0.0, 0.31), distance=24.0, elevation=24.0, width=7.5)
    studio.add_lights(scene, target=(0.0, 0.0, 0.3), size=11.0)
    for obj, (label, *_) in zip(plates, SETTINGS):
        studio.add_label(scene, label, (obj.location.x, -1.55, 0.0), 0.165)
    studio.set_up_render(scene, samples=32, height=450)
    studio.open_at(scene, POSE_FRAME, plates[1])
    return scene


def pose(obj: bpy.types.Object, count: int, settings: dict[str, int]) -> None:
    """The lattice points in an oval that lies across the grid rise together, as an artist selects them."""
    lattice = posing.add_lattice(obj, (count, count, 2), **settings)
    points = posing.lattice_points(lattice)
    x, y = (points[:, :2] / (0.5 * (count - 1))).T  # from -1 to 1
    along, across = 0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x
    inside = (along / 0.86) ** 2 + (across / 0.36) ** 2 < 1.0
    height = HEIGHT / lattice.matrix_world.to_scale().z
    raised = points + np.outer(inside, (0.0, 0.0, height))
    posing.add_pose(lattice, "Ridge", raised, VALUES)
    markers.add_lattice_points(lattice, 0.03 if count < 20 else 0.014, POSE_FRAME)
    thick = obj.modifiers.new("Thickness", "SOLIDIFY")  # below ours: it sees the posed plate
    thick.thickness, thick.offset = 0.035, -1.0
    posing.check_posed(obj, 1, POSE_FRAME)
