# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen of lattice objects that are moved, and of what they move."""

import bpy
import numpy as np

from rigs.rig import coordinates, evaluated_points, new_object

FLOAT32 = 1e-6  # roundings of coordinates near 1
UP = np.array((0.0, 0.0, 1.0))


def points_of(obj: bpy.types.Object) -> np.ndarray:
    """The points without keys and modifiers."""
    return coordinates(obj.data.points, "co_deform")


def key_of(obj: bpy.types.Object, index: int = 0) -> bpy.types.ShapeKey:
    return obj.data.shape_keys.key_blocks[obj.sinew.deformers[index].shape_key]


def held(block: bpy.types.ShapeKey) -> np.ndarray:
    return coordinates(block.data)


def follower(obj: bpy.types.Object, name: str = "Follower") -> bpy.types.Object:
    """A mesh that follows the lattice by Blender's own modifier."""
    points = np.random.default_rng(4).uniform(-0.4, 0.4, (20, 3))
    mesh = new_object(name, points, [])
    mesh.modifiers.new("Lattice", "LATTICE").object = obj
    return mesh


def moved_up(obj: bpy.types.Object) -> bool:
    return bool(np.abs(evaluated_points(obj) - points_of(obj) - UP).max() < FLOAT32)
