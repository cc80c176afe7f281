# SPDX-License-Identifier: GPL-3.0-or-later
"""Animate, bake and look, for the tests of bakes."""

import math
from pathlib import Path

import bpy
import numpy as np
from rigs.rig import Rig, evaluated_points, key, make_active

FRAMES = range(1, 9)
TARGETS = ("SHAPE_KEYS", "PC2", "MDD")
CACHES = ("PC2", "MDD")
STRETCHES = ((100, 50), (100, 200), (100, 130), (130, 100))


def animate(control: bpy.types.Object, last: int = 8, angle: float = 80.0) -> None:
    """A bend with a turn that grows until the frame ``last``; no coordinate stays simple."""
    control.rotation_mode = "XYZ"
    turned = (math.radians(angle), 0.11, -0.07)
    for frame, part in ((1, 0.0), (last, 1.0)):
        place, turn = (part * np.array(end) for end in ((0.013, -0.8, 0.9), turned))
        key(control, {frame: {"location": place, "rotation_euler": turn}})
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FRAMES[0], FRAMES[-1]


def stretch_time(old: int, new: int) -> None:
    """Time Stretching, in the Format panel of the scene."""
    render = bpy.context.scene.render
    render.frame_map_old, render.frame_map_new = old, new


def played(obj: bpy.types.Object, frames=FRAMES) -> dict[float, np.ndarray]:
    """What Blender shows at each frame."""
    found = {}
    for frame in frames:
        bpy.context.scene.frame_set(math.floor(frame), subframe=frame % 1)
        found[frame] = evaluated_points(obj)
    return found


def assert_same(now: dict, before: dict) -> None:
    for frame, points in before.items():
        assert np.array_equal(now[frame], points), f"frame {frame}: {np.abs(now[frame] - points).max()}"


def bake(plate: Rig, target: str, path: Path | None = None, **keywords) -> None:
    make_active(plate.obj)
    if target != "SHAPE_KEYS" and path is not None:
        keywords["filepath"] = str(path)
    assert bpy.ops.sinew.bake(target=target, **keywords) == {"FINISHED"}


def footprint(plate: Rig) -> dict:
    """Everything a bake could leave behind."""
    obj = plate.obj
    keys = obj.data.shape_keys
    return {
        "modifiers": [(m.name, m.type, m.show_viewport, m.show_render) for m in obj.modifiers],
        "keys": []
        if keys is None
        else [(k.name, k.value, k.mute, k.relative_key.name) for k in keys.key_blocks],
        "objects": sorted(bpy.data.objects.keys()),
        "meshes": sorted(bpy.data.meshes.keys()),
        "actions": sorted(bpy.data.actions.keys()),
        "frame": bpy.context.scene.frame_current,
        "base": plate.rest().tobytes(),
        "baked": [d.bake.result for d in obj.sinew.deformers],
    }
