# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the registry, in Blender: a new row is tested unasked, on the rig of its kind of control.

Bind, pose, drag, frame, render, save, load, undo, switch, paint, and each of its parameters.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import pytest
from expected import Poses
from inside import dragging, factor_of, notes_of, settle
from mathutils import Matrix
from probe import render_points
from registry import METHODS, other_values
from rigs import rig as scenes
from rigs.kinds import HandleRig, rig_for

ITERATED = 1e-3  # where a pose differs in its last digit, an iterative method may stop a step earlier
PAINTABLE = [method for method in METHODS if method.paintable]
TURN = Matrix.Translation((0.1, -0.3, 0.6)) @ Matrix.Rotation(0.8, 4, (0.9, 0.2, 0.1))


@pytest.fixture(params=METHODS, ids=lambda method: method.id)
def rig(request: pytest.FixtureRequest) -> HandleRig:
    """Not bound."""
    rig = rig_for(request.param.id)
    rig.method = request.param
    rig.exactness = ITERATED if rig.method.iterative else max(scenes.MATRIX, rig.tolerance)
    return rig


@pytest.fixture
def expected(rig: HandleRig) -> Poses:
    """What to see of the rig, which is bound; its control is at rest."""
    return rig.start(rig.method.id).poses


def test_bind_offers_the_parameters_and_factor_0_shows_rest(rig: HandleRig, expected: Poses):
    deformer = rig.deformer
    assert (deformer.method, deformer.status_level) == (rig.method.id, "INFO"), deformer.status
    for parameter in rig.method.parameters:
        if parameter not in rig.method.references:  # whose values lie in other datablocks
            assert getattr(deformer.parameters, parameter.id) == pytest.approx(parameter.default)
    for parameter in rig.method.paintable:
        assert getattr(deformer.parameters, f"{parameter.id}_group") == ""
    assert scenes.close(rig.points(), expected.lifted(0.0), rig.tolerance)
    deformer.factor = 0.0
    assert scenes.close(rig.points(), rig.rest(), rig.tolerance)


def test_a_pose_is_that_of_a_native_object_made_anew(rig: HandleRig, expected: Poses):
    scenes.move_world(rig.control, TURN)
    assert scenes.close(rig.points(), expected.now(rig.obj, rig.control), rig.exactness)
    rig.control.matrix_basis = Matrix.Identity(4)
    assert scenes.close(rig.points(), expected.lifted(0.0), rig.tolerance)


def test_the_shape_does_what_everything_that_holds_it_does(rig: HandleRig):
    """Translations for every method; what else a kind of control carries over, its rig says.

    Where a method leaves alone what is far from its handles, this holds for these.
    """
    rig.bind_alone(rig.method.id)
    there = rig.held if rig.method.reproduces.value == "rest" else slice(None)
    before = rig.points()[there]
    scenes.move_world(rig.control, rig.carries)
    after = scenes.apply_matrix(rig.carries, before)
    assert np.abs(rig.points()[there] - after).max() < 2 * rig.tolerance * max(1.0, np.abs(after).max())


def test_each_parameter_reaches_the_native_object(rig: HandleRig):
    rig.bind(rig.method.id)
    anew = {
        (parameter.id, value): rig.expected(rig.method.id, **{parameter.id: value})
        for parameter in rig.method.parameters
        for value in other_values(parameter)
    }
    scenes.move_world(rig.control, TURN)
    for (name, value), expected in anew.items():
        before = getattr(rig.deformer.parameters, name)
        setattr(rig.deformer.parameters, name, value)
        shown = rig.points()
        assert rig.deformer.status_level == "INFO", (name, value, rig.deformer.status)
        assert scenes.close(shown, expected.now(rig.obj, rig.control), rig.exactness), (name, value)
        setattr(rig.deformer.parameters, name, before)


