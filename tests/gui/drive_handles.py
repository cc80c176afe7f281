# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: overlays, handles in their list, weights by brush, new vertices, heavy
drags.
"""

import sys
import time

import addon_utils
import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driving import (
    MODULE,
    apart,
    binding,
    click,
    differing,
    drag,
    enable,
    in_view,
    middle,
    move,
    new_head,
    play,
    press,
    region,
    rest,
    screenshot,
    seen,
    select,
    sessions,
    shown_points,
    until,
    view_pixels,
    viewport,
    window,
    write,
)
from mathutils import Color, Vector

REGIONS = {
    "Ear.L": ("HANDLE", lambda point: point.x > 1.6),
    "Ear.R": ("HANDLE", lambda point: point.x < -1.6),
    "Muzzle": ("HANDLE", lambda point: point.z < -0.9 and point.y < -0.3),
    "Back": ("FIXED", lambda point: point.y > 0.35 and abs(point.x) < 1.2),
}
LIFT = 0.45
FRONT, SLANTED = (0.7071, 0.7071, 0.0, 0.0), (0.0, 0.0, 0.383, 0.924)  # from behind and above
SPOTS = {  # in the middle of a region, or of a part that is free
    "ear": lambda x, y, z: x > 1.75,
    "back": lambda x, y, z: y > 0.7 and abs(x) < 0.8,
    "free": lambda x, y, z: abs(x) < 0.8 and -0.1 < y < 0.1,
}

# Where things are in the window, from its lower left corner, with the Properties editor made wide and high.
NAME, CONTROL, WEIGHT, SELECT, EYE, BESIDE = 970, 1080, 1166, 1198, 1217, 1252
FIRST_ROW, ROW = 376, 21
MOVE_UP, MOVE_DOWN = 305, 285
REBIND = (1215, 500)


def row(index: int) -> int:
    return FIRST_ROW - ROW * index


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def deformer():
    return head().sinew.active


def names() -> list[str]:
    return [handle.name for handle in deformer().handles]


def shown() -> np.ndarray:
    return shown_points(head())


def settled():
    yield from rest()
    yield from until(lambda: not sessions().unsettled() and not binding().busy())
    yield from rest()


def properties() -> bpy.types.Area:
    return next(area for area in window().screen.areas if area.type == "PROPERTIES")


def prepare():
    """A posed head with three handles and a fixed region, seen from the front."""
    enable()
    new_head(2, REGIONS)
    deformer().handles[0].control.matrix_world.translation.z += LIFT
    deformer().handles[2].control.matrix_world.translation.x -= 0.3
    view = viewport().spaces.active.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = (0.0, 0.0, 0.25), 5.8
    bpy.ops.ed.undo_push(message="Pose")
    yield from settled()


def overlay():
    return sys.modules[f"{MODULE}.ui.overlays.overlay"]


def look(name: str, **wanted: object):
    """Change settings as the panel does; a screenshot."""
    for setting, value in wanted.items():
        setattr(bpy.context.scene.sinew, setting, value)
    viewport().tag_redraw()
    yield from rest(3)
    screenshot(name)


def in_picture(vertex: int) -> tuple[int, int]:
    """Where a vertex appears in ``view_pixels``: column and row."""
    point = Vector(shown()[vertex])
    found = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, point)
    return round(found.x), round(found.y)


def nearest(where) -> int:
    """The vertex nearest to the viewer among those for which ``where(x, y, z)`` at rest."""
    turn, points = viewport().spaces.active.region_3d.view_matrix, shown()
    chosen = [vertex.index for vertex in head().data.vertices if where(*vertex.co)]
    return max(chosen, key=lambda index: (turn @ Vector(points[index])).z)


def most_stretched() -> int:
    """The vertex around which the area grew most, among those that the viewer sees from the front."""
    result, measure = (
        sys.modules[f"{MODULE}.{name}"] for name in ("session.results.result", "core.geometry.distortion")
    )
    values = result.measured(head(), deformer(), measure.Measure.AREA).values
    evaluated = head().evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    turn = viewport().spaces.active.region_3d.view_matrix.to_3x3()
    return max(range(len(evaluated)), key=lambda i: values[i] * ((turn @ evaluated[i].normal).z > 0.8))


def overlays():
    """What each overlay paints is tested without a window; here it is drawn."""
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(obj != head())
    viewport().spaces.active.region_3d.view_rotation = SLANTED
    head().select_set(False)
    yield from look("off")
    preferences = bpy.context.preferences.addons[MODULE].preferences
    seen["opacity"] = preferences.overlay_opacity
    seen["colours"] = {
        name: list(Color(linear).from_scene_linear_to_srgb())
        for name, linear in (("ear", deformer().handles[0].colour), ("back", preferences.overlay_fixed))
    }
    spots = {name: in_picture(nearest(where)) for name, where in SPOTS.items()}
    yield from look("regions", show_overlay=True, overlay="REGIONS")
    viewport().spaces.active.shading.show_xray = True
    yield from look("x-ray")
    viewport().spaces.active.shading.show_xray = False
    mode("EDIT")
    with in_view():
        bpy.ops.mesh.select_all(action="DESELECT")
    yield from look("edit")
    mode("OBJECT")
    yield from look("area", overlay="DISTORTION", measure="AREA", distortion_range=1.25)
    spots["stretched"] = in_picture(most_stretched())
    painted = overlay().cache.computed
    for _ in range(4):
        yield from look("idle")
    seen["painted_while_idle"] = overlay().cache.computed - painted
    yield from look("off-again", show_overlay=False)
    seen["drawing_when_off"] = overlay().is_drawing()
    pictures = ("off", "regions", "x-ray", "edit", "area", "off-again")
    seen["changed"] = {name: differing(name, "off", 0.02) for name in pictures}
    seen["pixels"] = {name: {spot: colour_at(name, *spots[spot]) for spot in spots} for name in pictures}
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(False)
    viewport().spaces.active.region_3d.view_rotation = FRONT
    bpy.context.view_layer.objects.active = head()
    yield from rest()


def colour_at(name: str, x: int, y: int) -> list[float]:
    return view_pixels(name)[y - 1 : y + 2, x - 1 : x + 2].mean(axis=(0, 1)).tolist()


def disable():
    """With an overlay on; without the toolbar, which loses our tool."""
    viewport().spaces.active.show_region_toolbar = False
    yield from rest()
    yield from look("last", show_overlay=False)
    yield from look("last-regions", show_overlay=True, overlay="REGIONS")
    addon_utils.disable(MODULE)
    yield from rest(3)
    screenshot("disabled")
    seen["before_disabled"] = differing("last-regions", "last", 0.02)
    seen["disabled"] = [overlay().is_drawing(), differing("disabled", "last", 0.02)]


def wide_panel():
    """The panel in the Modifiers tab; the editor made wide and high by its edges."""
    editor = properties()
    move(editor.x - 40, 330)
    yield
    yield from drag((editor.x - 1, 330), (860, 330))
    top = editor.y + editor.height
    move(1000, top - 60)
    yield
    yield from drag((1000, top), (1000, 740))
    editor.spaces.active.context = "MODIFIER"
    yield from rest()
    yield from click(945, editor.y + editor.height - 117)
    yield from rest(3)
    screenshot("1-panel")


def use_and_select():
    """The eye, the arrow."""
    posed = shown()
    yield from click(EYE, row(0))
    yield from settled()
    seen["eye_off"] = [deformer().handles[0].enabled, apart(shown(), posed)]
    yield from click(EYE, row(0))
    yield from settled()
    seen["eye_on"] = [deformer().handles[0].enabled, apart(shown(), posed)]
    yield from click(SELECT, row(1))
    yield from rest()
    seen["arrow"] = [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()]


def weight():
    """Drag the number."""
    posed = shown()
    yield from drag((WEIGHT, row(0)), (WEIGHT - 40, row(0)))
    yield from settled()
    seen["weight"] = [deformer().handles[0].weight, apart(shown(), posed)]
    press("Z", ctrl=True)
    yield from settled()
    seen["weight_undone"] = [deformer().handles[0].weight, apart(shown(), posed)]


def rename_and_order():
    """In place; up and down."""
    posed = shown()
    yield from click(NAME, row(0), ctrl=True)
    yield from rest()
    write("ear")
    yield
    press("RET")
    yield from rest()
    seen["renamed"] = [names(), deformer().handles[0].vertex_group]
    yield from click(CONTROL, row(2))
    yield from rest()
    seen["active"] = deformer().active_handle
    yield from click(BESIDE, MOVE_UP)
    yield from settled()
    seen["up"] = [names(), apart(shown(), posed)]
    yield from click(BESIDE, MOVE_DOWN)
    yield from settled()
    seen["down"] = [names(), apart(shown(), posed)]


def missing_control():
    """Deleted by the user; another picked in the list."""
    other = bpy.data.objects.new("Other", None)
    other.location = (1.0, 2.0, 3.0)
    bpy.context.scene.collection.objects.link(other)
    posed = shown()
    yield from click(SELECT, row(0))
    yield from rest()
    move(*middle())
    press("X")
    yield from rest()
    press("RET")
    yield from settled()
    seen["missing"] = [deformer().handles[0].control_missing, apart(shown(), posed)]
    screenshot("2-control-missing")
    yield from click(CONTROL, row(0))
    yield from rest(3)
    write("other")
    yield from rest()
    press("RET")
    yield from settled()
    picked = deformer().handles[0].control
    seen["picked"] = [picked and picked.name, apart(shown(), posed)]
    other.location.z += 0.25
    yield from settled()
    seen["follows_picked"] = float((shown() - posed)[:, 2].max())


def mode(name: str) -> None:
    bpy.context.view_layer.objects.active = head()
    with in_view():
        bpy.ops.object.mode_set(mode=name)


def paint():
    """A stroke of weight 0 over the lower half of the lifted ear."""
    posed = shown()
    mode("WEIGHT_PAINT")
    yield from click(SELECT, row(0))
    seen["painting"] = head().vertex_groups.active.name
    unified = bpy.context.scene.tool_settings.unified_paint_settings
    unified.use_unified_weight = unified.use_unified_size = True
    unified.weight, unified.size = 0.0, 25
    bpy.context.scene.tool_settings.weight_paint.brush.strength = 1.0
    yield from rest()
    group = head().vertex_groups["Ear.L"].index
    held = weights(group)
    view = viewport().spaces.active.region_3d
    lowest = min(held, key=lambda index: posed[index][2])
    spot = location_3d_to_region_2d(region(), view, Vector(posed[lowest]))
    x, y = region().x + round(spot.x), region().y + round(spot.y)
    yield from drag((x - 15, y + 5), (x + 15, y + 20), steps=6)
    yield from settled()
    seen["painted_away"] = sum(held.values()) - sum(weights(group).values())
    live = shown()
    seen["paint_changed"] = apart(live, posed)
    screenshot("3-painted")
    yield
    mode("OBJECT")
    with in_view():
        bpy.ops.sinew.bind()
    yield from settled()
    seen["paint_as_bound_anew"] = apart(shown(), live)


def weights(group: int) -> dict[int, float]:
    """Of the vertices in a group, by index."""
    return {
        vertex.index: entry.weight
        for vertex in head().data.vertices
        for entry in vertex.groups
        if entry.group == group
    }


def subdivide_muzzle():
    """Some faces more, in Edit Mode, by Blender's own operator."""
    mode("EDIT")
    select(head(), lambda point: point.z < -0.9 and point.y < -0.6)
    with in_view():
        bpy.ops.mesh.subdivide()
    yield from rest()
    move(*middle())
    press("TAB")
    yield from settled()


