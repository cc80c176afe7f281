# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool Sinew Drag: what it finds under the mouse, and what it drags that is no region of a mesh.

Handles at the very place are tested with each method that they move through space. Viewports exist without
a window, too. What begins with a press in one is in the sessions of ``tests/gui``.
"""

import bpy
import numpy as np
import pytest
from bpy_extras.view3d_utils import location_3d_to_region_2d
from inside import inner, notes_of
from mathutils import Euler, Matrix, Vector
from mouse import event, front_view
from registry import BY_ID, ON_HANDLE_POINTS
from rigs import rig as scenes
from rigs.cages import ball
from rigs.kinds import RIGS
from rigs.point_objects import CURVES, MAKERS, bezier, moved_by_hand, text
from rigs.puppets import figure
from rigs.sheet import Sheet
from seen import assert_seen, seen
from situations import cage, lattice_around, skin, tools, wire
from test_drag import LIFT, drag


def pressed(context: bpy.types.Context, place: tuple[float, float, float]) -> tuple[str, object]:
    """What Automatic drags at a place of the world."""
    scenes.update()
    at = location_3d_to_region_2d(context.region, context.region_data, Vector(place))
    mouse = event("LEFTMOUSE", "PRESS", context.region.x + at.x, context.region.y + at.y)
    return inner.sinew_drag._Press(context, mouse).found()


def posing() -> None:
    scenes.in_pose_mode(figure(), "hip")


FOUND = {
    "a mesh": (scenes.grid_object, (0.2, 0.1, 0.0), "SURFACE"),
    "a text": (text, None, "POINTS"),
    "a curve": (bezier, None, "POINTS"),
    "nothing": (scenes.grid_object, (3.0, 3.0, 0.0), "POINTS"),
    "a cage": (cage, (0.0, 0.0, 1.0), "CONTROL"),
    "a lattice": (lattice_around, (0.0, 0.0, 1.0), "CONTROL"),
    "a wire": (wire, None, "CONTROL"),
    "a tool": (tools, None, "CONTROL"),
    "a bone": (posing, None, "BONES"),
}


def some_place(obj: bpy.types.Object) -> Vector:
    """Where the active object, or the control of its deformer, can be pressed."""
    if obj.mode == "POSE":
        bone = obj.pose.bones["hip"]
        return obj.matrix_world @ (0.5 * (bone.head + bone.tail))
    control = obj.sinew.active.controls[0].object if obj.sinew.active else obj
    if control.type == "CURVE":
        return control.matrix_world @ control.data.splines[0].bezier_points[0].co
    if control.type == "FONT":
        mesh = control.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        face = max(mesh.polygons, key=lambda face: face.area)
        return control.matrix_world @ face.center
    return control.matrix_world.translation


@pytest.mark.parametrize("what", FOUND)
def test_automatic_finds(viewport, what: str) -> None:
    prepare, place, wanted = FOUND[what]
    prepare()
    scenes.update()
    found, held = pressed(viewport, place or some_place(bpy.context.object))
    assert found == wanted
    assert (held is None) == (what == "nothing")


def test_far_from_a_wire_or_a_tool_something_else_is_dragged(viewport) -> None:
    wire()
    obj = bpy.context.object
    obj.scale = (20.0, 20.0, 20.0)
    obj.sinew.active.controls[0].object.location.x += 15.0
    assert pressed(viewport, (0.0, 0.0, 0.0))[0] == "SURFACE"


HEADERS = {
    "AUTO": ["mode", "pixels", "reach", "unlimited"],
    "SURFACE": ["mode", "pixels", "reach", "unlimited"],
    "CLAY": ["mode", "pixels", "reach"],
    "POINTS": ["mode", "pixels"],
    "BONES": ["mode", "balance"],
}


@pytest.mark.parametrize("mode", HEADERS)
@pytest.mark.parametrize("where", ["OBJECT", "POSE"])
def test_a_button_takes_the_tool_in_its_mode(viewport, mode: str, where: str) -> None:
    posing() if where == "POSE" else scenes.grid_object()
    assert bpy.ops.sinew.drag_start(mode=mode) == {"FINISHED"}
    assert bpy.context.workspace.tools.from_space_view3d_mode(where).idname == "sinew.drag"
    sheet = Sheet()
    inner.drag_tool.SINEW_WT_drag.draw_settings(bpy.context, sheet, None)
    posed = ["balance"] * (mode == "AUTO") + ["use_mirror_x"] if where == "POSE" else []
    assert sheet.properties() == HEADERS[mode] + posed


def test_the_button_of_a_skin_poses_its_bones(viewport) -> None:
    skin()
    assert bpy.ops.sinew.drag_start(mode="BONES") == {"FINISHED"}
    assert (bpy.context.mode, bpy.context.object.name) == ("POSE", "Figure")


def test_the_reach_on_the_screen_is_that_of_the_header(scene) -> None:
    drag = scene.sinew.drag
    drag.pixels, drag.reach = 40, 2.0
    assert drag.reach_in_pixels == 80
    drag.reach_in_pixels = 200
    assert drag.reach == pytest.approx(5.0)


def test_points_are_held_beside_a_deformer_of_regions(plate) -> None:
    plate.bind("arap")
    for x, z in ((0.8, 0.0), (-0.8, 0.4)):
        bpy.ops.sinew.drag(origin=(x, 0.0, 5.0), value=(0.0, 0.0, z), radius=0.2, places=True)
    assert [row.method for row in plate.obj.sinew.deformers] == ["arap", "mls"]
    assert len(plate.deformer.handles) == 2


# What is no handle


@pytest.mark.parametrize("kind", ["cage", "lattice", "curves", "tools"])
def test_a_part_of_a_control_is_dragged(kind: str) -> None:
    rig = RIGS[kind].new()
    rig.bind_at_rest(rig.methods[0])
    rest, control = rig.points(), rig.control
    point = len(inner.own_shape.points_of(control)) // 2 or -1  # the whole object if it has no points
    control.matrix_world = Matrix.Scale(1.5, 4) @ control.matrix_world
    rig.press(f"{kind if kind in ('cage', 'lattice') else 'control'}_set_rest")
    before = inner.own_shape.points_of(control)
    moved = {"control": control.name, "point": point, "value": (0.0, 0.0, 0.3)}
    assert bpy.ops.sinew.control_drag(**moved) == {"FINISHED"}
    assert np.abs(rig.points() - rest).max() > 1e-3
    if point >= 0:
        apart = (inner.own_shape.points_of(control) - before) * 1.5
        assert np.allclose(apart[point], (0.0, 0.0, 0.3), atol=1e-5)
        assert not np.delete(apart, point, axis=0).any()
    rig.press("reset_pose")
    assert np.abs(rig.points() - rest).max() < 2e-6


def test_a_length_follows_the_mouse_along_its_direction(scene) -> None:
    target = ball()
    scenes.press(target, "tool_add", tool="drag", location=(0.0, 0.0, 0.0), outer=0.8)
    scenes.make_active(target)
    row, outcomes = target.sinew.active.controls[0], inner.grabbing.Outcome
    depsgraph = bpy.context.evaluated_depsgraph_get()
    tool = inner.reach_drag.ReachDragging(row, "outer", depsgraph, (0.0, 0.0))

    def send(kind: str, value: str, x: float, **modifiers: bool):
        return tool.process(target, event(kind, value, x, 50.0, **modifiers), front_view())

    send("MOUSEMOVE", "NOTHING", 20.0)
    assert row.outer == pytest.approx(1.0), "20 pixels along x, and none along z"
    send("MOUSEMOVE", "NOTHING", 40.0, shift=True)
    assert row.outer == pytest.approx(1.02)
    assert send("ESC", "PRESS", 40.0) is outcomes.CANCELLED
    assert row.outer == pytest.approx(0.8)
    assert send("LEFTMOUSE", "RELEASE", 40.0) is outcomes.CONFIRMED


def test_pins_and_riding_controls_are_marked(plate) -> None:
    armature = scenes.add_armature(plate.obj)
    armature.pose.bones["low"].sinew.pin = True
    (head, tail) = inner.marks.pins(armature, np.array((0.0, 0.0, 1.0)))
    assert np.allclose([head[:-1].mean(axis=0), tail[:-1].mean(axis=0)], [(0, -1, 0), (0, 0, 0)], atol=1e-6)
    plate.bind()
    plate.lift(0.5)
    ((shown, rests),) = inner.marks.rests(plate.obj, plate.deformer)
    assert np.allclose(shown - rests, (0.0, 0.0, 0.5), atol=1e-5)


MEETS = 2e-3  # of a plate 2 wide: what a cut-off or a smoothing may leave


@pytest.fixture(params=[name for name in ON_HANDLE_POINTS if not BY_ID[name].wraps])
def method(request: pytest.FixtureRequest) -> str:
    return request.param


def at(obj: bpy.types.Object, x: float, y: float) -> np.ndarray:
    """The shown place of a vertex that rests there."""
    index = int(np.argmin(np.linalg.norm(scenes.base_points(obj)[:, :2] - (x, y), axis=1)))
    return scenes.evaluated_points(obj)[index]


def names(obj: bpy.types.Object) -> list[str]:
    return [row.name for row in obj.sinew.active.handles]


def test_a_drag_makes_a_deformer_with_a_handle_at_the_place_and_the_next_one_takes_it(method: str):
    obj = scenes.grid_object(cells=20)
    control = drag(0.2, 0.3, method=method)
    (handle,) = obj.sinew.active.handles
    assert obj.sinew.active.method == method
    assert (handle.kind, handle.vertex_group, handle.control) == ("HANDLE", "", control)
    assert not obj.vertex_groups
    assert scenes.close(at(obj, 0.2, 0.3), np.array((0.2, 0.3, 0.5)), MEETS)
    assert np.array(control.matrix_world.translation) == pytest.approx((0.2, 0.3, 0.5), abs=1e-5)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert "Hold Still" not in " ".join(notes_of(obj.sinew.active))  # a click holds such a handle
    assert drag(0.2, 0.3, value=(0.1, 0.0, 0.2), method=method) == control
    assert len(names(obj)) == 1
    assert scenes.close(at(obj, 0.2, 0.3), np.array((0.3, 0.3, 0.7)), MEETS)


def test_a_second_handle_changes_nothing_until_it_is_dragged(method: str):
    """It rests where the surface rests, and is posed as the surface is."""
    obj = scenes.grid_object(cells=20)
    drag(-0.5, 0.0, method=method)
    drag(0.7, 0.6, value=(0.0, 0.0, 0.0), method=method)
    before = scenes.evaluated_points(obj)
    drag(-0.3, 0.1, value=(0.0, 0.0, 0.0), radius=0.05)  # on the slope
    assert len(names(obj)) == 3
    if BY_ID[method].reproduces.value == "rest":  # the least change keeps what is met already
        assert scenes.close(scenes.evaluated_points(obj), before, MEETS)
    assert scenes.close(at(obj, -0.5, 0.0), np.array((-0.5, 0.0, 0.5)), MEETS)
    assert scenes.close(scenes.evaluated_points(obj), before, 0.05)


def test_a_mirrored_drag_moves_both_sides(method: str):
    obj = scenes.grid_object(cells=20)
    scenes.press(obj, "deformer_add", method=method)
    obj.sinew.active.use_mirror_x = True
    drag(0.5, 0.3, value=(0.1, 0.0, 0.4))
    assert sorted(names(obj)) == ["Point.L", "Point.R"]
    assert scenes.close(at(obj, 0.5, 0.3), np.array((0.6, 0.3, 0.4)), MEETS)
    assert scenes.close(at(obj, -0.5, 0.3), np.array((-0.6, 0.3, 0.4)), MEETS)
    drag(0.0, 0.8, value=(0.0, 0.0, 0.0))
    assert sorted(names(obj)) == ["Point", "Point.L", "Point.R"], "one on the plane of symmetry"


def test_a_turned_and_scaled_object_is_dragged_in_the_world(method: str):
    obj = scenes.grid_object(cells=20)
    obj.matrix_world = Matrix.LocRotScale((1.0, 2.0, 0.5), Euler((0.3, 0.2, 0.5)), (1.5, 0.8, 1.2))
    scenes.update()
    place = obj.matrix_world @ Vector((0.25, 0.35, 0.0))  # the middle of a face
    control = drag(place.x, place.y, method=method, value=LIFT)
    assert (control.matrix_world.translation - place - Vector(LIFT)).length < 1e-4
    near = np.linalg.norm(scenes.base_points(obj)[:, :2] - (0.25, 0.35), axis=1) < 0.08
    shown = obj.matrix_world @ Vector(scenes.evaluated_points(obj)[near].mean(axis=0))
    assert near.sum() == 4
    assert (shown - place - Vector(LIFT)).length < 0.02  # a face is curved a little


KINDS = [kind for kind in MAKERS if kind != "nurbs"]  # a NURBS curve does not pass through its points


def middle_of_a_face(obj: bpy.types.Object) -> np.ndarray | None:
    """One that looks up; None for an object without faces."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if obj.type in ("CURVES", "POINTCLOUD", "LATTICE"):
        return None
    mesh = evaluated.to_mesh()
    places = [np.array(face.center) for face in mesh.polygons if face.normal.z > 0.5]
    evaluated.to_mesh_clear()
    return max(places, key=lambda place: place[2]) if places else None


