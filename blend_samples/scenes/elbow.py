# SPDX-License-Identifier: GPL-3.0-or-later
"""An elbow that bones bend: a correction, pulled out at one frame, rides on the arm in every other."""

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
PULL = 0.16
SHOT = Shot((0, 0, 1.5), 5.2, 10, 26, 1.5, 8, (1400, 760), text=0.13, front=-0.4, aside=-0.3, floor=0.18)


def make() -> bpy.types.Scene:
    scene = studio.empty_scene()
    scene.frame_start, scene.frame_end = SHOWN[0], MADE
    body, bones = yeti.build()
    body.color[3] = 0.0
    bones.rotation_euler.z = radians(-90.0)
    posing.key_angles(bones.pose.bones["forearm.L"], {SHOWN[0]: (0, 0, 0), MADE: (0, 0, BENT)})
    scene.frame_set(MADE)
    handle = _correct(body)
    posing.check_posed(body, SHOWN[0], MADE)

    places = posing.places(len(SHOWN), 1.7)
    for frame, x in zip(SHOWN, places):
        _show(body, frame, None, x, 1.15)
        _show(body, frame, handle.control, x, 0.0)
    body.hide_render = bones.hide_render = True
    SHOT.set_up(scene, [(f"Frame {frame}", x) for frame, x in zip(SHOWN, places)])
    studio.open_at(scene, MADE, body)
    return scene


def _correct(body: bpy.types.Object) -> bpy.types.PropertyGroup:
    """Press on the outside of the bent elbow, and pull."""
    outside = (0.0, yeti.ELBOW, yeti.ARM_HEIGHT - 0.2)
    at = int(np.argmin(np.linalg.norm(posing.vertices(body) - outside, axis=1)))
    bent = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices[at]
    place, out = body.matrix_world @ bent.co, body.matrix_world.to_3x3() @ bent.normal
    sight = {"origin": place + 0.05 * out, "direction": -out, "value": PULL * out}
    deformer = posing.operate(body, "drag", **sight, radius=0.1, reach=3.5, method="arap")
    return deformer.handles[deformer.active_handle]


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
