# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: an animator drags a hand and the hip of a mannequin in Pose Mode."""

import sys

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    MODELS,
    Place,
    apart,
    enable,
    in_view,
    move,
    play,
    press,
    region,
    rest,
    screenshot,
    seen,
    shown_points,
    until,
    viewport,
)

sys.path.insert(0, str(MODELS.parents[1]))

FRONT = (0.7071068, 0.7071068, 0.0, 0.0)
HAND, HIP = "hand.L", "hip"
REACH, CROUCH = (-0.3, 0.0, 0.4), (0.0, 0.0, -0.3)  # in the world


def figure() -> bpy.types.Object:
    return bpy.data.objects["Mannequin Rig"]


def skin() -> bpy.types.Object:
    return bpy.data.objects["Mannequin Skin"]


def tail(name: str) -> np.ndarray:
    return np.array(figure().matrix_world @ figure().pose.bones[name].tail)


def feet() -> np.ndarray:
    return np.array([tail("foot.L"), tail("foot.R")])


def lengths() -> np.ndarray:
    return np.array([(bone.tail - bone.head).length for bone in figure().pose.bones])


def keyed_bones() -> list[str]:
    data = figure().animation_data
    if data is None or data.action is None:
        return []
    paths = {curve.data_path for curve in data.action.fcurves}
    return sorted({path.split('"')[1] for path in paths})


def on_screen(place: np.ndarray) -> Place:
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, place)
    return int(region().x + pixel.x), int(region().y + pixel.y)


def prepare():
    """A mannequin from the front, in Pose Mode."""
    enable()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    from blend_samples.models import mannequin

    mannequin.build("Mannequin")
    bpy.context.view_layer.objects.active = skin()
    bpy.ops.sinew.puppet_rig(armature=figure().name)
    yield from until(lambda: skin().sinew.active.is_bound)
    figure().show_in_front = True
    bpy.context.view_layer.objects.active = figure()
    bpy.ops.object.mode_set(mode="POSE")
    view = viewport().spaces.active.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = (0.0, 0.0, 0.95), 4.2
    bpy.ops.ed.undo_push(message="Mannequin")
    yield from rest(3)


def select(*names: str) -> None:
    bones = figure().data.bones
    for bone in bones:
        bone.select = bone.name in names
    bones.active = bones[names[-1]]


def drag(name: str, by: tuple[float, float, float], picture: str = ""):
    """Puppet Drag of the active bone, from its tail; the mouse stays where it ends."""
    select(name)
    start = tail(name)
    move(*on_screen(start))
    yield from rest()
    with in_view():
        bpy.ops.sinew.puppet_pose("INVOKE_DEFAULT")
    yield from rest()
    for share in np.linspace(0.25, 1.0, 4):
        move(*on_screen(start + share * np.array(by)))
        yield
    yield from rest()
    if picture:
        screenshot(picture)
        yield


def click():
    press("LEFTMOUSE")
    yield from rest(3)


def journey():
    yield from prepare()
    screenshot("puppet-1-rest")
    still, stood, long = shown_points(skin()), feet(), lengths()
    select("foot.L", "foot.R")
    with in_view():
        bpy.ops.sinew.puppet_pin(action="PIN")
    seen["pinned"] = sorted(bone.name for bone in figure().pose.bones if bone.sinew.pin)
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    before = tail(HAND)
    yield from drag(HAND, REACH, "puppet-2-hand")
    yield from click()
    reached = shown_points(skin())
    seen["hand"] = float(np.abs(tail(HAND) - before - REACH).max())
    seen["hand feet"], seen["hand lengths"] = apart(feet(), stood), apart(lengths(), long)
    seen["skin"] = apart(reached, still)
    seen["keyed"] = keyed_bones()
    before = tail(HIP)
    yield from drag(HIP, CROUCH, "puppet-3-hip")
    yield from click()
    crouched = shown_points(skin())
    seen["hip"] = float(np.abs(tail(HIP) - before - CROUCH).max())
    seen["hip feet"], seen["hip lengths"] = apart(feet(), stood), apart(lengths(), long)
    press("Z", ctrl=True)
    yield from rest(3)
    seen["undone"] = apart(shown_points(skin()), reached)
    press("Z", ctrl=True, shift=True)
    yield from rest(3)
    seen["redone"] = apart(shown_points(skin()), crouched)
    yield from drag(HAND, (0.2, 0.0, -0.4))
    seen["before escape"] = apart(shown_points(skin()), crouched)
    press("ESC")
    yield from rest(3)
    seen["given up"] = apart(shown_points(skin()), crouched)
    seen["mode"] = bpy.context.mode
    screenshot("puppet-4-crouched")


play(journey())
