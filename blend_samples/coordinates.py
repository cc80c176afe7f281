# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot in an automatic cage: one pose of the cage, followed by each of the four kinds of coordinates."""

from __future__ import annotations

import bpy
import numpy as np

from . import animals, markers, posing, studio
from .models.shapes import smoothstep
from .posing import Move

POSE_FRAME = 40
SPACING, HEADING = 1.72, -38.0
LABELS = {
    "mean_value": "Mean Value",
    "positive_mean_value": "Positive Mean Value",
    "harmonic": "Harmonic",
    "green": "Green",
}
NOD = Move(shift=(0.02, 0.0, 0.05), turn=(24.0, -16.0, -20.0), pivot=(0.05, 0.0, 0.95))
STEP = Move(shift=(0.3, -0.16, 0.12), turn=(0.0, -70.0, 0.0), pivot=(0.14, -0.2, 0.58))
NOD_VALUES = {1: 0.0, POSE_FRAME: 1.0, 56: 0.35, 72: 1.0, 96: 0.0}
STEP_VALUES = {1: 0.0, POSE_FRAME: 1.0, 48: 0.7, 56: 1.0, 64: 0.7, 72: 1.0, 96: 0.0}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Coordinates")
    cows = posing.line_up(animals.cow(), LABELS.values(), SPACING, HEADING)

    cages = [posing.add_cage(cows[0], "mean_value", faces=240)]
    for method, cow in list(zip(LABELS, cows))[1:]:
        cages.append(posing.share_cage(cages[0], cow, method))
    pose(cages[0])
    for cow, cage in zip(cows, cages):
        markers.add_cage_edges(cage, 0.006)
        posing.check_posed(cow, 1, POSE_FRAME)
        smooth = cow.modifiers.new("Subdivision", "SUBSURF")
        smooth.levels, smooth.render_levels = 1, 2

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.12, 0.0, 0.84), distance=24.0, elevation=9.0, width=7.15)
    studio.add_lights(scene, target=(0.0, 0.0, 0.8), size=9.0)
    for cow, label in zip(cows, LABELS.values()):
        middle = (
            0.95 * cow.location.x - 0.17
        )  # of the cow as the camera sees it, to which the label is nearer
        studio.add_label(scene, label, (middle, -1.25, 0.0), 0.15)
    studio.set_up_render(scene, samples=64, height=480)
    studio.open_at(scene, POSE_FRAME, cows[0])
    return scene


def pose(cage: bpy.types.Object) -> None:
    """Two shape keys of the cage: the head nods aside, the right foreleg steps up."""
    points = posing.vertices(cage)
    x, y, z = points.T
    head = smoothstep(0.92, 1.22, z + 0.5 * x)
    leg = smoothstep(0.66, 0.40, z) * smoothstep(-0.22, -0.14, x) * smoothstep(0.04, -0.04, y)
    posing.add_pose(cage, "Nod", posing.blended(NOD, points, head), NOD_VALUES)
    posing.add_pose(cage, "Step", posing.blended(STEP, points, leg), STEP_VALUES)
    if not (np.any(head > 0.9) and np.any(leg > 0.9)):
        raise posing.SampleError("The cage has no vertices at the head or at the leg")
