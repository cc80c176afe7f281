# SPDX-License-Identifier: GPL-3.0-or-later
"""A ship of meshes, curves, text, hair and Blender's own lattice, all moved by one lattice or one twist."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from . import posing, studio
from .models import longship
from .posing import REST, Move

POSE_FRAME = 40
SPACING, HEADING = 2.8, -28.0
LABELS = ("Rest", "One Lattice", "One Twist")


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Longship")
    ships = [build(label, k - 1.0) for k, label in enumerate(LABELS)]
    pose_by_lattice(ships[1])
    pose_by_twist(ships[2])
    for ship in ships[1:]:
        for obj in ship:
            posing.check_posed(obj, 1, POSE_FRAME)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.0, 0.0, 0.98), distance=26.0, elevation=9.0, width=8.2)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=9.0)
    for k, label in enumerate(LABELS):
        studio.add_label(scene, label, ((k - 1.0) * SPACING, -1.6, 0.0), 0.17)
    studio.set_up_render(scene, samples=64, width=1680, height=560)
    studio.open_at(scene, POSE_FRAME, ships[1][0])
    return scene


def build(name: str, place: float) -> list[bpy.types.Object]:
    """A ship in its row."""
    ship = longship.build(name)
    bpy.context.view_layer.update()
    stand = Matrix.Translation((place * SPACING, 0.0, 0.0)) @ Matrix.Rotation(np.radians(HEADING), 4, "Z")
    for obj in ship:
        obj.matrix_world = stand @ obj.matrix_world
    return ship


def pose_by_lattice(ship: list[bpy.types.Object]) -> None:
    """The ship rears: it bends along its length, and all above leans back."""
    posing.make_active(ship[0])
    for obj in ship:
        obj.select_set(True)
    posing.expect(bpy.ops.sinew.lattice_add(resolution=(5, 3, 4)), "lattice_add()")
    lattice = ship[0].sinew.deformers[-1].controls[0].object
    points = posing.lattice_points(lattice)
    x, _y, z = points.T
    height = z + 0.5
    moved = points.copy()
    moved[:, 0] = x * (1.0 - 0.25 * height) - 0.30 * height**2
    moved[:, 2] = z + 0.30 * (x + 0.2) ** 2 - 0.04
    posing.add_pose(lattice, "Rear", moved, {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 96: 0.0})


def pose_by_twist(ship: list[bpy.types.Object]) -> None:
    """One tool on the mast: the higher, the farther it turns."""
    posing.make_active(ship[0])
    middle = ship[0].matrix_world.translation.copy()
    middle.z = 1.0
    control = ""
    for obj in ship:
        posing.make_active(obj)
        answer = bpy.ops.sinew.tool_add(tool="twist", location=middle, outer=0.8, control=control)
        posing.expect(answer, f"{obj.name}: tool_add()")
        row = obj.sinew.active.controls[-1]
        row.inner, row.outer, row.width = -1.2, 0.9, 3.0
        control = row.object.name
    turn = Move(turn=(0.0, 0.0, 100.0), pivot=(0.0, 0.0, 1.0))
    posing.animate(row.object, {1: REST, POSE_FRAME: turn, 96: REST}, ship[0])
