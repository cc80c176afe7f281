# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew Drag by its properties, as scripts and Adjust Last Operation call it, and by events of a mouse."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from editing import placed_object
from inside import finish, inner, use_threads
from libraries import override, put_into_a_library, read
from mathutils import Matrix
from mouse import event
from rigs import rig as scenes
from seen import assert_seen, seen

LIFT = (0.0, 0.0, 0.5)


def drag(x: float = 0.0, y: float = 0.0, z: float = 5.0, **keywords) -> bpy.types.Object:
    """Press on what is below a point, drag and release; the control."""
    keywords = {"value": LIFT, "radius": 0.25, "reach": 2.0, **keywords}
    assert bpy.ops.sinew.drag(origin=(x, y, z), **keywords) == {"FINISHED"}
    scenes.update()
    return bpy.context.object


def grabbed(obj: bpy.types.Object) -> list[str]:
    return [row.vertex_group for row in obj.sinew.active.handles if row.kind == "HANDLE"]


def test_a_handle_is_made_where_one_presses_and_the_rest_stays():
    obj = scenes.grid_object(cells=20)
    rest = scenes.base_points(obj)
    control = drag()
    handles = obj.sinew.active.handles
    assert [(row.kind, row.name) for row in handles] == [("SUPPORT", "Free Area"), ("HANDLE", "Handle")]
    assert handles[1].control == control
    distance = np.linalg.norm(rest[:, :2], axis=1)
    assert set(scenes.members(obj, grabbed(obj)[0])) == set(np.flatnonzero(distance <= 0.25 + 1e-6))
    shown = scenes.evaluated_points(obj)
    assert scenes.close(shown[distance <= 0.25], rest[distance <= 0.25] + LIFT)
    assert scenes.close(shown[distance > 0.5], rest[distance > 0.5])
    between = shown[(distance > 0.27) & (distance < 0.45), 2]
    assert 1e-3 < between.min() <= between.max() < 0.5
    assert scenes.close(scenes.base_points(obj), rest)


def test_the_same_place_is_dragged_on_and_another_place_gets_another_handle():
    """Neighbouring handles share no vertex."""
    obj = scenes.grid_object(cells=20)
    rest = scenes.base_points(obj)
    first = drag(-0.5)
    assert drag(-0.5, value=(0.1, 0.0, 0.0)) == first
    assert drag(0.5, value=(0.0, 0.0, -0.3)) != first
    rows = [row.name for row in obj.sinew.active.handles if row.kind == "HANDLE"]
    assert rows == ["Handle R", "Handle L"]
    shown, one, other = (
        scenes.evaluated_points(obj),
        scenes.members(obj, grabbed(obj)[0]),
        scenes.members(obj, grabbed(obj)[1]),
    )
    assert scenes.close(shown[one], rest[one] + (0.1, 0.0, 0.5))
    assert scenes.close(shown[other], rest[other] + (0.0, 0.0, -0.3))
    drag(0.8, value=(0.0, 0.0, 0.2))
    assert not set(scenes.members(obj, grabbed(obj)[1])) & set(scenes.members(obj, grabbed(obj)[2]))
    assert obj.sinew.active.is_bound
    assert len(obj.sinew.deformers) == 1


def test_a_click_makes_a_handle_that_stays_and_holds_the_rest():
    """The whole surface without anything that holds it moves in one piece."""
    obj = scenes.grid_object(cells=20)
    rest = scenes.base_points(obj)
    drag(-0.8, value=(0.0, 0.0, 0.0), unlimited=True)
    assert scenes.close(scenes.evaluated_points(obj), rest)
    drag(-0.8, unlimited=True)
    assert scenes.close(scenes.evaluated_points(obj), rest + LIFT)
    drag(0.8, value=(0.0, 0.0, 0.3), unlimited=True)
    shown = scenes.evaluated_points(obj)
    for group, height in zip(grabbed(obj), (0.5, 0.8), strict=True):
        held = scenes.members(obj, group)
        assert scenes.close(shown[held], rest[held] + (0.0, 0.0, height))
    assert {row.kind for row in obj.sinew.active.handles} == {"HANDLE"}


def test_regions_of_the_artist_hold_the_rest():
    obj = scenes.grid_object(cells=20)
    scenes.add_group(obj, "Base", lambda point: point[0] < -0.7)
    scenes.press(obj, "handle_add", kind="FIXED", vertex_group="Base")
    drag(0.8)
    assert [row.kind for row in obj.sinew.active.handles] == ["FIXED", "HANDLE"]


