# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool of the toolbar; overlays, handles in their list, weights by brush, new vertices, heavy drags."""

import sys
import time
from collections.abc import Iterator

import addon_utils
import bpy
import numpy as np
from driving import (
    MODULE,
    Place,
    above,
    apart,
    between,
    binding,
    claim,
    click,
    deformer,
    differing,
    drag,
    head,
    hold,
    in_view,
    look_from_front,
    middle,
    move,
    near,
    new_head,
    on_screen,
    press,
    redo,
    region,
    release,
    rest,
    run,
    screenshot,
    select,
    sessions,
    settled,
    shown_points,
    undo,
    until,
    view_pixels,
    viewport,
    window,
    write,
)
from mathutils import Color, Vector

FLOAT32 = 2e-6  # of a head 4 units wide that is not dragged
DRAGGED = 4e-6


def shown() -> np.ndarray:
    return shown_points(head())


def base() -> np.ndarray:
    return np.array([vertex.co for vertex in head().data.vertices])


EAR, NOSE = (1.7, 0.0, 0.35), (0.0, 0.0, -0.3)  # as seen from the front
NOTHING = ([], [], 0, [])
ONE_HANDLE = ([("SUPPORT", "Support"), ("HANDLE", "Handle")], ["Support", "Handle"], 1, ["Head Handle"])


def left_behind() -> tuple:
    """What a drag makes."""
    rows = [(row.kind, row.name) for deformer in head().sinew.deformers for row in deformer.handles]
    empties = sorted(other.name for other in bpy.data.objects if other.type == "EMPTY")
    return rows, [group.name for group in head().vertex_groups], len(head().modifiers), empties


def drag_surface() -> Iterator[None]:
    """One ear up and out, in one go, and then further by the same handle."""
    new_head(1, {})
    yield from look_from_front()
    bpy.ops.ed.undo_push(message="Head")
    with in_view():
        bpy.ops.wm.tool_set_by_id(name="sinew.drag")
    yield from rest()
    before, start = shown(), on_screen(EAR)
    end = (start[0] + 50, start[1] + 70)
    with claim("a drag makes a handle that follows the mouse"):
        assert left_behind() == NOTHING
        move(start[0] - 2, start[1])
        yield
        move(*start)
        yield from rest(3)
        screenshot("drag-1-hover")
        yield from hold([start, *between(start, end, 3)])
        screenshot("drag-2-dragging")
        yield
        release()
        yield from rest(3)
        after = shown()
        assert left_behind() == ONE_HANDLE
        pixel = 1.0 / (on_screen((1.0, 0.0, 0.0))[0] - on_screen((0.0, 0.0, 0.0))[0])
        group = head().vertex_groups["Handle"].index
        members = [v.index for v in head().data.vertices if any(g.group == group for g in v.groups)]
        above(len(members), 3)
        near(after[members] - before[members], np.array((50.0, 0.0, 70.0)) * pixel, pixel)
        moved = np.abs(after - before).max(axis=1) > 1e-5
        assert 0.01 < moved.mean() < 0.5
        assert not moved[before[:, 0] < 0.0].any()
        assert bpy.context.view_layer.objects.active.name == "Head Handle"
    last = bpy.context.window_manager.operators[-1]
    with claim("the operator of a drag can be adjusted"):
        assert last.bl_idname == "SINEW_OT_drag"
    repeated = {name: getattr(last, name) for name in ("radius", "reach", "method", "mode")}
    repeated |= {name: tuple(getattr(last, name)) for name in ("origin", "direction", "value")}
    yield from drag(end, (end[0], end[1] - 40))
    yield from rest(3)
    again = shown()
    with claim("the next drag there takes the same handle"):
        assert left_behind() == ONE_HANDLE
        near(again[members] - after[members], np.array((0.0, 0.0, -40.0)) * pixel, pixel)
    with claim("Esc puts everything back after a drag of another place, and of the handle"):
        for start, rows in ((on_screen(NOSE), 4), ((end[0], end[1] - 40), 2)):
            move(*start)
            yield from rest()
            yield from hold([start, *between(start, (start[0], start[1] + 60), 3)])
            assert len(left_behind()[0]) == rows
            above(apart(shown(), again), 0.01)
            press("ESC")
            yield
            release()
            yield from rest(3)
            assert left_behind() == ONE_HANDLE
            near(shown(), again, DRAGGED)
    with claim("a drag is one step of undo"):
        for step, left, shape in (
            (undo, ONE_HANDLE, after),
            (undo, NOTHING, before),
            (redo, ONE_HANDLE, after),
        ):
            yield from step()
            assert left_behind() == left
            near(shown(), shape, DRAGGED)
    yield from undo()
    bpy.ops.sinew.drag(**repeated)
    yield from rest(3)
    with claim("Adjust Last Operation repeats a drag"):
        assert left_behind() == ONE_HANDLE
        near(shown(), after, DRAGGED)


