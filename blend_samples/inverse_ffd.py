# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot dragged at the head and the back; finer hidden lattices let a drag reach less far."""

from __future__ import annotations

import bpy
from mathutils import Vector

from . import animals, markers, posing, studio
from .posing import REST, Move

POSE_FRAME = 40
SPACING, HEADING = 1.72, -38.0
SETTINGS = (("Rest", 0), ("4 x 4 x 4 points", 4), ("7 x 7 x 7 points", 7), ("12 x 12 x 12 points", 12))
# Where one looks along the cow's own axes, from a place outside, and how far the surface is dragged there.
DRAGS = (
    ((-3.0, 0.0, 1.02), (1.0, 0.0, 0.0), (-0.22, 0.0, 0.22)),
    ((0.25, 0.0, 3.0), (0.0, 0.0, -1.0), (0.0, 0.0, 0.28)),
    ((-0.2, 0.0, -3.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
)


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Inverse Free-Form Deformation")
    cows = posing.line_up(animals.cow(), (label for label, _ in SETTINGS), SPACING, HEADING)
    for cow, (_, resolution) in zip(cows, SETTINGS):
        if resolution:
            drag(cow, resolution)
        smooth = cow.modifiers.new("Subdivision", "SUBSURF")
        smooth.levels, smooth.render_levels = 1, 2

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.12, 0.0, 0.84), distance=24.0, elevation=9.0, width=7.15)
    studio.add_lights(scene, target=(0.0, 0.0, 0.8), size=9.0)
    for cow, (label, _) in zip(cows, SETTINGS):
        studio.add_label(scene, label, (0.95 * cow.location.x - 0.17, -1.25, 0.0), 0.15)
    studio.set_up_render(scene, samples=64, height=480)
    studio.open_at(scene, POSE_FRAME, cows[1])
    return scene


def drag(cow: bpy.types.Object, resolution: int) -> None:
    """Press on the surface in three places, and animate the handles that this makes."""
    deformer = posing.add_deformer(cow, "inverse_ffd", resolution=resolution)
    for origin, direction, shift in DRAGS:
        posing.make_active(cow)
        world = cow.matrix_world
        sight = {"origin": world @ Vector(origin), "direction": world.to_3x3() @ Vector(direction)}
        posing.expect(bpy.ops.sinew.drag(**sight, radius=0.06), f"{cow.name}: drag")
        handle = deformer.handles[-1]
        markers.add_pin(handle.control, handle.control.matrix_world.translation, 0.03)
        posing.animate(
            handle.control, {1: REST, POSE_FRAME: Move(shift=shift), 70: Move(shift=shift), 96: REST}, cow
        )
    posing.check_posed(cow, 1, POSE_FRAME)