def edit_topology():
    """Without Automatic Rebind the panel asks for a click; with it nobody has to."""
    yield from subdivide_muzzle()
    base = np.array([vertex.co for vertex in head().data.vertices])
    seen["topology"] = [deformer().status_level, deformer().status, apart(shown(), base)]
    screenshot("4-topology")
    yield from click(*REBIND)
    yield from until(lambda: deformer().status_level == "INFO")
    seen["rebound"] = [deformer().status_level, len(base), deformer().status]
    seen["lifted_again"] = float((shown() - base)[:, 2].max())
    deformer().auto_rebind = True
    yield from subdivide_muzzle()
    yield from until(lambda: deformer().status_level == "INFO")
    base = np.array([vertex.co for vertex in head().data.vertices])
    seen["automatic"] = [deformer().status_level, len(base), deformer().status]
    seen["lifted_automatically"] = float((shown() - base)[:, 2].max())
    screenshot("5-rebound")


def heavy_drag():
    """A grid of 160,801 vertices: a thread answers while the mouse moves on."""
    bpy.data.objects.remove(head())
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=400, y_subdivisions=400, size=4.0)
    obj = bpy.context.object
    obj.name = "Head"
    for name, side in (("Left", -1.0), ("Right", 1.0)):
        members = [vertex.index for vertex in obj.data.vertices if vertex.co.x * side > 1.6]
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    with in_view():
        bpy.ops.sinew.deformer_add(method="arap")
        bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Right")
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Left")
    bpy.context.view_layer.objects.active = obj  # and its control is selected, so that the panel stays
    yield from rest()
    properties().spaces.active.context = "MODIFIER"
    with in_view():
        bpy.ops.ed.undo_push(message="Before the heavy drag")
    viewport().spaces.active.region_3d.view_rotation = (0.8, 0.53, 0.15, 0.24)
    before, lifts = shown(), []
    seen["in_thread"] = seen["unsettled"] = False
    here = middle()
    move(*here)
    yield from rest()
    press("G")
    yield
    press("Z")
    for step in range(1, 13):
        move(here[0], here[1] + 8 * step)
        yield
        lifts.append(float((shown() - before)[:, 2].max()))
        seen["in_thread"] |= binding().busy()
        seen["unsettled"] |= deformer().uid in sessions().unsettled()
    press("LEFTMOUSE")
    seen["lifts"] = lifts
    yield from rest()
    seen["marked"] = sessions().is_refining(deformer().uid)
    screenshot("6-refining")
    yield from until(lambda: not sessions().unsettled() and not binding().busy(), 120.0)
    yield from rest()
    seen["heavy_settled"] = not sessions().unsettled()
    handle = deformer().handles[1].control.matrix_world.translation.z
    seen["heavy_lift"] = [handle, float((shown() - before)[:, 2].max())]
    screenshot("6-heavy")
    yield from undo_heavy(before)


def undo_heavy(before: np.ndarray):
    """Undo of the drag: which shapes are shown on the way, and whether the mesh was bound again for it."""
    factor, dragged, off = sessions().find(deformer().uid).bound.factor, shown(), []
    press("Z", ctrl=True)
    yield from until(lambda: apart(shown(), dragged) > 0.1)
    seen["undo_binds"] = 0
    end = time.monotonic() + 120.0
    quiet = 0
    while quiet < 5 and time.monotonic() < end:
        off.append(apart(shown(), before))
        seen["undo_binds"] += binding().job(deformer().uid) is not None
        quiet = 0 if sessions().is_refining(deformer().uid) else quiet + 1
        yield
    seen["undo_off"] = max(off)
    seen["undo_keeps_factor"] = sessions().find(deformer().uid).bound.factor is factor


def journey():
    viewport().spaces.active.show_region_hud = False  # the panel for the last operation is in no picture
    yield from prepare()
    yield from overlays()
    yield from wide_panel()
    yield from use_and_select()
    yield from weight()
    yield from rename_and_order()
    yield from missing_control()
    yield from paint()
    yield from edit_topology()
    yield from heavy_drag()
    yield from disable()


play(journey())
