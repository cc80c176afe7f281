# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool of the toolbar; overlays, handles in their list, weights by brush, new vertices, heavy drags."""

from collections.abc import Iterator

import addon_utils
import bpy
import installed
import numpy as np
from driving import above, apart, claim, near, rest, run, settled, until
from editing import select
from expected import members_of
from hand import between, click, drag, hold, keys, move, redo, release, undo, write
from inside import inner
from mathutils import Color, Euler, Vector
from rigs.rig import base_points, new_empty
from scenes import deformer, head, heavy_grid, shown, smooth_head
from window import (
    Place,
    differing,
    in_view,
    look_from_front,
    middle,
    on_screen,
    region,
    screenshot,
    units_per_pixel,
    view,
    view_pixels,
    viewport,
    window,
)

FLOAT32 = 2e-6  # of a head 4 units wide that is not dragged
DRAGGED = 4e-6

EAR = (1.7, 0.0, 0.35)  # as seen from the front
NOTHING = ([], [], 0, [])
ROWS = [("SUPPORT", "Free Area"), ("HANDLE", "Handle L")]
ONE_HANDLE = (ROWS, ["Free Area", "Handle L"], 1, ["Head Handle L"])


def left_behind() -> tuple:
    """What a drag makes."""
    rows = [(row.kind, row.name) for deformer in head().sinew.deformers for row in deformer.handles]
    empties = sorted(other.name for other in bpy.data.objects if other.type == "EMPTY")
    return rows, [group.name for group in head().vertex_groups], len(head().modifiers), empties


def drag_surface() -> Iterator[None]:
    """One ear up and out, in one go, and then further by the same handle."""
    smooth_head(1)
    look_from_front()
    with in_view():
        bpy.ops.wm.tool_set_by_id(name="sinew.drag")
    yield from rest()
    before, start, unit = shown(), on_screen(EAR), units_per_pixel()
    end, lower = (start[0] + 50, start[1] + 70), (start[0] + 50, start[1] + 30)
    with claim("F, Shift F and the wheel change radius and reach"):
        drag_settings, seen = bpy.context.scene.sinew.drag, []
        for presses, aside in ((("F",), 20), (("shift F",), 30), (("ctrl WHEELUPMOUSE",), 0)):
            yield from keys(*presses, at=start)
            move(start[0] + aside, start[1])
            yield from rest()
            if aside:
                yield from keys("LEFTMOUSE")
            seen.append((drag_settings.pixels, drag_settings.reach))
        assert seen[0][0] != 40
        assert seen[1][0] == seen[0][0]
        assert seen[1][1] != seen[0][1] == 4.0
        assert seen[2][0] > seen[1][0]
        assert not head().sinew.deformers
        drag_settings.pixels, drag_settings.reach = 40, 4.0
    with claim("a drag makes a handle that follows the mouse"):
        assert left_behind() == NOTHING
        move(start[0] - 2, start[1])
        yield
        move(*start)
        yield from rest(3)
        screenshot("drag-1-hover")
        yield from hold([start, *between(start, end)])
        screenshot("drag-2-dragging")
        yield
        yield from release()
        after = shown()
        assert left_behind() == ONE_HANDLE
        members, _weights = members_of(head(), "Handle L")
        above(len(members), 3)
        near(after[members] - before[members], np.array((50.0, 0.0, 70.0)) * unit, unit)
        moved = np.abs(after - before).max(axis=1) > 1e-5
        assert 0.01 < moved.mean() < 0.5
        assert not moved[before[:, 0] < 0.0].any()
        assert bpy.context.view_layer.objects.active.name == "Head Handle L"
        assert bpy.context.window_manager.operators[-1].bl_idname == "SINEW_OT_drag"
    yield from drag(end, lower)
    again = shown()
    with claim("the next drag there takes the same handle"):
        assert left_behind() == ONE_HANDLE
        near(again[members] - after[members], np.array((0.0, 0.0, -40.0)) * unit, unit)
    with claim("a drag is one step of undo"):
        ways = ((undo, ONE_HANDLE, after), (undo, NOTHING, before), (redo, ONE_HANDLE, after))
        for step, left, shape in ways:
            yield from step()
            assert left_behind() == left
            near(shown(), shape, DRAGGED)


