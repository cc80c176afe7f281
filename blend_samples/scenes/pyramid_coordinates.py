# SPDX-License-Identifier: GPL-3.0-or-later
"""Half-way to a twisted Spot: pyramid coordinates keep the body whole, straight lines make it shrink."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians

import bpy
import numpy as np
from mathutils import Matrix

from .. import posing
from ..lineup import Lineup
from ..models import spot
from ..studio import Shot

MIDDLE_FRAME = 48
LAST_FRAME = 96
TWIST = 150.0  # degrees between the rump and the chest
BACK, FRONT = -0.75, 0.15  # between these places along the body
AXIS_HEIGHT = 0.95


def make() -> bpy.types.Scene:
    return Lineup(
        title="Pyramid Coordinates",
        build=spot.build,
        row=dict.fromkeys(("Rest", "Half, straight lines", "Half, Pyramid Coordinates", "Target shape")),
        spacing=2.35,
        heading=-52.0,
        frame=MIDDLE_FRAME,
        active=2,
        smooth=True,
        finish=twist,
        shot=Shot((0.05, 0.0, 0.88), 9.8, 12.0, 30.0, lit=0.8, picture=(1400, 420), samples=24, front=-1.30),
    ).make()


def twist(cows: Sequence[bpy.types.Object]) -> None:
    rest, straight, morphed, target = cows
    target.data = twisted(rest.data)
    straight.data = rest.data.copy()
    for vertex, other in zip(straight.data.vertices, target.data.vertices):
        vertex.co = 0.5 * (vertex.co + other.co)
    pose(morphed, target)


def twisted(mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """A copy whose front is turned about the body's axis."""
    found = mesh.copy()
    for vertex in found.vertices:
        s = min(max((vertex.co.x - BACK) / (FRONT - BACK), 0.0), 1.0)
        angle = radians(TWIST) * s * s * (3.0 - 2.0 * s)
        place = Matrix.Translation((0.0, 0.0, AXIS_HEIGHT))
        vertex.co = place @ Matrix.Rotation(angle, 4, "X") @ place.inverted() @ vertex.co
    return found


def pose(cow: bpy.types.Object, target: bpy.types.Object) -> None:
    """Morph by the operator, and key it: there and back."""
    posing.make_active(cow)
    posing.expect(bpy.ops.sinew.morph(target=target.name), "Morph to a Mesh")
    settings = cow.sinew.active.pyramid_coordinates
    for frame, value in ((1, 0.0), (MIDDLE_FRAME, 0.5), (LAST_FRAME, 1.0)):
        settings.morph = value
        settings.keyframe_insert("morph", frame=frame)
    scene = bpy.context.scene
    for frame, mesh in ((1, cow.data), (LAST_FRAME, target.data)):
        scene.frame_set(frame)
        wanted = np.array([vertex.co for vertex in mesh.vertices])
        if np.abs(posing.shape(cow) - wanted).max() > 1e-4:
            raise posing.SampleError(
                f"frame {frame} is not the shape at that end: {posing.deformer_line(cow)}"
            )
    scene.frame_set(MIDDLE_FRAME)