@pytest.mark.parametrize("rig", PAINTABLE, ids=lambda method: method.id, indirect=True)
def test_a_painted_parameter_changes_the_shape_where_it_is_painted_until_its_group_is_deleted(rig: HandleRig):
    """Then it has its plain value, and says so."""
    left = scenes.add_group(rig.obj, "Left", lambda point: point[0] < 0.0)
    rig.bind(rig.method.id)
    values, plain = rig.deformer.parameters, None
    for parameter in rig.method.paintable:
        group, value = f"{parameter.id}_group", max(parameter.default, 0.5)
        stiffness = np.full(len(rig.rest()), parameter.span.minimum)
        stiffness[left] = value
        rig.control.matrix_basis = Matrix.Identity(4)
        choice, among = parameter.only_with or (None, ())
        used = {choice: among[0]} if choice else {}
        expected = rig.expected(rig.method.id, **{parameter.id: stiffness}, **used)
        scenes.move_world(rig.control, TURN)
        plain = rig.points()
        before = {name: getattr(values, name) for name in (*used, parameter.id)}
        for name, option in (used | {parameter.id: value}).items():
            setattr(values, name, option)
        even = rig.points()
        setattr(values, group, "Left")
        painted = rig.points()
        assert rig.deformer.status_level == "INFO", rig.deformer.status
        assert np.abs(painted - even).max() > 1e-5, parameter.id
        assert scenes.close(painted, expected.now(rig.obj, rig.control), rig.exactness), parameter.id
        for name, option in (before | {group: ""}).items():
            setattr(values, name, option)
    for parameter in rig.method.paintable:
        setattr(values, f"{parameter.id}_group", "Left")
    assert not scenes.close(rig.points(), plain, 1e-5)
    rig.obj.vertex_groups.remove(rig.obj.vertex_groups["Left"])
    scenes.press(rig.obj, "bind")
    assert scenes.close(rig.points(), plain, rig.exactness)
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    said = "is not painted: vertex group 'Left' is not on the mesh - pick another"
    told = [note for note in notes_of(rig.deformer) if "not painted" in note]
    assert told == [f"{parameter.label} {said}" for parameter in rig.method.paintable]


def test_a_drag_makes_no_jump_and_settles_to_the_answer_reached_directly(rig: HandleRig, expected: Poses):
    shown = [rig.points()]
    with dragging():
        for share in (0.25, 0.5, 0.75, 1.0):
            rig.control.matrix_basis = Matrix.Identity(4).lerp(TURN, share)
            shown.append(rig.points())
        reach = np.abs(np.array(rig.control.matrix_world)[:3]).max() * 0.25
        settle()
    settled, basis = rig.points(), rig.control.matrix_basis.copy()
    steps = [np.abs(after - before).max() for before, after in pairwise(shown)]
    assert max(steps) < 2.0 * min(steps) + reach
    rig.control.matrix_basis = Matrix.Identity(4)
    assert np.array_equal(rig.points(), shown[0])
    rig.control.matrix_basis = basis
    assert np.array_equal(rig.points(), settled)


def test_a_frame_shows_its_pose_however_it_is_reached_and_so_does_a_render(rig: HandleRig, expected: Poses):
    """Directly, by scrubbing, and by a drag without keys; from rest at frame 1 to a turn at frame 20."""
    rig.control.rotation_mode, scene = "XYZ", bpy.context.scene
    rest = {"rotation_euler": (0.0, 0.0, 0.0), "location": (0.0, 0.0, 0.0)}
    scenes.key(rig.control, {1: rest, 20: {"rotation_euler": (1.4, 0.0, 0.0), "location": (0.05, -0.6, 0.7)}})
    shown = {}
    for frame in (1, 20, 3, 17, 14, 5, 12, 1, 19, 20, 14):
        scene.frame_set(frame)
        assert np.array_equal(rig.points(), shown.setdefault(frame, rig.points())), frame
    assert np.abs(shown[20] - shown[1]).max() > 0.5
    assert np.array_equal(render_points(rig.obj), shown[14])
    assert np.array_equal(rig.points(), shown[14])
    basis = rig.control.matrix_basis.copy()
    scene.frame_set(1)
    rig.control.animation_data_clear()
    for step in np.linspace(0.0, 1.0, 5):
        rig.control.matrix_basis = Matrix.Identity(4).lerp(basis, float(step))
        scenes.update()
    rig.control.matrix_basis = basis
    # the control's basis went through location and Euler angles in float32 once more
    assert np.abs(rig.points() - shown[14]).max() < 1e-4


