# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: F12 after settings that count in renders alone were changed."""

import sys

import bpy
import numpy as np
from driving import MODULE, enable, in_view, play, rest, seen, until

enable()

from probe import Probe  # noqa: E402 - needs the add-on
from rigs.rig import Rig, evaluated_points  # noqa: E402

HEIGHT = 0.5


def sheet(level: int) -> Rig:
    """A lifted handle on a sheet that has a level in the viewport and in renders."""
    rig = Rig.plate(5)
    modifier = rig.obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = level
    rig.bind()
    rig.lift(HEIGHT)
    return rig


def f12(rig: Rig):
    """What a render beside the window shows."""
    Probe.seen.clear()
    bpy.context.scene.render.engine = Probe.bl_idname
    with in_view():
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: Probe.seen and not bpy.app.is_job_running("RENDER"))
    yield from rest()
    return Probe.seen[-1][rig.name]


def off(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max()) if one.shape == other.shape else 1e9


def notes(rig: Rig) -> list[str]:
    return [line.text for line in sys.modules[f"{MODULE}.core.status"].notes(rig.deformer.uid)]


def playback(rig: Rig):
    """Notes how many counts renders are bound for while frames play that have one of two each."""
    modifier, counts = rig.obj.modifiers[0], set()
    for frame in range(1, 31):
        modifier.render_levels = 1 + frame // 6 % 2
        modifier.keyframe_insert("render_levels", frame=frame)
    yield from rest(10)
    with in_view():
        bpy.ops.screen.animation_play()
    for _ in range(40):
        counts.add(len(rig.deformer.rest_in("RENDER").vertices))
        yield
    with in_view():
        bpy.ops.screen.animation_play()
    seen["counts in playback"] = len(counts)


def journey():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    wanted = {}
    for level in (0, 1, 3):
        rig = sheet(level)
        yield from rest()
        wanted[level] = evaluated_points(rig.obj)
        bpy.data.objects.remove(rig.obj)
    rig = sheet(2)
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = 8
    yield from rest(8)
    modifier = rig.obj.modifiers[0]
    for level in (3, 1):
        modifier.render_levels = level
        yield from rest(10)
        seen[f"level {level}"] = off((yield from f12(rig)), wanted[level])
    modifier.show_render = False
    yield from rest(10)
    seen["hidden"] = off((yield from f12(rig)), wanted[0])
    modifier.show_render = True
    modifier.levels = 1
    modifier.render_levels = 3
    yield from rest(10)
    seen["viewport"] = rig.deformer.status
    seen["other levels"] = off((yield from f12(rig)), wanted[3])
    modifier.levels = 2
    yield from rest(10)
    modifier.render_levels = 1  # and the render begins at once
    seen["at once"] = off((yield from f12(rig)), wanted[1])
    seen["noted"] = notes(rig)
    yield from rest(10)
    seen["the next"] = off((yield from f12(rig)), wanted[1])
    seen["noted next"] = notes(rig)
    yield from playback(rig)


play(journey())
