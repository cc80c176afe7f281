# SPDX-License-Identifier: GPL-3.0-or-later
"""A ship of meshes, curves, text, hair and Blender's own lattice, all moved by one lattice or one twist."""

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
    scene = empty_scene()
    places = posing.places(len(LABELS), SPACING)
    ships = [build(label, x) for label, x in zip(LABELS, places)]
    pose_by_lattice(ships[1])
    pose_by_twist(ships[2])
    for obj in (*ships[1], *ships[2]):
        posing.check_posed(obj)
    SHOT.set_up(scene, zip(LABELS, places))
    open_at(scene, POSE_FRAME, ships[1][0])
    return scene


def build(name: str, x: float) -> list[bpy.types.Object]:
    ship = longship.build(name)
    bpy.context.view_layer.update()
    stand = Matrix.Translation((x, 0.0, 0.0)) @ Matrix.Rotation(np.radians(HEADING), 4, "Z")
    for obj in ship:
        obj.matrix_world = stand @ obj.matrix_world
    return ship


def pose_by_lattice(ship: list[bpy.types.Object]) -> None:
    """The ship rears: it bends along its length, and all above leans back."""
    lattice = posing.add_lattice(ship[0], (5, 3, 4), *ship[1:])
    x, y, z = posing.lattice_points(lattice).T
    height = z + 0.5
    moved = (x * (1.0 - 0.25 * height) - 0.30 * height**2, y, z + 0.30 * (x + 0.2) ** 2 - 0.04)
    posing.add_pose(lattice, "Rear", np.column_stack(moved), {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 96: 0.0})


def pose_by_twist(ship: list[bpy.types.Object]) -> None:
    """One tool on the mast: the higher, the farther it turns."""
    bpy.context.view_layer.update()
    middle = ship[0].matrix_world.translation.copy()
    middle.z = 1.0
    control = ""
    for obj in ship:
        row = posing.operate(obj, "tool_add", tool="twist", location=middle, control=control).controls[-1]
        row.inner, row.outer, row.width = -1.2, 0.9, 3.0
        control = row.object.name
    turn = Move(turn=(0.0, 0.0, 100.0), pivot=(0.0, 0.0, 1.0))
    posing.animate(row.object, there_and_back((POSE_FRAME, turn)), ship[0])
