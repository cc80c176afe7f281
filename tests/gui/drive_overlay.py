# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: overlays on a posed cow, and the picture without them as it was.

What each overlay paints is tested without a window; here it is drawn. Steps are a generator, as in
``drive.py``; observations and screenshots go to the folder named after ``--``.
"""

import sys

import addon_utils
import bpy
import numpy as np
from bpy_extras import view3d_utils
from driving import (
    MODELS,
    MODULE,
    OUTPUT,
    enable,
    in_view,
    open_tab,
    play,
    region,
    rest,
    screenshot,
    seen,
    view_pixels,
    viewport,
)
from mathutils import Color, Euler, Matrix, Vector

sys.path.append(str(MODELS.parent))

from models.spot import read


def overlays():
    return sys.modules[f"{MODULE}.ui.overlay"]


def settings():
    return bpy.context.scene.sinew


def cow() -> bpy.types.Object:
    return bpy.data.objects["Spot"]


def model() -> bpy.types.Object:
    """Spot the cow, 2,930 vertices, with groups: the head, a hoof, and three hooves that stay."""
    points, faces = read()
    mesh = bpy.data.meshes.new("Spot")
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new("Spot", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.object.shade_smooth()
    x, y, z = points.T
    right_front = (x > -0.2) & (y < 0.0)
    weights = {
        "Head": np.clip((x + z - 1.05) / 0.35, 0.0, 1.0) * (x > 0.0),  # soft towards the neck
        "Hoof": 1.0 * (right_front & (z < 0.125)),
        "Hooves": 1.0 * (~right_front & (z < 0.125)),
    }
    for name, values in weights.items():
        group = obj.vertex_groups.new(name=name)
        for weight in np.unique(np.round(values, 2))[1:]:
            group.add(np.flatnonzero(np.round(values, 2) == weight).tolist(), float(weight), "REPLACE")
    return obj


def prepare() -> None:
    """The cow bound, not posed yet, the Sinew tab open."""
    enable()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    obj = model()
    bpy.ops.sinew.deformer_add(method="arap")
    for kind, name in (("HANDLE", "Head"), ("HANDLE", "Hoof"), ("FIXED", "Hooves")):
        bpy.context.view_layer.objects.active = obj
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=name)
    bpy.context.view_layer.objects.active = obj
    space = viewport().spaces.active
    space.show_region_ui = True
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    space.overlay.show_cursor = False
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_rotation = Vector((0.80, -0.60, 0.12)).to_track_quat("Z", "Y")
    space.region_3d.view_location = (0.05, 0.0, 0.95)
    space.region_3d.view_distance = 2.7


def pose() -> None:
    """The head turns and looks up, the hoof waves."""
    for index, (shift, turn, pivot) in enumerate(
        (
            ((0.10, -0.10, 0.22), (20.0, -16.0, -24.0), (0.05, 0.0, 0.95)),
            ((0.30, -0.12, 0.38), (0.0, -52.0, -10.0), (0.18, -0.2, 0.10)),
        )
    ):
        control = cow().sinew.active.handles[index].control
        around = Matrix.Translation(pivot)
        rotation = Euler(np.radians(turn)).to_matrix().to_4x4()
        motion = Matrix.Translation(shift) @ around @ rotation @ around.inverted()
        control.matrix_world = motion @ control.matrix_world
        control.hide_set(True)


def show(**wanted: object) -> None:
    """Change settings as the panel does; the overlay itself last."""
    for name, value in wanted.items():
        setattr(settings(), name, value)


def state(name: str) -> None:
    """What the add-on holds, with the screenshot of the same moment."""
    seen[name] = {"drawing": overlays().is_drawing(), "painted": overlays().cache.computed}
    screenshot(name)


def place(vertex: int) -> tuple[int, int]:
    """Where a vertex appears in ``view_pixels``: column and row."""
    evaluated = cow().evaluated_get(bpy.context.evaluated_depsgraph_get())
    point = evaluated.matrix_world @ evaluated.data.vertices[vertex].co
    space = viewport().spaces.active
    found = view3d_utils.location_3d_to_region_2d(region(), space.region_3d, point)
    return round(found.x), round(found.y)


def front_vertex(where) -> int:
    """The vertex nearest to the viewer among those for which ``where(x, y, z)`` at rest."""
    evaluated = cow().evaluated_get(bpy.context.evaluated_depsgraph_get())
    turn = viewport().spaces.active.region_3d.view_matrix
    chosen = [vertex.index for vertex in cow().data.vertices if where(*vertex.co)]
    return max(chosen, key=lambda index: (turn @ evaluated.data.vertices[index].co).z)


def journey():
    prepare()
    yield
    yield from open_tab()
    yield
    pose()
    yield
    yield
    yield
    cow().select_set(False)
    cow().sinew.active.active_handle = 0
    yield
    state("off")
    chosen = bpy.context.preferences.addons[MODULE].preferences
    seen["opacity"] = chosen.overlay_opacity
    seen["colours"] = {
        name: list(Color(linear).from_scene_linear_to_srgb())
        for name, linear in (
            ("head", cow().sinew.active.handles[0].colour),
            ("hoof", cow().sinew.active.handles[1].colour),
            ("hooves", chosen.overlay_fixed),
        )
    }
    spots = {
        "head": place(front_vertex(lambda x, y, z: x + z > 1.5)),
        "hoof": place(front_vertex(lambda x, y, z: x > -0.2 and y < 0.0 and z < 0.1)),
        "hooves": place(front_vertex(lambda x, y, z: x < -0.4 and y < 0.0 and z < 0.06)),
        "chest": place(front_vertex(lambda x, y, z: y > 0.1 and x > 0.0 and 0.45 < z < 0.6)),
        "flank": place(front_vertex(lambda x, y, z: x < -0.4 and 0.55 < z < 0.9)),
    }
    yield
    show(show_overlay=True, overlay="REGIONS")
    yield from rest()
    state("regions")
    yield
    viewport().spaces.active.shading.show_xray = True
    yield from rest()
    screenshot("x-ray")
    viewport().spaces.active.shading.show_xray = False
    yield
    with in_view():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
    yield from rest()
    screenshot("edit")
    with in_view():
        bpy.ops.object.mode_set(mode="OBJECT")
    yield
    show(overlay="DISTORTION", measure="AREA", distortion_range=1.5)
    yield from rest()
    state("area")
    yield
    for _ in range(4):
        viewport().tag_redraw()
        yield
    seen["painted_after_idle"] = overlays().cache.computed
    show(show_overlay=False)
    yield
    state("off-again")
    yield
    show(show_overlay=True)
    yield
    addon_utils.disable(MODULE)
    yield
    seen["drawing_after_disable"] = overlays().is_drawing()
    screenshot("disabled")
    yield
    look_at(spots)


def look_at(spots: dict[str, tuple[int, int]]) -> None:
    """Colours at known places, and how many pixels each overlay changed."""
    off = view_pixels("off")
    for path in OUTPUT.glob("*.png"):
        picture = view_pixels(path.stem)
        seen.setdefault("pixels", {})[path.stem] = {
            "changed": float((np.abs(picture - off).max(axis=2) > 0.02).mean()),
            **{
                name: picture[y - 1 : y + 2, x - 1 : x + 2].mean(axis=(0, 1)).tolist()
                for name, (x, y) in spots.items()
            },
        }


play(journey(), pause=0.25)
