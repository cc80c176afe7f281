# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: each overlay on a posed cow, and the picture without them as it was.

Steps are a generator, as in ``drive.py``; observations and screenshots go to the folder named after ``--``.
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
    screenshot,
    seen,
    view_pixels,
    viewport,
)
from mathutils import Color, Euler, Matrix, Vector


def overlays():
    return sys.modules[f"{MODULE}.ui.overlay"]


def settings():
    return bpy.context.scene.sinew


def cow() -> bpy.types.Object:
    return bpy.data.objects["Spot"]


def model() -> bpy.types.Object:
    """Spot the cow, z up, looking along +x: 2,930 vertices."""
    points, faces = [], []
    for line in (MODELS / "spot.obj").read_text(encoding="ascii").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            x, y, z = map(float, rest)
            points.append((-z, -x, y))
        elif word == "f":
            faces.append([int(corner.split("/")[0]) - 1 for corner in rest])
    floor = min(point[2] for point in points)
    mesh = bpy.data.meshes.new("Spot")
    mesh.from_pydata([(x, y, z - floor) for x, y, z in points], [], faces)
    obj = bpy.data.objects.new("Spot", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.object.shade_smooth()
    return obj


def groups(obj: bpy.types.Object) -> None:
    """Head (soft towards the neck), a hoof, three hooves that stay, and what the neck lets give way."""
    flat = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
    obj.data.vertices.foreach_get("co", flat)
    x, y, z = flat.reshape(-1, 3).T
    right_front = (x > -0.2) & (y < 0.0)
    weights = {
        "Head": np.clip((x + z - 1.05) / 0.35, 0.0, 1.0) * (x > 0.0),
        "Hoof": 1.0 * (right_front & (z < 0.125)),
        "Hooves": 1.0 * (~right_front & (z < 0.125)),
        "Firm": np.clip(1.3 - 0.9 * z, 0.05, 1.0),
        "Front": np.clip(0.5 + 2.0 * (x + 0.35), 0.0, 1.0),
    }
    for name, values in weights.items():
        group = obj.vertex_groups.new(name=name)
        for weight in np.unique(np.round(values, 2)):
            if weight > 0.0:
                members = np.flatnonzero(np.round(values, 2) == weight)
                group.add(members.tolist(), float(weight), "REPLACE")


def prepare() -> None:
    """The cow bound, not posed yet, the Sinew tab open."""
    enable()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    obj = model()
    groups(obj)
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
    seen[name] = {"drawing": overlays().is_drawing(), "painted": overlays().gallery.painted}
    screenshot(name)


def drawn(name: str) -> np.ndarray:
    """The part of a screenshot that shows the mesh, (rows, columns, 3), from below."""
    return view_pixels(name)


def place(vertex: int) -> tuple[int, int]:
    """Where a vertex appears in ``drawn``: column and row."""
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


LOOKS = {
    "regions": {"overlay": "REGIONS"},
    "weight": {"overlay": "WEIGHT"},
    "parameter": {"overlay": "PARAMETER"},
    "mask": {"overlay": "MASK"},
    "stretch": {"overlay": "DISTORTION", "measure": "STRETCH"},
    "area": {"overlay": "DISTORTION", "measure": "AREA"},
    "angle": {"overlay": "DISTORTION", "measure": "ANGLE"},
    "dirichlet": {"overlay": "DISTORTION", "measure": "DIRICHLET"},
}


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
            ("compressed", chosen.overlay_compressed),
            ("stretched", chosen.overlay_stretched),
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
    show(show_overlay=True, distortion_range=1.5)
    for name, look in LOOKS.items():
        if name == "parameter":
            cow().sinew.active.arap.rigidity_group = "Firm"
        elif name == "mask":
            cow().sinew.active.arap.rigidity_group = ""
            cow().sinew.active.mask_group = "Front"
        show(**look)
        yield
        yield
        state(name)
        if name == "mask":
            cow().sinew.active.mask_group = ""
        yield
    seen["painted_before_idle"] = overlays().gallery.painted
    for _ in range(4):
        viewport().tag_redraw()
        yield
    seen["painted_after_idle"] = overlays().gallery.painted
    viewport().spaces.active.overlay.show_overlays = False
    yield
    screenshot("blender-off")
    yield
    show(show_overlay=False)
    yield
    screenshot("blender-off-too")
    viewport().spaces.active.overlay.show_overlays = True
    yield
    state("off-again")
    yield
    show(show_overlay=True, overlay="REGIONS")
    cow().hide_set(True)
    yield
    screenshot("hidden")
    yield
    show(show_overlay=False)
    yield
    screenshot("hidden-off")
    cow().hide_set(False)
    show(show_overlay=True)
    lone = bpy.data.objects.new("Lone", None)
    bpy.context.scene.collection.objects.link(lone)
    bpy.context.view_layer.objects.active = lone
    yield
    with in_view():
        lone.select_set(True)
        bpy.ops.view3d.localview(frame_selected=False)
    yield
    yield
    screenshot("local-view")
    with in_view():
        bpy.ops.view3d.localview(frame_selected=False)
    bpy.data.objects.remove(lone)
    bpy.context.view_layer.objects.active = cow()
    yield
    viewport().spaces.active.shading.show_xray = True
    yield
    yield
    screenshot("x-ray")
    viewport().spaces.active.shading.show_xray = False
    cow().modifiers.new("Subdivision", "SUBSURF")
    yield
    yield
    yield
    screenshot("subdivided")
    cow().modifiers.remove(cow().modifiers["Subdivision"])
    yield
    with in_view():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
    yield
    yield
    screenshot("edit")
    with in_view():
        bpy.ops.object.mode_set(mode="OBJECT")
    yield
    addon_utils.disable(MODULE)
    yield
    seen["drawing_after_disable"] = overlays().is_drawing()
    screenshot("disabled")
    yield
    look_at(spots)


def look_at(spots: dict[str, tuple[int, int]]) -> None:
    """Colours at known places, and how many pixels each overlay changed."""
    off = drawn("off")
    for path in OUTPUT.glob("*.png"):
        picture = drawn(path.stem)
        seen.setdefault("pixels", {})[path.stem] = {
            "changed": float((np.abs(picture - off).max(axis=2) > 0.02).mean()),
            **{
                name: picture[y - 1 : y + 2, x - 1 : x + 2].mean(axis=(0, 1)).tolist()
                for name, (x, y) in spots.items()
            },
        }


play(journey(), pause=0.25)