@pytest.mark.parametrize("kind", KINDS)
def test_a_drag_takes_hold_of_curves_text_hair_and_clouds(kind: str):
    """On their surface, or at the point that is nearest to the line of sight, by a method that can do it."""
    obj = MAKERS[kind]()
    scenes.update()
    before = moved_by_hand(obj, lambda points: points)
    scenes.make_active(obj)
    place = middle_of_a_face(obj)
    place = before[np.argmax(before[:, 2])] if place is None else place
    control = drag(place[0], place[1])
    assert obj.sinew.active.method == "inverse_ffd"
    (handle,) = obj.sinew.active.handles
    assert handle.control == control
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    lifted = scenes.evaluated_points(obj) - before
    near = np.linalg.norm(before - place, axis=1)
    if kind in ("hair", "cloud", "lattice"):
        assert scenes.close(lifted[near < 1e-6], np.tile(LIFT, ((near < 1e-6).sum(), 1)), MEETS)
    # A curve moves by its points: a place half-way between two follows less.
    assert lifted[np.argmin(near), 2] > (0.2 if kind in CURVES else 0.3)
    assert np.abs(lifted).max() < 0.7
    assert drag(*control.matrix_world.translation[:2]) == control
    assert len(obj.sinew.active.handles) == 1


def test_a_surface_method_refuses_what_is_no_mesh():
    hair = MAKERS["hair"]()
    origin, before = (*scenes.evaluated_points(hair)[0][:2], 9.0), seen()
    scenes.refused("needs the surface of a mesh", "drag", origin=origin, value=LIFT, method="arap")
    assert_seen(before)
