# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of a drag: what they show at once, and the final answer after them, in threads too."""

import math

import bpy
import numpy as np
import pytest
from inside import catch_up, dragging, evaluated_by, factor_of, inner, use_threads
from mathutils import Matrix
from registry import WITH_HANDLES
from rigs.rig import Rig, evaluated_points, move_world, push, update
from rigs.sheet import draw_panel


@pytest.fixture
def dragged(plate: Rig):
    """A plate in the middle of a drag: what a window's handler shows before the pause."""
    plate.bind("arap")
    with evaluated_by(None):
        turn = Matrix.Rotation(math.radians(110.0), 4, "X")
        move_world(plate.control, Matrix.Translation((0.0, -0.6, 0.9)) @ turn)
        inner.evaluate.update(bpy.context.evaluated_depsgraph_get(), preview=True)
        update()
    return plate


def final_points(plate: Rig) -> np.ndarray:
    """The answer for the same pose, reached without any preview."""
    basis = plate.control.matrix_basis.copy()
    plate.control.matrix_basis = Matrix.Identity(4)
    update()
    plate.control.matrix_basis = basis
    return plate.points()


def session_of(plate: Rig):
    return inner.sessions.find(plate.deformer.uid)


def wait_for_work(plate: Rig) -> None:
    session_of(plate).work.thread.join(timeout=20.0)


def test_a_drag_shows_a_preview_and_settles_to_the_final_answer(dragged: Rig):
    assert inner.sessions.unsettled() == [dragged.deformer.uid]
    preview = evaluated_points(dragged.obj)
    assert np.abs(preview - dragged.rest())[dragged.top].max() > 0.5  # handles follow at once
    assert inner.evaluate.settle()
    settled = dragged.points()
    assert not inner.sessions.unsettled()
    assert np.array_equal(settled, final_points(dragged))


@pytest.mark.parametrize("newer", [False, True])
def test_a_heavy_mesh_settles_in_a_thread(dragged: Rig, monkeypatch: pytest.MonkeyPatch, newer: bool):
    """A newer pose drops what is under way; without a window that is solved to the end."""
    use_threads(monkeypatch)
    inner.evaluate.settle()
    update()
    if newer:
        dragged.lift(0.1)
        assert session_of(dragged).work is None
    else:
        wait_for_work(dragged)
        catch_up()
    settled = dragged.points()
    assert not inner.binding.busy()
    assert not inner.sessions.unsettled()
    monkeypatch.undo()
    assert np.array_equal(settled, final_points(dragged))


def watched_until_final(plate: Rig) -> list[np.ndarray]:
    """What is shown after each pause, until the shape is final."""
    shapes = [evaluated_points(plate.obj)]
    while catch_up() or inner.sessions.unsettled():
        update()
        shapes.append(evaluated_points(plate.obj))
    return shapes


@pytest.fixture
def lifted_twice(plate: Rig, monkeypatch: pytest.MonkeyPatch) -> Rig:
    """A heavy plate, each time by a half and with a step of undo."""
    plate.bind("arap")
    plate.shown = []
    for message in ("first", "second"):
        plate.lift(0.5)
        plate.shown.append(plate.points())
        push(message)
    use_threads(monkeypatch)
    return plate


def test_undo_on_a_heavy_mesh_binds_nothing_and_creeps_nowhere(lifted_twice: Rig):
    """The shape that undo restores stays in view until the final one is there, which is the same."""
    plate = lifted_twice
    factor = factor_of(plate.deformer)
    with dragging():
        bpy.ops.ed.undo()
        update()
        assert inner.sessions.is_refining(plate.deformer.uid)
        assert "Refining" in draw_panel().texts()
        shapes = watched_until_final(plate)
        assert not inner.sessions.is_refining(plate.deformer.uid)
        assert "Refining" not in draw_panel().texts()
    assert factor_of(plate.deformer) is factor
    for shape in shapes:
        assert np.abs(shape - plate.shown[0]).max() < 1e-6


