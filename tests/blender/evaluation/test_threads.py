# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that bind and solve: what becomes of their results when something was changed or went wrong."""

import numpy as np
import pytest
from inside import ask_for_factor, catch_up, inner, settle, use_threads
from rigs.rig import Rig, update

MISTAKE = "a mistake in the code"
the_console_shows_it = pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")


@pytest.fixture(autouse=True)
def heavy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Work goes to a thread, as for a heavy mesh in a window."""
    use_threads(monkeypatch)


class Mistake:
    """Stands in for a native call, and counts."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, *_arguments: object, **_keywords: object) -> None:
        self.calls += 1
        raise TypeError(MISTAKE)


def finish(plate: Rig) -> None:
    """Wait for the threads; the timer of a window looks for them, and the next evaluation shows them."""
    job = inner.binding.job(plate.deformer.uid)
    if job is not None:
        job.thread.join()
    settle()


@the_console_shows_it
def test_a_mistake_in_a_bind_is_shown_and_not_repeated(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    mistake = Mistake()
    plate.bind("thin_shell")
    module = inner.backend.availability().module
    monkeypatch.setattr(module.Arap, "__init__", mistake)
    plate.deformer.method = "arap"
    for _ in range(3):
        ask_for_factor(plate.deformer)
        finish(plate)
    assert MISTAKE in plate.deformer.status
    assert mistake.calls == 1
    assert not inner.binding.busy()
    np.testing.assert_allclose(plate.points(), plate.rest(), atol=1e-6)


@the_console_shows_it
def test_after_a_mistake_bind_starts_again(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    mistake = Mistake()
    plate.bind("thin_shell")
    module = inner.backend.availability().module
    with monkeypatch.context() as patch:
        patch.setattr(module.Arap, "__init__", mistake)
        plate.deformer.method = "arap"
        ask_for_factor(plate.deformer)
        finish(plate)
    inner.bind.bind(plate.obj, plate.deformer)
    plate.lift(0.5)
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=1e-5)
    assert mistake.calls == 1


@the_console_shows_it
def test_a_mistake_in_a_solve_is_shown_and_not_repeated(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    mistake = Mistake()
    plate.bind("arap")
    depsgraph_of = inner.evaluate.update
    bound = inner.sessions.find(plate.deformer.uid).bound
    monkeypatch.setattr(bound.factor, "solve", mistake)
    inner.sessions.find(plate.deformer.uid).step_milliseconds = 1e6  # dearer than any budget of a drag
    monkeypatch.setattr(inner.evaluate, "update", lambda graph, **_how: depsgraph_of(graph, preview=True))
    plate.lift(0.5)
    for _ in range(4):
        work = inner.sessions.find(plate.deformer.uid).work
        if work is not None:
            work.thread.join()
        catch_up()
        plate.obj.update_tag()
        update()
    assert MISTAKE in plate.deformer.status
    assert mistake.calls == 1
    assert not inner.binding.busy()


def test_a_bind_that_is_no_longer_wanted_is_dropped(plate: Rig):
    """The method is switched forth and back while a thread binds for the other one."""
    plate.bind("thin_shell")
    plate.lift(0.5)
    shown = plate.points()
    factor = inner.sessions.find(plate.deformer.uid).bound.factor
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    assert inner.binding.job(plate.deformer.uid) is not None
    plate.deformer.method = "thin_shell"
    update()
    assert inner.binding.job(plate.deformer.uid) is None
    assert not inner.binding.busy()
    finish(plate)
    assert inner.sessions.find(plate.deformer.uid).bound.factor is factor
    np.testing.assert_array_equal(plate.points(), shown)


def test_a_finished_bind_is_taken_in_by_the_next_evaluation(plate: Rig):
    """No timer of ours has to fire for it."""
    plate.bind("thin_shell")
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    inner.binding.job(plate.deformer.uid).thread.join()
    ask_for_factor(plate.deformer)
    assert not inner.binding.busy()
    assert inner.sessions.find(plate.deformer.uid).bound.factor.recipe.method.id == "arap"


def test_a_bind_of_a_deformer_that_is_gone_is_dropped(plate: Rig):
    """Undo takes a deformer away without a word to us."""
    plate.bind("thin_shell")
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    uid = plate.deformer.uid
    inner.binding.job(uid).thread.join()
    plate.obj.sinew.deformers.clear()
    inner.owners.forget_owners()
    catch_up()
    assert inner.binding.job(uid) is None
    assert inner.sessions.find(uid).bound.factor.recipe.method.id == "thin_shell"