REGIONS = {
    "Ear.L": ("HANDLE", lambda point: point[0] > 1.6),
    "Ear.R": ("HANDLE", lambda point: point[0] < -1.6),
    "Muzzle": ("HANDLE", lambda point: point[2] < -0.9 and point[1] < -0.3),
    "Back": ("FIXED", lambda point: point[1] > 0.35 and abs(point[0]) < 1.2),
}
LIFT = 0.45
SLANTED = (0.0, 0.0, 0.383, 0.924)  # from behind and above
ASIDE = Euler((1.15, 0.0, 1.15)).to_quaternion()  # for the manual: ears, muzzle and back at once
SPOTS = {  # in the middle of a region, or of a part that is free
    "ear": lambda x, y, z: x > 1.75,
    "back": lambda x, y, z: y > 0.7 and abs(x) < 0.8,
    "free": lambda x, y, z: abs(x) < 0.8 and -0.1 < y < 0.1,
}
SLACK = 0.04  # the viewport mixes in linear light and rounds to 8 bits; the oracle here does neither
STEADY = 0.002  # of the pixels: anti-aliasing is never twice the same

NAME, PICKER = 970, 1165
FIRST_ROW, ROW = 544, 21  # of the list; a line above it in Weight Paint, and a box while something is wrong
BOX = 78
REBIND = (1215, FIRST_ROW + 49)


def row(index: int) -> int:
    return FIRST_ROW - ROW * index


def properties() -> bpy.types.Area:
    return next(area for area in window().screen.areas if area.type == "PROPERTIES")


def mode(name: str) -> None:
    bpy.context.view_layer.objects.active = head()
    with in_view():
        bpy.ops.object.mode_set(mode=name)


def handles() -> Iterator[None]:
    """A posed head with three handles and a fixed region, seen from the front."""
    viewport().spaces.active.show_region_hud = False  # the panel for the last operation is in no picture
    smooth_head(2, REGIONS)
    deformer().handles[0].control.matrix_world.translation.z += LIFT
    deformer().handles[2].control.matrix_world.translation.x -= 0.3
    look_from_front(distance=5.8, height=0.25)
    bpy.ops.ed.undo_push(message="Pose")
    yield from settled()
    for step in (overlays, wide_panel, rename, missing_control, paint, edit_topology, heavy_drag, disable):
        yield from step()


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
    turn, points = view().view_matrix, shown()
    chosen = [vertex.index for vertex in head().data.vertices if where(*vertex.co)]
    return max(chosen, key=lambda index: (turn @ Vector(points[index])).z)


def most_stretched() -> int:
    """The vertex around which the area grew most, among those that the viewer sees from the front."""
    values = inner.result.measured(head(), deformer(), inner.distortion.Measure.AREA).values
    evaluated = head().evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    turn = view().view_matrix.to_3x3()
    return max(range(len(evaluated)), key=lambda i: values[i] * ((turn @ evaluated[i].normal).z > 0.8))


def redness(rgb: np.ndarray) -> float:
    return float(rgb[0] - rgb[2])


def overlays() -> Iterator[None]:
    """What each overlay paints is tested without a window; here it is drawn."""
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(obj != head())
    view().view_rotation = SLANTED
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
    preferences = bpy.context.preferences.addons[installed.name()].preferences
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
    with claim("overlays show while they are on"):
        yield from look("off-again", show_overlay=False)
        assert not inner.overlay.is_drawing()
        above(differing("regions", "off", 0.02), 0.05)
        above(differing("area", "off", 0.02), 0.05)
        assert differing("off-again", "off", 0.02) < STEADY
    view().view_rotation, view().view_distance = ASIDE, 4.6
    for wanted in ("REGIONS", "DISTORTION"):
        yield from look(f"aside-{wanted.lower()}", show_overlay=True, overlay=wanted)
    yield from look("aside-off", show_overlay=False)
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(False)
    look_from_front(distance=5.8, height=0.25)
    bpy.context.view_layer.objects.active = head()
    yield from rest()


def disable() -> Iterator[None]:
    """With an overlay on; without the toolbar, which loses our tool."""
    overlay = inner.overlay
    viewport().spaces.active.show_region_toolbar = False
    yield from rest()
    yield from look("last", show_overlay=False)
    yield from look("last-regions", show_overlay=True, overlay="REGIONS")
    with claim("disabling the add-on clears the picture"):
        above(differing("last-regions", "last", 0.02), 10.0 * STEADY)
        addon_utils.disable(installed.name())
        yield from rest(3)
        screenshot("disabled")
        assert not overlay.is_drawing()
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
    yield from rest()
    screenshot("1-panel")


def rename() -> Iterator[None]:
    with claim("a region is renamed in place, and its group stays"):
        yield from click(NAME, row(0), ctrl=True)
        write("ear")
        yield
        yield from keys("RET")
        assert [handle.name for handle in deformer().handles] == ["ear", "Ear.R", "Muzzle", "Back"]
        assert deformer().handles[0].vertex_group == "Ear.L"
    head().select_set(True)
    with claim("a click on a row selects its control alone"):
        yield from click(NAME, row(2))
        assert deformer().active_handle == 2
        selected = [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()]
        assert selected == ["Head Muzzle"], selected