REGIONS = {
    "Ear.L": ("HANDLE", lambda point: point.x > 1.6),
    "Ear.R": ("HANDLE", lambda point: point.x < -1.6),
    "Muzzle": ("HANDLE", lambda point: point.z < -0.9 and point.y < -0.3),
    "Back": ("FIXED", lambda point: point.y > 0.35 and abs(point.x) < 1.2),
}
LIFT = 0.45
SLANTED = (0.0, 0.0, 0.383, 0.924)  # from behind and above
SPOTS = {  # in the middle of a region, or of a part that is free
    "ear": lambda x, y, z: x > 1.75,
    "back": lambda x, y, z: y > 0.7 and abs(x) < 0.8,
    "free": lambda x, y, z: abs(x) < 0.8 and -0.1 < y < 0.1,
}
SLACK = 0.04  # the viewport mixes in linear light and rounds to 8 bits; the oracle here does neither
STEADY = 0.002  # of the pixels: anti-aliasing is never twice the same
HEAVY_SHAPE = 0.04  # 1 % of the grid

# Where things are in the window, from its lower left corner, with the Properties editor made wide and high.
NAME, CONTROL, WEIGHT, SELECT, EYE, BESIDE = 970, 1080, 1166, 1198, 1217, 1252
FIRST_ROW, ROW = 376, 21
MOVE_UP, MOVE_DOWN = 305, 285
REBIND = (1215, 500)


def row(index: int) -> int:
    return FIRST_ROW - ROW * index


def names() -> list[str]:
    return [handle.name for handle in deformer().handles]


def properties() -> bpy.types.Area:
    return next(area for area in window().screen.areas if area.type == "PROPERTIES")


def mode(name: str) -> None:
    bpy.context.view_layer.objects.active = head()
    with in_view():
        bpy.ops.object.mode_set(mode=name)


def handles() -> Iterator[None]:
    """A posed head with three handles and a fixed region, seen from the front."""
    viewport().spaces.active.show_region_hud = False  # the panel for the last operation is in no picture
    new_head(2, REGIONS)
    deformer().handles[0].control.matrix_world.translation.z += LIFT
    deformer().handles[2].control.matrix_world.translation.x -= 0.3
    yield from look_from_front(distance=5.8, height=0.25)
    bpy.ops.ed.undo_push(message="Pose")
    yield from settled()
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


def overlay():
    return sys.modules[f"{MODULE}.ui.overlays.overlay"]


def look(name: str, **wanted: object) -> Iterator[None]:
    """Change settings as the panel does; a screenshot."""
    for setting, value in wanted.items():
        setattr(bpy.context.scene.sinew, setting, value)
    viewport().tag_redraw()
    yield from rest(3)
    screenshot(name)


def in_picture(vertex: int) -> Place:
    """Where a vertex appears in ``view_pixels``: column and row."""
    x, y = on_screen(shown()[vertex])
    return x - region().x, y - region().y


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


def redness(rgb: np.ndarray) -> float:
    return float(rgb[0] - rgb[2])


def overlays() -> Iterator[None]:
    """What each overlay paints is tested without a window; here it is drawn."""
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(obj != head())
    viewport().spaces.active.region_3d.view_rotation = SLANTED
    head().select_set(False)
    yield from look("off")
    spots = {name: in_picture(nearest(where)) for name, where in SPOTS.items()}

    def colour(picture: str, spot: str) -> np.ndarray:
        x, y = spots[spot]
        return view_pixels(picture)[y - 1 : y + 2, x - 1 : x + 2].mean(axis=(0, 1))

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
    preferences = bpy.context.preferences.addons[MODULE].preferences
    share = preferences.overlay_opacity
    with claim("regions have the colours of their swatches, over what the viewport shows without overlays"):
        for spot, linear in (("ear", deformer().handles[0].colour), ("back", preferences.overlay_fixed)):
            swatch = np.array(Color(linear).from_scene_linear_to_srgb())
            near(colour("regions", spot), (1.0 - share) * colour("off", spot) + share * swatch, SLACK)
    with claim("regions have the same colours in Edit Mode beside the wires"):
        near(colour("edit", "ear"), colour("regions", "ear"), SLACK)
    with claim("free parts keep their shading"):
        near(colour("regions", "free"), colour("off", "free"), 0.01)
    with claim("what is stretched is red, and what is rigid grey"):
        above(redness(colour("area", "stretched")), 0.2)
        assert abs(redness(colour("area", "ear"))) < 0.03
        assert redness(colour("off", "stretched")) < 0.02
    with claim("X-ray shows each place once: the far side of the ear does not add to the near side"):
        assert abs(redness(colour("regions", "ear")) - redness(colour("x-ray", "ear"))) < 0.08
    with claim("redraws without a change paint nothing"):
        painted = overlay().cache.computed
        for _ in range(4):
            yield from look("idle")
        assert overlay().cache.computed == painted
    with claim("overlays show while they are on"):
        yield from look("off-again", show_overlay=False)
        assert not overlay().is_drawing()
        above(differing("regions", "off", 0.02), 0.05)
        above(differing("area", "off", 0.02), 0.05)
        assert differing("off-again", "off", 0.02) < STEADY
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(False)
    yield from look_from_front(distance=5.8, height=0.25)
    bpy.context.view_layer.objects.active = head()
    yield from rest()


