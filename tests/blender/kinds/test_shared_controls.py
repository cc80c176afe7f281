# SPDX-License-Identifier: GPL-3.0-or-later
"""One control moves several objects: a cage around all that are selected, its faces, and common settings."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from inside import notes_of
from mathutils import Matrix
from registry import WITH_CAGE
from rigs import rig as scenes
from rigs.cages import TURN, assert_goes_on, ball, box, surround, transform
from rigs.point_objects import MAKERS, TESSELLATED, controls_of, has_surface, inside, moved_by_hand
from rigs.rig_of_curves import polyline


def scaled_ball(name: str, size: float, at: tuple = (0.0, 0.0, 0.0)) -> bpy.types.Object:
    obj = ball(name)
    obj.data.transform(Matrix.Translation(at) @ Matrix.Scale(size, 4))
    return obj


def clothed() -> list[bpy.types.Object]:
    """A body, a suit that stands off from it with loose buttons, and a hat; moved, turned, mirrored."""
    body, suit, hat = (
        scaled_ball(name, size, (0, 0, height))
        for name, size, height in (("Body", 1.0, 0.0), ("Suit", 1.25, 0.0), ("Hat", 0.3, 1.3))
    )
    scenes.make_active(suit, *(scaled_ball("Button", 0.03, (0.85 * x, 0.1, 0.1)) for x in (-1, 1)))
    assert bpy.ops.object.join() == {"FINISHED"}
    suit.scale = (-1.0, 1.0, 1.0)
    hat.location.y, hat.rotation_euler.x = 0.1, 0.2
    body.rotation_euler.z, body.scale = 0.3, (1.1, 1.1, 1.1)
    return [body, suit, hat]


def of_all_types() -> list[bpy.types.Object]:
    found = [ball("Body")]
    for index, maker in enumerate(MAKERS.values()):
        try:
            obj = maker()
        except pytest.skip.Exception:
            continue  # this Blender has no point clouds
        obj.location, obj.rotation_euler.z = (1.3 * (index % 4), 1.3 * (index // 4), 0.2), 0.1 * index
        found.append(obj)
    return found


def points_in(cage: bpy.types.Object, obj: bpy.types.Object) -> np.ndarray:
    points = (
        controls_of(obj) if obj.type == "CURVE" and not has_surface(obj) else scenes.evaluated_points(obj)
    )
    return scenes.apply_matrix(cage.matrix_world.inverted() @ obj.matrix_world, points)


@pytest.mark.parametrize(
    ("make", "method"), [*((clothed, method) for method in WITH_CAGE), (of_all_types, "positive_mean_value")]
)
def test_one_cage_holds_and_moves_all_that_is_selected(method: str, make: Callable):
    """Also with the methods that move nothing outside: with the default margin, nothing is."""
    objects = make()
    others, beside = box("Another Cage", 9.0), ball("Caged")
    surround(beside, others)
    rest = {obj.name: moved_by_hand(obj, lambda points: points) for obj in objects}
    scenes.make_active(objects[0], *objects[1:], others)
    assert bpy.ops.sinew.cage_add(method=method) == {"FINISHED"}
    assert not others.sinew.deformers, "what is a control itself is no target"
    cage = objects[0].sinew.active.cage
    assert bpy.context.object == cage
    for obj in objects:
        deformer = obj.sinew.active
        assert (deformer.cage, deformer.method, deformer.status_level) == (cage, method, "INFO"), (
            deformer.status
        )
        assert not [note for note in notes_of(deformer) if "outside" in note]
        assert inside(points_in(cage, obj), cage).all(), obj.name
        assert np.abs(scenes.evaluated_points(obj) - rest[obj.name]).max() < TESSELLATED
    scenes.move_world(cage, TURN)
    for obj in objects:
        motion = obj.matrix_world.inverted() @ TURN @ obj.matrix_world
        expected = moved_by_hand(obj, lambda points, motion=motion: scenes.apply_matrix(motion, points))
        assert np.abs(scenes.evaluated_points(obj) - expected).max() < 2 * TESSELLATED, obj.name
    for obj in objects:
        assert cage.name in bpy.data.objects
        name = cage.name
        scenes.press(obj, "deformer_remove")
    assert name not in bpy.data.objects, "the last one takes it away"


@pytest.mark.parametrize("add", ["cage_add", "lattice_add"])
@pytest.mark.parametrize("led_by", ["nothing", "a parent", "the active one"])
def test_a_control_around_several_follows_what_all_of_them_follow(add: str, led_by: str):
    body, hat = scaled_ball("Body", 1.0), scaled_ball("Hat", 0.3, (0, 0, 1.3))
    leader = {"nothing": None, "a parent": scenes.new_empty("Root", (1.0, 0.0, 0.0)), "the active one": body}[
        led_by
    ]
    between = scenes.new_empty("Between")
    if leader is not None:
        leader.rotation_euler.x = 0.4
        hat.parent, between.parent = between, leader
        body.parent = None if leader == body else leader
    scenes.update()
    scenes.make_active(body, hat)
    assert getattr(bpy.ops.sinew, add)() == {"FINISHED"}
    rest = [scenes.base_points(obj) for obj in (body, hat)]
    control = bpy.context.object
    assert control.parent == leader
    if leader is not None:
        leader.location, leader.rotation_euler.y = (1.0, 2.0, 3.0), 0.7
    for obj, points in zip((body, hat), rest):
        assert np.abs(scenes.evaluated_points(obj) - points).max() < 2e-5
    before = scenes.evaluated_points(hat)
    scenes.move_world(control, Matrix.Translation((0.0, 0.0, 0.5)))
    assert np.abs(np.linalg.norm(scenes.evaluated_points(hat) - before, axis=1) - 0.5).max() < scenes.MATRIX


@pytest.mark.parametrize("active", [0, 1])
def test_faces_of_a_shared_cage_can_be_changed(active: int):
    """One of two has grown: the new cage goes around it again."""
    objects = ball("Body"), scaled_ball("Suit", 1.25)
    objects[0].location.x, objects[1].location.x = 0.1, -0.2
    scenes.make_active(*objects)
    assert bpy.ops.sinew.cage_add(method="harmonic", faces=80, margin=0.05) == {"FINISHED"}
    cage = objects[0].sinew.active.cage
    objects[1 - active].data.transform(Matrix.Scale(1.4, 4))
    scenes.press(objects[active], "cage_faces", faces=40)
    assert len(cage.data.polygons) <= 41
    before = [scenes.evaluated_points(obj) for obj in objects]
    for obj, points in zip(objects, before, strict=True):
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
        assert inside(points_in(cage, obj), cage).all()
        assert scenes.close(points, scenes.base_points(obj), scenes.MATRIX)
    transform(cage, Matrix.Translation((0.0, 0.0, 0.3)))
    for obj, points in zip(objects, before, strict=True):
        assert scenes.close(scenes.evaluated_points(obj), points + (0.0, 0.0, 0.3), scenes.MATRIX)


def pull_a_vertex_out(obj: bpy.types.Object, cage: bpy.types.Object) -> None:
    obj.data.vertices[3].co.z = 5.0


def turn_inside_out(obj: bpy.types.Object, cage: bpy.types.Object) -> None:
    if obj.name == "Body":
        cage.data.flip_normals()


@pytest.mark.parametrize(
    ("break_it", "buttons"),
    [(turn_inside_out, ["cage_flip"]), (pull_a_vertex_out, ["cage_outside_follow", "settings_share"])],
)
def test_one_button_mends_all_targets_of_a_cage(break_it: Callable, buttons: list[str]):
    """A flip turns the cage once; those that are refused because of what is outside are bound."""
    objects, cage = (ball("Body"), ball("Suit")), box()
    for obj in objects:
        break_it(obj, cage)
        assert surround(obj, cage, "harmonic").status_level == "ERROR"
    for button in buttons:
        scenes.press(objects[0], button)
    for obj in objects:
        assert_goes_on(obj, cage)


def with_cage(first: bpy.types.Object, second: bpy.types.Object) -> bpy.types.Object:
    cage = box()
    for obj in (first, second):
        surround(obj, cage)
    deformer = first.sinew.active
    deformer.method = "green"
    deformer.green.faces = "quads"
    return cage


def with_lattice(first: bpy.types.Object, second: bpy.types.Object) -> bpy.types.Object:
    scenes.make_active(first, second)
    assert bpy.ops.sinew.lattice_add() == {"FINISHED"}
    first.sinew.active.parameters.basis = "bezier"
    return first.sinew.active.controls[0].object


def with_wire(first: bpy.types.Object, second: bpy.types.Object) -> bpy.types.Object:
    wire = polyline(np.array([(-0.6, 0.0, 0.5), (0.0, 0.0, 0.6), (0.6, 0.0, 0.5)]), "Wire")
    for obj in (first, second):
        scenes.press(obj, "wire_add", curve=wire.name, radius=0.4)
    first.sinew.active.controls[0].radius = 0.9
    return wire


def with_tool(first: bpy.types.Object, second: bpy.types.Object) -> bpy.types.Object:
    tool = scenes.new_empty("Tool", (0.0, 0.0, 0.6))
    for obj in (first, second):
        scenes.press(obj, "tool_add", control=tool.name, outer=0.5)
    first.sinew.active.controls[0].outer = 1.0
    return tool


SHARES = {
    with_cage: "cage_set_rest",
    with_lattice: "lattice_set_rest",
    with_wire: "control_set_rest",
    with_tool: "control_set_rest",
}


@pytest.mark.parametrize(("share", "rest"), SHARES.items())
def test_all_targets_of_a_control_can_get_the_same_settings_and_rest(share: Callable, rest: str):
    """Twins at one place show the same shape then. Those that rest move on from there."""
    twins = ball("First"), ball("Second")
    control = share(*twins)
    twins[0].sinew.active.factor = 0.5
    scenes.update()
    control.rotation_euler.x, control.location.z = 0.5, control.location.z + 0.3
    assert not scenes.close(scenes.evaluated_points(twins[0]), scenes.evaluated_points(twins[1]), 0.02)
    scenes.press(twins[0], "settings_share")
    assert np.abs(scenes.evaluated_points(twins[1]) - scenes.base_points(twins[1])).max() > 0.02
    assert scenes.close(scenes.evaluated_points(twins[0]), scenes.evaluated_points(twins[1]))
    scenes.press(twins[1], rest)
    for obj in twins:
        assert scenes.close(scenes.evaluated_points(obj), scenes.base_points(obj), scenes.MATRIX), obj.name
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    control.location.z += 0.2
    for obj in twins:
        assert np.abs(scenes.evaluated_points(obj) - scenes.base_points(obj)).max() > 0.02, obj.name
    alone = ball("Alone")
    surround(alone, box("Own"))
    scenes.make_active(alone)
    assert not bpy.ops.sinew.settings_share.poll()


def test_an_object_without_points_gets_no_cage_and_says_so():
    body, nothing = ball("Body"), scenes.new_object("Nothing", [])
    scenes.make_active(body, nothing)
    assert bpy.ops.sinew.cage_add(faces=80) == {"FINISHED"}
    cage = body.sinew.active.cage
    assert "no vertices" in nothing.sinew.active.status
    before = scenes.evaluated_points(body)
    transform(cage, Matrix.Translation((0.0, 0.0, 0.3)))
    assert scenes.close(scenes.evaluated_points(body), before + (0.0, 0.0, 0.3), 2 * scenes.FLOAT32)
