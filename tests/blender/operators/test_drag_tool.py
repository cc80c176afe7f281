# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool Sinew Drag: what it finds under the mouse, and what it drags that is no handle.

Viewports exist without a window, too. What begins with a press in one is in the sessions of ``tests/gui``.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from bpy_extras.view3d_utils import location_3d_to_region_2d
from inside import inner
from mathutils import Matrix, Vector
from mouse import event, front_view
from rigs.cages import ball
from rigs.kinds import RIGS
from rigs.point_objects import bezier, text
from rigs.puppets import figure
from rigs.rig import add_armature, grid_object, in_pose_mode, make_active, press, update
from rigs.sheet import Sheet
from situations import cage, lattice_around, skin, tools, wire


def pressed(context: bpy.types.Context, place: tuple[float, float, float]) -> tuple[str, object]:
    """What Automatic drags at a place of the world."""
    update()
    at = location_3d_to_region_2d(context.region, context.region_data, Vector(place))
    mouse = event("LEFTMOUSE", "PRESS", context.region.x + at.x, context.region.y + at.y)
    return inner.sinew_drag._Press(context, mouse).found()


def posing() -> None:
    in_pose_mode(figure(), "hip")


FAR = (0.9, 0.9, 0.0)  # of a plate, from what is in its middle
FOUND = {
    "a mesh": (grid_object, (0.2, 0.1, 0.0), "SURFACE"),
    "a text": (text, None, "POINTS"),
    "a curve": (bezier, None, "POINTS"),
    "nothing": (grid_object, (3.0, 3.0, 0.0), "POINTS"),
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
    update()
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
    posing() if where == "POSE" else grid_object()
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
    press(target, "tool_add", tool="drag", location=(0.0, 0.0, 0.0), outer=0.8)
    make_active(target)
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
    armature = add_armature(plate.obj)
    armature.pose.bones["low"].sinew.pin = True
    (head, tail) = inner.marks.pins(armature, np.array((0.0, 0.0, 1.0)))
    assert np.allclose([head[:-1].mean(axis=0), tail[:-1].mean(axis=0)], [(0, -1, 0), (0, 0, 0)], atol=1e-6)
    plate.bind()
    plate.lift(0.5)
    ((shown, rests),) = inner.marks.rests(plate.obj, plate.deformer)
    assert np.allclose(shown - rests, (0.0, 0.0, 0.5), atol=1e-5)