def disable() -> Iterator[None]:
    """With an overlay on; without the toolbar, which loses our tool."""
    viewport().spaces.active.show_region_toolbar = False
    yield from rest()
    yield from look("last", show_overlay=False)
    yield from look("last-regions", show_overlay=True, overlay="REGIONS")
    with claim("disabling the add-on clears the picture"):
        above(differing("last-regions", "last", 0.02), 10.0 * STEADY)
        addon_utils.disable(MODULE)
        yield from rest(3)
        screenshot("disabled")
        assert not overlay().is_drawing()
        assert differing("disabled", "last", 0.02) < STEADY


def wide_panel() -> Iterator[None]:
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


def use_and_select() -> Iterator[None]:
    posed = shown()
    with claim("the eye lets a region go and takes it back"):
        yield from click(EYE, row(0))
        yield from settled()
        assert not deformer().handles[0].enabled
        fallen = apart(shown(), posed)  # the ear falls back to where the rest of the head is
        assert abs(fallen - LIFT) < 0.1, fallen
        yield from click(EYE, row(0))
        yield from settled()
        assert deformer().handles[0].enabled
        near(shown(), posed, FLOAT32)
    with claim("the arrow selects the control alone"):
        yield from click(SELECT, row(1))
        yield from rest()
        assert [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()] == ["Head Ear.R"]


def weight() -> Iterator[None]:
    posed = shown()
    with claim("a dragged weight gives way, and undo brings it back"):
        yield from drag((WEIGHT, row(0)), (WEIGHT - 40, row(0)))
        yield from settled()
        assert 0.0 < deformer().handles[0].weight < 1.0
        above(apart(shown(), posed), 0.001)
        press("Z", ctrl=True)
        yield from settled()
        assert deformer().handles[0].weight == 1.0
        near(shown(), posed, FLOAT32)


def rename_and_order() -> Iterator[None]:
    posed, ordered = shown(), ["ear", "Ear.R", "Muzzle", "Back"]
    with claim("a region is renamed in place, and its group stays"):
        yield from click(NAME, row(0), ctrl=True)
        yield from rest()
        write("ear")
        yield
        press("RET")
        yield from rest()
        assert names() == ordered
        assert deformer().handles[0].vertex_group == "Ear.L"
    with claim("regions move up and down, and the shape stays"):
        yield from click(CONTROL, row(2))
        yield from rest()
        assert deformer().active_handle == 2
        for button, order in ((MOVE_UP, ["ear", "Muzzle", "Ear.R", "Back"]), (MOVE_DOWN, ordered)):
            yield from click(BESIDE, button)
            yield from settled()
            assert names() == order
            near(shown(), posed, FLOAT32)


def missing_control() -> Iterator[None]:
    """Deleted by the user; another picked in the list."""
    other = bpy.data.objects.new("Other", None)
    other.location = (1.0, 2.0, 3.0)
    bpy.context.scene.collection.objects.link(other)
    posed = shown()
    with claim("a deleted control leaves the region as it is"):
        yield from click(SELECT, row(0))
        yield from rest()
        move(*middle())
        press("X")
        yield from rest()
        press("RET")
        yield from settled()
        assert deformer().handles[0].control_missing
        near(shown(), posed, FLOAT32)
    screenshot("2-control-missing")
    with claim("another control is picked in the list"):
        yield from click(CONTROL, row(0))
        yield from rest(3)
        write("other")
        yield from rest()
        press("RET")
        yield from settled()
        assert deformer().handles[0].control == other
        near(shown(), posed, FLOAT32)
        other.location.z += 0.25
        yield from settled()
        rise = (shown() - posed)[:, 2].max()
        assert abs(rise - 0.25) < 1e-5, rise