def test_the_region_goes_along_the_surface_and_not_through_a_thin_limb():
    """A thin plate: its lower side is nearer than the radius, but not over the surface."""
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    obj = bpy.context.object
    obj.data.transform(Matrix.Diagonal((1.0, 1.0, 0.02, 1.0)))
    scenes.on_all(obj, bpy.ops.mesh.subdivide, number_cuts=31)
    drag(0.1, 0.1)
    assert (scenes.base_points(obj)[scenes.members(obj, grabbed(obj)[0]), 2] > 0.0).all()
    drag(0.1, 0.1, -5.0, direction=(0.0, 0.0, 1.0), value=(0.0, 0.0, -0.2))
    assert (scenes.base_points(obj)[scenes.members(obj, grabbed(obj)[1]), 2] < 0.0).all()


def test_the_side_that_is_seen_is_taken_also_where_a_vertex_of_the_other_one_is_nearer():
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    below = [(x, y, -0.02) for x, y in (*corners, (0.0, 0.0))]
    faces = [(0, 1, 2, 3), (8, 5, 4), (8, 6, 5), (8, 7, 6), (8, 4, 7)]
    obj = scenes.new_object("Sheet", [(x, y, 0.0) for x, y in corners] + below, faces)
    drag(0.1, 0.1)
    assert set(scenes.members(obj, grabbed(obj)[0])) == {2}


def test_a_placed_object_moves_by_the_numbers_of_the_world():
    obj = placed_object(cells=16)
    world = scenes.apply_matrix(obj.matrix_world, scenes.base_points(obj))
    place, normal = world[8 * 17 + 8], obj.matrix_world.inverted().transposed().to_3x3().col[2]
    drag(*(place + np.array(normal)), direction=-normal, value=(0.1, 0.2, 0.3), reach=1.5)
    chosen = scenes.members(obj, grabbed(obj)[0])
    assert set(chosen) == set(np.flatnonzero(np.linalg.norm(world - place, axis=1) <= 0.25))
    shown = scenes.apply_matrix(obj.matrix_world, scenes.evaluated_points(obj))
    assert scenes.close(shown[chosen], world[chosen] + (0.1, 0.2, 0.3), 2e-5)


def test_a_turn_is_about_the_place_that_was_pressed():
    obj = scenes.grid_object(cells=20)
    rest = scenes.base_points(obj)
    drag(0.1, mode="ROTATE", angle=0.6, axis=(0.0, 0.0, 1.0))
    chosen = scenes.members(obj, grabbed(obj)[0])
    place = Matrix.Translation((0.1, 0.0, 0.0))
    around = place @ Matrix.Rotation(0.6, 4, "Z") @ place.inverted()
    assert scenes.close(scenes.evaluated_points(obj)[chosen], scenes.apply_matrix(around, rest[chosen]), 1e-5)


@pytest.mark.parametrize("kind", ["SUBSURF", "MULTIRES", "MIRROR", "SOLIDIFY"])
def test_on_the_surface_that_modifiers_make(kind: str):
    """The place pressed is found on the mesh itself, wherever the modifiers show it."""
    obj = scenes.grid_object(cells=20)
    scenes.add_key(obj, "Aside", Matrix.Translation((1.0, 0.0, 0.0))).value = 1.0
    obj.modifiers.new("Made", kind)
    drag(1.5, 0.5)
    chosen = scenes.members(obj, grabbed(obj)[0])
    assert np.abs(scenes.base_points(obj)[chosen, :2].mean(axis=0) - 0.5).max() < 0.06
    assert obj.sinew.active.is_bound
    assert (obj.modifiers[-1].name == "Made") == (kind == "SUBSURF")


def test_a_mesh_too_coarse_for_the_handle_is_dragged_behind_its_subdivision():
    obj = scenes.grid_object(cells=2)
    scenes.subdivided(obj, 3)
    drag(0.1)
    assert [modifier.type for modifier in obj.modifiers] == ["SUBSURF", "NODES"]


@pytest.mark.parametrize(("x", "alone"), [(0.1, False), (0.0, True)])
def test_loose_parts_follow_what_they_lie_on_or_move_alone_where_they_are_pressed(x: float, alone: bool):
    obj = scenes.grid_object(cells=20)
    bpy.ops.mesh.primitive_cube_add(size=0.05, location=(0.0, 0.0, 0.03))
    scenes.make_active(obj, bpy.context.object)
    bpy.ops.object.join()
    rest = scenes.base_points(obj)
    drag(x)
    moved = scenes.evaluated_points(obj) - rest
    assert np.abs(moved[-8:] - LIFT).max() < (scenes.FLOAT32 if alone else 0.05)
    assert scenes.close(moved[:-8], np.zeros((len(rest) - 8, 3))) == alone


