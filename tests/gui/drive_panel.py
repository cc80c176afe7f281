# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: what the panel shows in a sidebar as wide as Blender makes it."""

import bpy
import numpy as np
from driving import (
    enable,
    in_view,
    move,
    open_tab,
    pixels,
    play,
    press,
    region,
    rest,
    screenshot,
    seen,
    viewport,
)

FRAMES = (1, 8, 128, 1024)  # frame 1 is the current one, so its row has another icon


def sidebar(name: str) -> np.ndarray:
    """A screenshot of the sidebar."""
    place = region("UI")
    screenshot(name)
    return pixels(name)[place.y : place.y + place.height, place.x : place.x + place.width]


def keys():
    """Each key says its frame: the picture of the list changes with the number."""
    with in_view():
        bpy.ops.sinew.deformer_add(method="mesh_sequence")
    deformer = bpy.context.object.sinew.active
    for frame in FRAMES:
        deformer.keys.add().frame = frame
    place = region("UI")
    move(place.x + place.width // 3, place.y + place.height // 3)
    yield
    for _ in range(15):  # down to the end of the panel
        press("WHEELDOWNMOUSE")
        yield
    yield from rest(4)
    before = sidebar("1-keys")
    seen["width"] = place.width / bpy.context.preferences.system.ui_scale
    seen["rows that changed"] = {}
    for row in deformer.keys[1:]:
        row.frame += 5
        place.tag_redraw()
        yield from rest(4)
        after = sidebar(f"2-key-{row.frame}")
        differs = np.abs(after - before).max(axis=2) > 0.1
        seen["rows that changed"][row.frame] = int(differs.any(axis=1).sum())
        before = after


def steps():
    enable()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_monkey_add()
    viewport().spaces.active.show_region_ui = True
    yield from rest()
    yield from open_tab()
    with in_view():
        bpy.ops.screen.screen_full_area()
    yield from rest(4)
    yield from keys()


play(steps())