def weights(group: int) -> dict[int, float]:
    """Of the vertices in a group, by index."""
    return {
        vertex.index: entry.weight
        for vertex in head().data.vertices
        for entry in vertex.groups
        if entry.group == group
    }


def paint() -> Iterator[None]:
    """A stroke of weight 0 over the lower half of the lifted ear."""
    posed = shown()
    mode("WEIGHT_PAINT")
    yield from click(SELECT, row(0))
    with claim("the list chooses the group that is painted"):
        assert head().vertex_groups.active.name == "Ear.L"
    unified = bpy.context.scene.tool_settings.unified_paint_settings
    unified.use_unified_weight = unified.use_unified_size = True
    unified.weight, unified.size = 0.0, 25
    bpy.context.scene.tool_settings.weight_paint.brush.strength = 1.0
    yield from rest()
    group = head().vertex_groups["Ear.L"].index
    held = weights(group)
    x, y = on_screen(posed[min(held, key=lambda index: posed[index][2])])
    with claim("a brush stroke takes effect when it ends"):
        yield from drag((x - 15, y + 5), (x + 15, y + 20), steps=6)
        yield from settled()
        above(sum(held.values()) - sum(weights(group).values()), 1.0)
        live = shown()
        above(apart(live, posed), 0.01)
        mode("OBJECT")
        with in_view():
            bpy.ops.sinew.bind()
        yield from settled()
        near(shown(), live, FLOAT32)


def subdivide_muzzle() -> Iterator[None]:
    """Some faces more, in Edit Mode, by Blender's own operator."""
    mode("EDIT")
    select(head(), lambda point: point.z < -0.9 and point.y < -0.6)
    with in_view():
        bpy.ops.mesh.subdivide()
    yield from rest()
    move(*middle())
    press("TAB")
    yield from settled()


def edit_topology() -> Iterator[None]:
    """Without Automatic Rebind the panel asks for a click; with it nobody has to."""

    def is_bound_anew() -> Iterator[float]:
        """How far the bound mesh is lifted."""
        yield from until(lambda: deformer().status_level == "INFO")
        assert deformer().status_level == "INFO"
        assert f"{len(base()):,} vertices" in deformer().status
        return float((shown() - base())[:, 2].max())

    with claim("new vertices show rest, and the button binds again"):
        yield from subdivide_muzzle()
        assert (deformer().status_level, deformer().status) == ("ERROR", "Topology changed - Rebind")
        assert (shown() == base().astype(np.float32)).all()
        screenshot("4-topology")
        yield from click(*REBIND)
        lifted = yield from is_bound_anew()
        assert abs(lifted - LIFT - 0.25) < 0.05, lifted
    with claim("automatic rebind needs no button"):
        count = len(base())
        deformer().auto_rebind = True
        yield from subdivide_muzzle()
        again = yield from is_bound_anew()
        above(len(base()), count)
        assert abs(again - lifted) < 0.01, again


def heavy_drag() -> Iterator[None]:
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
    before, here = shown(), middle()
    in_thread = unsettled = False
    move(*here)
    yield from rest()
    press("G")
    yield
    press("Z")
    for step in range(1, 13):
        move(here[0], here[1] + 8 * step)
        yield
        lift = float((shown() - before)[:, 2].max())
        in_thread |= binding().busy()
        unsettled |= deformer().uid in sessions().unsettled()
    press("LEFTMOUSE")
    yield from rest()
    with claim("a preview is marked until it is final"):
        assert sessions().is_refining(deformer().uid)
    screenshot("6-refining")
    yield from settled()
    with claim("a heavy drag is answered by a thread while the mouse still moves, and settles"):
        assert in_thread
        assert unsettled
        above(lift, 0.0)
        assert not sessions().unsettled()
        height = deformer().handles[1].control.matrix_world.translation.z
        above(height, 0.1)
        assert abs((shown() - before)[:, 2].max() - height) < 0.05
    with claim("undo of a heavy drag binds nothing and shows no preview"):
        factor, dragged = sessions().find(deformer().uid).bound.factor, shown()
        press("Z", ctrl=True)
        yield from until(lambda: apart(shown(), dragged) > 0.1)
        end, quiet = time.monotonic() + 120.0, 0
        while quiet < 5 and time.monotonic() < end:
            near(shown(), before, HEAVY_SHAPE)
            assert binding().job(deformer().uid) is None
            quiet = 0 if sessions().is_refining(deformer().uid) else quiet + 1
            yield
        assert sessions().find(deformer().uid).bound.factor is factor


run(drag_surface, handles)