def test_a_bone_that_moves_the_region_is_dragged():
    obj = scenes.grid_object(cells=20)
    tip_of(obj)
    scenes.make_active(obj)
    drag(0.9)
    tip = scenes.members(obj, "Tip")
    assert scenes.close(scenes.evaluated_points(obj)[tip], scenes.base_points(obj)[tip] + LIFT, 1e-5)


MOTIONS = {
    "location": {"value": (0.1, 0.2, 0.3)},
    "rotation_euler": {"mode": "ROTATE", "angle": 0.7, "axis": (1.0, 2.0, 3.0)},
    "scale": {"mode": "RESIZE", "scale": (1.2, 1.3, 1.4)},
}
MOTIONS |= dict.fromkeys(("rotation_quaternion", "rotation_axis_angle"), MOTIONS["rotation_euler"])


def numbers(mover, kind: str, by_angles: bool) -> np.ndarray:
    """Those of which some are locked: of a rotation in another mode, Euler angles may stand for them."""
    return np.array(mover.matrix_basis.to_euler() if by_angles else getattr(mover, kind))


@pytest.mark.parametrize("of_bone", [False, True])
@pytest.mark.parametrize("by_angles", [False, True])
@pytest.mark.parametrize("kind", MOTIONS)
def test_locked_channels_of_a_control_stay(of_bone: bool, kind: str, by_angles: bool):
    obj, four = scenes.grid_object(cells=8), kind in ("rotation_quaternion", "rotation_axis_angle")
    if by_angles and not four:
        pytest.skip("these are the numbers themselves")
    mover = tip_of(obj) if of_bone else drag(0.9, value=(0.0, 0.0, 0.0))
    mover.rotation_mode = kind.removeprefix("rotation_").upper() if four else "XYZ"
    mover.lock_rotations_4d = not by_angles
    scenes.update()
    was, basis = numbers(mover, kind, by_angles), mover.matrix_basis.copy()
    found = []
    for lock in (False, True):
        for axis in (0, 2):
            getattr(mover, f"lock_{kind.partition('_')[0]}")[axis] = lock
        scenes.make_active(obj)
        drag(0.9, **MOTIONS[kind])
        found.append(numbers(mover, kind, by_angles))
        mover.matrix_basis = basis
        scenes.update()
    free, held = found
    locked = np.array((False, True, False, True) if len(was) == 4 else (True, False, True))
    assert (np.abs(free - was) > 1e-3).all()
    assert scenes.close(held[locked], was[locked], 1e-6)
    assert scenes.close(held[~locked], free[~locked], 1e-6)


def tip_of(obj: bpy.types.Object) -> bpy.types.PoseBone:
    """A bone that moves the right end, while the left one stays."""
    scenes.add_group(obj, "Tip", lambda point: point[0] > 0.7)
    scenes.add_group(obj, "Base", lambda point: point[0] < -0.7)
    armature = scenes.new_armature(Bone=((0.8, 0.0, 0.0), (1.0, 0.1, 0.2)))
    scenes.press(obj, "handle_add", kind="FIXED", vertex_group="Base")
    scenes.press(obj, "handle_add", vertex_group="Tip", control_object=armature.name, bone="Bone")
    return armature.pose.bones["Bone"]


def test_automatic_keyframes_are_inserted(monkeypatch: pytest.MonkeyPatch):
    obj = scenes.grid_object(cells=12)
    monkeypatch.setattr(bpy.context.scene.tool_settings, "use_keyframe_insert_auto", True)
    control = drag(value=(0.0, 0.0, 0.0))
    assert control.animation_data is None
    drag()
    shape = scenes.evaluated_points(obj)
    assert {curve.data_path for curve in scenes.curves_of(control)} == {"location"}
    bpy.context.scene.frame_set(7)
    assert scenes.close(scenes.evaluated_points(obj), shape)


# What is refused


def refuses(match: str, x: float) -> None:
    before = seen()
    scenes.refused(match, "drag", origin=(x, 0.0, 5.0), value=LIFT)
    assert_seen(before)