@pytest.mark.parametrize("price", [0.0, 1e9])
def test_a_drag_right_after_undo_shows_previews_again(lifted_twice: Rig, price: float):
    """Each move asks for something else, so waiting for final shapes would show none of them."""
    plate = lifted_twice
    with dragging():
        bpy.ops.ed.undo()
        update()
        for height in (0.75, 1.0):
            session_of(plate).step_milliseconds = price
            plate.lift(0.25)
            if price:
                wait_for_work(plate)
                inner.housekeeping.collect()
            assert plate.points()[plate.top, 2] == pytest.approx(height, abs=1e-6)
            assert inner.sessions.unsettled() == [plate.deformer.uid]


def test_after_release_the_final_shape_is_the_first_to_be_shown(heavy_drag):
    """A preview that a thread still computes then is dropped."""
    plate = heavy_drag("arap")
    with dragging():
        plate.lift(0.5)
        wait_for_work(plate)
        session_of(plate).step_milliseconds = 1e9
        plate.lift(0.5)
        before = evaluated_points(plate.obj)
        shapes = watched_until_final(plate)
    final = final_points(plate)
    for shape in shapes:
        assert np.array_equal(shape, before) or np.array_equal(shape, final)


@pytest.fixture
def heavy_drag(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    """A drag of a mesh whose every step costs more than the drag budget."""

    def begin(method: str) -> Rig:
        plate.bind(method)
        use_threads(monkeypatch)
        session_of(plate).step_milliseconds = 1e9
        return plate

    return begin


def test_a_preview_by_a_thread_is_near_the_final_shape(monkeypatch: pytest.MonkeyPatch):
    """However far the control has gone since the last one, and with a single iteration."""
    plate = Rig.plate(40).bind("arap")
    use_threads(monkeypatch)
    session = session_of(plate)
    session.step_milliseconds, session.steps = 1e9, 1
    before = plate.points()
    with dragging():
        turn = Matrix.Rotation(math.radians(80.0), 4, "X")
        move_world(plate.control, Matrix.Translation((0.0, -0.4, 0.6)) @ turn)
        session.work.thread.join(timeout=20.0)
        inner.housekeeping.collect()
        preview = plate.points()
        assert inner.sessions.unsettled()
    monkeypatch.undo()
    final, size = final_points(plate), np.ptp(before, axis=0).max()
    assert np.linalg.norm(final - before, axis=1).max() > 0.5 * size
    assert np.linalg.norm(preview - final, axis=1).max() < 0.01 * size


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_drag_over_the_budget_never_waits_and_the_shape_follows(heavy_drag, method: str):
    plate = heavy_drag(method)
    session, rest = session_of(plate), plate.points()
    with dragging():
        plate.lift(0.5)
        first = session.work
        assert first is not None  # asked in a thread
        assert np.array_equal(evaluated_points(plate.obj), rest)  # and nobody waited
        wait_for_work(plate)
        session.step_milliseconds = 1e9
        plate.lift(0.5)  # the control moves on, the answer for the first place comes in
        assert evaluated_points(plate.obj)[plate.top, 2] == pytest.approx(0.5, abs=1e-6)
        assert session.work not in (None, first)
        wait_for_work(plate)
        session.step_milliseconds = 1e9
        inner.housekeeping.collect()
        assert plate.points()[plate.top, 2] == pytest.approx(1.0, abs=1e-6)
        settled = watched_until_final(plate)[-1]
    assert np.array_equal(settled, final_points(plate))


def test_the_drag_budget_sets_how_many_steps_a_preview_takes(heavy_drag, monkeypatch):
    plate = heavy_drag("arap")
    session, taken = session_of(plate), []
    solve = session.bound.factor.solve

    def count(poses, **options):
        taken.append(options["max_iterations"])
        return solve(poses, **options)

    session.bound.factor.solve = count
    for budget, steps in ((1.0e4, 10), (1.0e-4, 1)):
        monkeypatch.setattr(inner.live_drag, "budget", lambda budget=budget: budget)
        with dragging():
            for _ in range(3):
                session.step_milliseconds = 0.0  # so that nothing goes to a thread
                plate.lift(0.1)
        assert taken[-1] == steps
