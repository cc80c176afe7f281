# SPDX-License-Identifier: GPL-3.0-or-later
"""A ship of meshes, curves, text, hair and Blender's own lattice, all moved by one lattice or one twist."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from .. import posing
from ..lineup import POSE_FRAME, there_and_back
from ..models import longship
from ..posing import Move
from ..studio import Shot, empty_scene, open_at

SPACING, HEADING = 2.8, -28.0
SHOT = Shot((0.0, 0.0, 0.98), 8.2, 9.0, 26.0, picture=(1680, 560), front=-1.6)
LABELS = ("Rest", "One Lattice", "One Twist")


def make() -> bpy.types.Scene:
    scene = empty_scene("Longship")
    places = posing.places(len(LABELS), SPACING)
    ships = [build(label, x) for label, x in zip(LABELS, places)]
    pose_by_lattice(ships[1])
    pose_by_twist(ships[2])
    for obj in (*ships[1], *ships[2]):
        posing.check_posed(obj, 1, POSE_FRAME)
    SHOT.set_up(scene, zip(LABELS, places))
    open_at(scene, POSE_FRAME, ships[1][0])
    return scene


def build(name: str, x: float) -> list[bpy.types.Object]:
    """A ship in its row."""
    ship = longship.build(name)
    bpy.context.view_layer.update()
    stand = Matrix.Translation((x, 0.0, 0.0)) @ Matrix.Rotation(np.radians(HEADING), 4, "Z")
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
    posing.animate(row.object, there_and_back((POSE_FRAME, turn)), ship[0])
