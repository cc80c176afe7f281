# SPDX-License-Identifier: GPL-3.0-or-later
"""An elbow that bones bend: a correction, pulled out at one frame, rides on the arm in every other."""

from __future__ import annotations

from math import radians

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .. import markers, posing, studio
from ..models import yeti
from ..models.objects import keep_vertices
from ..studio import Shot

SHOWN = (1, 10, 20)
MADE = SHOWN[-1]
BENT = 118.0  # degrees
SPACING = 1.7
PULL = 0.16
SHOT = Shot(
    (0.0, 0.0, 1.5),
    width=5.2,
    distance=26.0,
    lit=1.5,
    light=8.0,
    picture=(1400, 760),
    text=0.13,
    front=-0.4,
    aside=-0.3,
    floor=0.18,
)


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Elbow")
    scene.frame_start, scene.frame_end = SHOWN[0], MADE
    body, bones = yeti.build()
    body.color[3] = 0.0
    bones.rotation_euler.z = radians(-90.0)
    joint = bones.pose.bones["forearm.L"]
    joint.rotation_mode = "XYZ"
    for frame, angle in ((SHOWN[0], 0.0), (MADE, BENT)):
        joint.rotation_euler.z = radians(angle)
        joint.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(MADE)
    handle = _correct(body)
    posing.check_posed(body, SHOWN[0], MADE)

    labels = []
    for frame, x in zip(SHOWN, posing.places(len(SHOWN), SPACING)):
        _show(body, frame, None, x, 1.15)
        _show(body, frame, handle.control, x, 0.0)
        labels.append((f"Frame {frame}", x))
    body.hide_render = bones.hide_render = True
    SHOT.set_up(scene, labels)
    studio.open_at(scene, MADE, body)
    return scene


def _correct(body: bpy.types.Object) -> bpy.types.PropertyGroup:
    """Press on the outside of the bent elbow, and pull."""
    shown = posing.shape(body)
    rest = posing.vertices(body)
    at = int(np.argmin(np.linalg.norm(rest - (0.0, yeti.ELBOW, yeti.ARM_HEIGHT - 0.2), axis=1)))
    place = np.array(body.matrix_world @ Vector(shown[at]))
    out = np.array(body.matrix_world.to_3x3() @ Vector(_normal(body, at)))
    posing.make_active(body)
    pressed = bpy.ops.sinew.drag(
        origin=place + 0.05 * out, direction=-out, value=PULL * out, radius=0.1, reach=3.5, method="arap"
    )
    posing.expect(pressed, "drag")
    return body.sinew.deformers[-1].handles[body.sinew.deformers[-1].active_handle]


def _normal(body: bpy.types.Object, vertex: int) -> Vector:
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return evaluated.data.vertices[vertex].normal.copy()


def _show(body: bpy.types.Object, frame: int, control: bpy.types.Object | None, x: float, z: float) -> None:
    """Leave a copy of the arm of a frame, with the control on it or without the correction."""
    body.modifiers[-1].show_viewport = control is not None
    bpy.context.scene.frame_set(frame)
    mesh = posing.shown_mesh(body)
    rest = posing.vertices(body)
    keep_vertices(mesh, (rest[:, 1] > 0.5) & (rest[:, 2] > 0.95))
    shift = Matrix.Translation((x - 1.1, 0.0, z - 0.5))
    name = "without" if control is None else "with"
    shown = posing.add_object(f"Frame {frame} {name} the correction", mesh)
    shown.color[3] = 0.0
    shown.matrix_world = shift @ body.matrix_world
    if control is not None:
        place = shift @ control.matrix_world.translation
        ball = posing.add_object(f"Control {frame}", None)
        ball.location = place
        markers.add_pin(ball, place + Vector((0.0, -0.3, 0.0)), 0.05, place)
    body.modifiers[-1].show_viewport = True