def test_what_is_linked(tmp_path: Path):
    path = put_into_a_library(tmp_path / "library.blend", scenes.grid_object())
    scenes.linked(read(path, True, "objects", "Plate"))
    refuses("linked - make a library override", 0.0)


def test_an_override_has_handles_that_can_be_dragged_and_takes_no_others(tmp_path: Path):
    obj = scenes.grid_object(cells=12)
    control = drag(0.5, value=(0.0, 0.0, 0.0))
    obj = override(put_into_a_library(tmp_path / "library.blend", obj, control))
    for collection in [each for each in bpy.context.scene.collection.children if each.library]:
        bpy.context.scene.collection.children.unlink(collection)
    scenes.update()
    drag(0.5)
    assert scenes.evaluated_points(obj)[:, 2].max() == pytest.approx(0.5, abs=1e-5)
    refuses("The mesh of Plate is linked", -0.5)


def test_what_is_displayed_as_wire_is_seen_through():
    obj = scenes.grid_object(cells=12)
    bpy.ops.mesh.primitive_cube_add(size=4.0)
    bpy.context.object.display_type = "WIRE"
    drag()
    assert len(obj.sinew.deformers) == 1


# By events


class Finger:
    """A press on the middle of a plate that is seen from above, where a pixel is a centimetre."""

    def __init__(self, obj: bpy.types.Object, place=(0.0, 0.0, 0.0), wait: bool = True) -> None:
        typed = inner.typed_motion
        self.obj, self.outcomes = obj, inner.dragging.Outcome
        self.x, self.y = 500.0, 300.0
        self.view = typed.View(*np.eye(3), pixel=0.01, centre=(500.0, 300.0))
        hit = inner.surface.Hit(obj, np.array(place), np.array((0.0, 0.0, 1.0)))
        brush = inner.drag.Brush("arap", 0.25, 0.5)
        self.drag = inner.drag.Drag(hit, bpy.context.evaluated_depsgraph_get(), brush, wait)
        motion = typed.TypedMotion(typed.Mode.TRANSLATE, self.view, np.eye(3), (self.x, self.y))
        self.tool = inner.dragging.Dragging(self.drag, motion, np.array(place), np.eye(3))

    def send(self, kind: str, value: str = "PRESS"):
        return self.tool.process(self.obj, event(kind, value, self.x, self.y), self.view)

    def move(self, x: float, y: float):
        self.x, self.y = self.x + x, self.y + y
        return self.send("MOUSEMOVE", "NOTHING")


@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
@pytest.mark.parametrize("before", ["nothing", "another deformer", "the handle"])
def test_cancel_leaves_nothing_behind(key: str, before: str):
    obj = scenes.grid_object(cells=16)
    if before == "another deformer":
        scenes.add_group(obj, "Base", lambda point: point[0] < -0.7)
        scenes.press(obj, "handle_add", kind="FIXED", vertex_group="Base")
    elif before == "the handle":
        drag(value=(0.1, 0.0, 0.2))
    scenes.make_active(obj)

    def told() -> list[str]:
        return [inner.status.current(row.uid).text.split(", bound")[0] for row in obj.sinew.deformers]

    was, shape, status = seen(), scenes.evaluated_points(obj), told()
    finger = Finger(obj, (0.1, 0.0, 0.2) if before == "the handle" else (0.0, 0.0, 0.0))
    assert finger.drag.is_new == (before != "the handle")
    finger.move(20, 40)
    finger.send("R")
    finger.move(5, 5)
    assert not scenes.close(scenes.evaluated_points(obj), shape)
    assert finger.send(key) is finger.outcomes.CANCELLED
    assert_seen(was)
    assert told() == status


@pytest.mark.parametrize("key", ["LEFTMOUSE", "ESC"])
def test_a_heavy_mesh_is_bound_by_a_thread(monkeypatch: pytest.MonkeyPatch, key: str):
    use_threads(monkeypatch)
    obj = scenes.grid_object(cells=30)
    scenes.update()
    rest, was = scenes.base_points(obj), seen()
    finger = Finger(obj, wait=False)
    assert finger.tool.job is not None
    finger.move(20, 10)
    finger.send(key, "RELEASE" if key == "LEFTMOUSE" else "PRESS")
    if key == "ESC":
        assert finger.tool.job is None
        assert_seen(was)
        return
    assert finish()
    chosen = scenes.members(obj, grabbed(obj)[0])
    assert scenes.close(scenes.evaluated_points(obj)[chosen], rest[chosen] + (0.2, 0.1, 0.0))
