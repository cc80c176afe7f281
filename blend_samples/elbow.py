# SPDX-License-Identifier: GPL-3.0-or-later
"""An elbow that bones bend: a correction, pulled out at one frame, rides on the arm in every other."""

from __future__ import annotations

from math import radians

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import markers, materials, posing, studio
from .models import yeti

SHOWN = (1, 10, 20)
MADE = SHOWN[-1]
BENT = 118.0  # degrees
SPACING = 1.7
PULL = 0.16


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Elbow")
    scene.frame_start, scene.frame_end = SHOWN[0], MADE
    body, bones = yeti.build()
    body.data.materials.append(
        materials.skin_material("Skin", roughness=0.5, bump=0.2, grain=70.0, band="band")
    )
    body.data.materials.append(materials.eye_material("Eye", yeti.IRIS, yeti.PUPIL, yeti.IRIS_EDGE))
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

    studio.add_camera(scene, target=(0.0, 0.0, 1.5), distance=26.0, elevation=10.0, width=5.2)
    for k, frame in enumerate(SHOWN):
        x = (k - 1) * SPACING
        _show(body, frame, None, x, 1.15, f"Frame {frame}")
        _show(body, frame, handle.control, x, 0.0, "with the correction")
    body.hide_render = bones.hide_render = True
    studio.add_backdrop(scene, behind=14.0)
    studio.add_lights(scene, target=(0.0, 0.0, 1.5), size=8.0)
    studio.set_up_render(scene, samples=64, width=1400, height=760)
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


def _show(
    body: bpy.types.Object, frame: int, control: bpy.types.Object | None, x: float, z: float, label: str
) -> None:
    """Leave a copy of the arm of a frame, with the control on it or without the correction."""
    body.modifiers[-1].show_viewport = control is not None
    bpy.context.scene.frame_set(frame)
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    rest = posing.vertices(body)
    _keep_arm(mesh, (rest[:, 1] > 0.5) & (rest[:, 2] > 0.95))
    shift = Matrix.Translation((x - 1.1, 0.0, z - 0.5))
    shown = bpy.data.objects.new(f"Frame {frame} {label}", mesh)
    shown.color[3] = 0.0
    shown.matrix_world = shift @ body.matrix_world
    bpy.context.scene.collection.objects.link(shown)
    if control is not None:
        place = shift @ control.matrix_world.translation
        ball = bpy.data.objects.new(f"Control {frame}", None)
        ball.location = place
        bpy.context.scene.collection.objects.link(ball)
        markers.add_pin(ball, place + Vector((0.0, -0.3, 0.0)), 0.05, place)
    body.modifiers[-1].show_viewport = True
    if control is None:
        studio.add_label(bpy.context.scene, label, (x - 0.3, -0.4, 0.18), 0.13)


def _keep_arm(mesh: bpy.types.Mesh, inside: np.ndarray) -> None:
    edit = bmesh.new()
    edit.from_mesh(mesh)
    edit.verts.ensure_lookup_table()
    lost = [edit.verts[index] for index in np.flatnonzero(~inside)]
    bmesh.ops.delete(edit, geom=lost, context="VERTS")
    edit.to_mesh(mesh)
    edit.free()