def missing_control() -> Iterator[None]:
    """Deleted by the user; another picked in the list."""
    other, posed = new_empty("Other", (1.0, 2.0, 3.0)), shown()
    with claim("a deleted control leaves the region as it is"):
        yield from click(NAME, row(0))
        yield from keys("X", "RET", at=middle())
        yield from settled()
        assert deformer().handles[0].control_missing
        near(shown(), posed, FLOAT32)
    screenshot("2-control-missing")
    with claim("another control is picked in the list"):
        yield from click(PICKER, row(0) - BOX)
        yield
        write("other")
        yield from rest()
        yield from keys("RET")
        yield from settled()
        assert deformer().handles[0].control == other
        near(shown(), posed, FLOAT32)
        other.location.z += 0.25
        yield from settled()
        rise = (shown() - posed)[:, 2].max()
        assert abs(rise - 0.25) < 1e-5, rise


def paint() -> Iterator[None]:
    """A stroke of weight 0 over the lower half of the lifted ear."""
    posed = shown()
    mode("WEIGHT_PAINT")
    yield from click(NAME, row(0) - ROW)
    with claim("the list chooses the group that is painted"):
        assert head().vertex_groups.active.name == "Ear.L"
    unified = bpy.context.scene.tool_settings.unified_paint_settings
    unified.use_unified_weight = unified.use_unified_size = True
    unified.weight, unified.size = 0.0, 25
    bpy.context.scene.tool_settings.weight_paint.brush.strength = 1.0
    yield from rest()
    members, held = members_of(head(), "Ear.L")
    x, y = on_screen(posed[members[posed[members, 2].argmin()]])
    with claim("a brush stroke takes effect when it ends"):
        yield from drag((x - 15, y + 5), (x + 15, y + 20), steps=6)
        yield from settled()
        above(held.sum() - members_of(head(), "Ear.L")[1].sum(), 1.0)
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
    yield from keys("TAB", at=middle())
    yield from settled()


def edit_topology() -> Iterator[None]:
    """Without Automatic Rebind the panel asks for a click; with it nobody has to."""

    def is_bound_anew() -> Iterator[float]:
        """How far the bound mesh is lifted."""
        yield from until(lambda: deformer().status_level == "INFO")
        assert deformer().status_level == "INFO"
        assert f"{len(head().data.vertices):,} vertices" in deformer().status
        return float((shown() - base_points(head()))[:, 2].max())

    with claim("new vertices show rest, and the button binds again"):
        yield from subdivide_muzzle()
        assert (deformer().status_level, deformer().status) == ("ERROR", "Topology changed - Rebind")
        assert (shown() == base_points(head())).all()
        screenshot("4-topology")
        yield from click(*REBIND)
        lifted = yield from is_bound_anew()
        assert abs(lifted - LIFT - 0.25) < 0.05, lifted
    with claim("automatic rebind needs no button"):
        count = len(head().data.vertices)
        deformer().auto_rebind = True
        yield from subdivide_muzzle()
        again = yield from is_bound_anew()
        above(len(head().data.vertices), count)
        assert abs(again - lifted) < 0.01, again


def heavy_drag() -> Iterator[None]:
    """A thread answers while the mouse moves on."""
    bpy.data.objects.remove(head())
    with in_view():
        obj = heavy_grid("arap", size=4.0)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Left")
    bpy.context.view_layer.objects.active = obj  # and its control is selected, so that the panel stays
    yield from rest()
    properties().spaces.active.context = "MODIFIER"
    with in_view():
        bpy.ops.ed.undo_push(message="Before the heavy drag")
    view().view_rotation = (0.8, 0.53, 0.15, 0.24)
    before, (x, y) = shown(), middle()
    in_thread = unsettled = marked = False
    yield from keys("G", "Z", at=(x, y))
    for step in range(1, 13):
        move(x, y + 8 * step)
        yield
        lift = float((shown() - before)[:, 2].max())
        in_thread |= inner.binding.busy()
        unsettled |= deformer().uid in inner.sessions.unsettled()
        if not marked and inner.sessions.is_refining(deformer().uid):
            marked = True
            screenshot("6-refining")
    yield from keys("LEFTMOUSE")
    yield from settled()
    with claim("a preview is marked until it is final"):
        assert marked
        assert not inner.sessions.is_refining(deformer().uid)
    with claim("a heavy drag is answered by a thread while the mouse still moves, and settles"):
        assert in_thread
        assert unsettled
        above(lift, 0.0)
        assert not inner.sessions.unsettled()
        height = deformer().handles[1].control.matrix_world.translation.z
        above(height, 0.1)
        assert abs((shown() - before)[:, 2].max() - height) < 0.05


run(drag_surface, handles)