def test_a_saved_pose_is_loaded_to_the_last_bit_and_lives_on(rig: HandleRig, expected: Poses, tmp_path: Path):
    rig.lift(0.5)
    before = rig.points()
    scenes.reopen(tmp_path / "rig.blend")
    assert np.array_equal(rig.points(), before)
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    rig.lift(0.5)
    assert scenes.close(rig.points(), expected.lifted(1.0), rig.exactness)


def test_undo_and_redo_of_a_move(rig: HandleRig, expected: Poses):
    scenes.push("bound")
    at_rest = rig.points()
    scenes.move_world(rig.control, TURN)
    scenes.push("moved")
    moved = rig.points()
    bpy.ops.ed.undo()
    assert np.array_equal(rig.points(), at_rest)
    bpy.ops.ed.redo()
    assert np.array_equal(rig.points(), moved)
    rig.control.matrix_basis = Matrix.Identity(4)
    rig.lift(0.5)  # and it goes on living
    assert scenes.close(rig.points(), expected.lifted(0.5), rig.exactness)


def switched_to(method: object) -> dict[str, object]:
    """Itself and the three after it, in a circle, of the same kind of control; one of each other kind."""
    alike = [other for other in METHODS if other.control is method.control]
    first = alike.index(method)
    near = [alike[(first + step) % len(alike)] for step in range(4)]
    other_kinds = {other.control: other for other in METHODS if other.control is not method.control}
    return {other.id: other for other in (*near, *other_kinds.values())}


def test_switching_to_other_methods_and_back_keeps_the_control(rig: HandleRig):
    """To those of the same kind of control their own shape; the others leave the rest until one is back."""
    rig.bind(rig.method.id)
    others = switched_to(rig.method).values()
    alike = {other.id: rig.expected(other.id) for other in others if other.control is rig.method.control}
    scenes.move_world(rig.control, TURN)
    shown, control = rig.points(), rig.control.name
    for other in others:
        scenes.push("before")
        rig.deformer.method = other.id
        after = rig.points()
        if other.id in alike:
            assert rig.deformer.status_level == "INFO", (other.id, rig.deformer.status)
            limit = ITERATED if other.iterative else rig.exactness
            assert scenes.close(after, alike[other.id].now(rig.obj, rig.control), limit), other.id
        else:
            assert scenes.close(after, rig.rest(), rig.tolerance), other.id
        scenes.push("switched")
        bpy.ops.ed.undo()
        assert np.array_equal(rig.points(), shown), other.id
        rig.deformer.method = other.id
        scenes.update()
        rig.deformer.method = rig.method.id
        assert np.array_equal(rig.points(), shown), other.id
    assert rig.control == bpy.data.objects[control]


def test_ten_poses_need_one_factor_and_where_nothing_changed_nothing_is_solved(
    rig: HandleRig, expected: Poses, monkeypatch: pytest.MonkeyPatch
):
    factor, calls = factor_of(rig.deformer), []
    for step in range(1, 11):
        rig.lift(0.05)
        assert scenes.close(rig.points(), expected.lifted(0.05 * step), rig.exactness)
    assert factor_of(rig.deformer) is factor
    monkeypatch.setattr(factor, "solve", lambda *_args, **_options: calls.append(1))
    for _ in range(3):
        rig.obj.update_tag()
        scenes.update()
    assert not calls


def test_unbind_shows_rest_and_bind_goes_on(rig: HandleRig, expected: Poses):
    rig.lift(0.5)
    before = rig.points()
    for operator in (bpy.ops.sinew.bind, bpy.ops.sinew.unbind):
        scenes.make_active(rig.obj)
        assert operator() == {"FINISHED"}
        assert np.array_equal(rig.points(), before if rig.deformer.is_bound else rig.rest())
    rig.relax()
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert scenes.close(rig.points(), rig.rest(), rig.tolerance)
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    rig.lift(0.25)
    lifted = rig.rest()[rig.held] + (0.0, 0.0, 0.25)
    assert scenes.close(rig.points()[rig.held], lifted, rig.tolerance)
