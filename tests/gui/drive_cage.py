# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: an automatic cage, posed in Edit Mode by keys, its weights drawn."""

import bpy
import numpy as np
from driving import (
    apart,
    differing,
    enable,
    in_view,
    middle,
    move,
    only_head,
    open_tab,
    play,
    press,
    rest,
    screenshot,
    seen,
    select,
    shown_points,
    until,
    viewport,
    works,
    write,
)

COORDINATES = ("positive_mean_value", "harmonic", "green")


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def prepare() -> None:
    enable()
    only_head().modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.shade_smooth()
    viewport().spaces.active.show_region_ui = True


def is_well() -> bool:
    return head().sinew.active.status_level == "INFO"


def moved(before: np.ndarray) -> float:
    return apart(shown_points(head()), before)


def face_count() -> int:
    return len(head().sinew.active.cage.data.polygons)


def change_faces():
    """By the dialog: once with Esc while a thread makes the cage, once to the end, and back by one undo."""
    found = seen["faces"] = {"before": face_count()}
    for key in ("cancelled", "changed"):
        move(*middle())
        yield
        with in_view():
            bpy.ops.sinew.cage_faces("INVOKE_DEFAULT", faces=120)
        yield from rest()
        screenshot(f"2-dialog-{key}")
        press("RET")
        yield from until(works, 10.0)
        found[f"{key} in a thread"] = works()
        if key == "cancelled":
            press("ESC")
        yield from until(lambda: not works())
        if key == "changed":
            yield from until(lambda: face_count() != found["before"], 10.0)
        yield from rest(4)
        found[key] = face_count()
        found[f"{key} is well"] = is_well()
    press("Z", ctrl=True)
    yield from rest(4)
    found["undone"] = face_count()


def steps():
    prepare()
    yield from rest()
    yield from open_tab()
    yield from rest()
    screenshot("1-start")
    with in_view():
        bpy.ops.view3d.view_selected()
        bpy.ops.sinew.cage_add("INVOKE_DEFAULT", faces=200)
    yield from until(lambda: head().sinew.active is not None and head().sinew.active.is_bound)
    deformer = head().sinew.active
    cage, name = deformer.cage, deformer.cage.name
    seen["cage"] = {
        "faces": len(cage.data.polygons),
        "active": bpy.context.view_layer.objects.active == cage,
        "status": deformer.status,
        "level": deformer.status_level,
        "drawn as": cage.display_type,
    }
    at_rest = shown_points(head())
    yield from rest()
    screenshot("2-cage")
    yield from change_faces()
    cage = bpy.data.objects[name]

    move(*middle())
    yield
    press("TAB")
    yield from until(lambda: cage.mode == "EDIT")
    select(cage, lambda point: point.x > 0.75)
    yield from rest()
    move(*middle())
    yield
    press("G")
    yield
    press("Z")
    write(".5")
    yield from rest()
    seen["while moving"] = moved(at_rest)
    press("RET")
    yield from rest()
    posed = shown_points(head())
    seen["posed"] = moved(at_rest)
    seen["far side"] = float(np.abs(posed - at_rest)[at_rest[:, 0] < -1.0].max())
    screenshot("3-edit-mode")
    press("Z", ctrl=True)
    yield from until(lambda: moved(at_rest) < 1e-6, 10.0)
    seen["undone"] = moved(at_rest)
    press("Z", ctrl=True, shift=True)
    yield from until(lambda: moved(posed) < 1e-6, 10.0)
    seen["redone"] = moved(posed)
    press("TAB")
    yield from until(lambda: bpy.data.objects[name].mode == "OBJECT")
    seen["left edit mode"] = moved(posed)

    for method in COORDINATES:
        head().sinew.active.method = method
        yield from until(lambda before=posed: is_well() and moved(before) > 1e-4)
        posed = shown_points(head())
        seen[method] = [head().sinew.active.status_level, moved(at_rest), moved(posed)]
        yield
        screenshot(f"4-{method}")

    wanted = bpy.context.scene.sinew
    wanted.overlay = "CAGE"
    wanted.show_overlay = True
    yield from rest(4)
    screenshot("5-weights")
    wanted.show_overlay = False
    yield from rest(4)
    screenshot("6-plain")
    seen["coloured"] = differing("5-weights", "6-plain")

    with in_view():
        bpy.ops.sinew.cage_set_rest("INVOKE_DEFAULT")
    yield from until(lambda: moved(at_rest) < 1e-6, 20.0)
    seen["rest again"] = moved(at_rest)
    bpy.data.objects.remove(bpy.data.objects[name])
    yield from rest()
    seen["cage deleted"] = [head().sinew.active.status, moved(at_rest)]
    screenshot("7-cage-deleted")


play(steps())
