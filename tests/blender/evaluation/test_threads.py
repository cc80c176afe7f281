# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that bind and solve: what becomes of their results when something was changed or went wrong."""

import threading
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from inside import ask_for_factor, catch_up, finish, inner, settle, use_threads
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


def session_of(plate: Rig):
    return inner.sessions.find(plate.deformer.uid)


def ask_for_another_method(plate: Rig) -> threading.Thread:
    """The thread that binds it."""
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    return inner.binding.job(plate.deformer.uid).thread


@the_console_shows_it
def test_a_mistake_in_a_bind_is_shown_and_not_repeated_until_bind_is_pressed(
    plate: Rig, monkeypatch: pytest.MonkeyPatch
):
    mistake = Mistake()
    plate.bind("thin_shell")
    with monkeypatch.context() as patch:
        patch.setattr(inner.backend.availability().module.Arap, "__init__", mistake)
        plate.deformer.method = "arap"
        for _ in range(3):
            ask_for_factor(plate.deformer)
            if inner.binding.busy():  # else an update in the background would bind by itself meanwhile
                inner.binding.job(plate.deformer.uid).thread.join()
            assert finish()
        assert MISTAKE in plate.deformer.status
        assert not inner.binding.busy()
        np.testing.assert_allclose(plate.points(), plate.rest(), atol=1e-6)
    inner.bind.bind(plate.obj, plate.deformer)
    plate.lift(0.5)
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=1e-5)
    assert mistake.calls == 1


@the_console_shows_it
def test_a_mistake_in_a_solve_is_shown_and_not_repeated(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    mistake, evaluate = Mistake(), inner.evaluate.update
    plate.bind("arap")
    monkeypatch.setattr(session_of(plate).bound.factor, "solve", mistake)
    session_of(plate).step_milliseconds = 1e6  # dearer than any budget of a drag
    monkeypatch.setattr(inner.evaluate, "update", lambda graph, **_how: evaluate(graph, preview=True))
    plate.lift(0.5)
    for _ in range(4):
        work = session_of(plate).work
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
    plate.bind("thin_shell").lift(0.5)
    shown, factor = plate.points(), session_of(plate).bound.factor
    ask_for_another_method(plate)
    plate.deformer.method = "thin_shell"
    update()
    assert inner.binding.job(plate.deformer.uid) is None
    assert not inner.binding.busy()
    settle()
    assert session_of(plate).bound.factor is factor
    np.testing.assert_array_equal(plate.points(), shown)


def test_a_finished_bind_is_taken_in_by_the_next_evaluation(plate: Rig):
    """No timer of ours has to fire for it."""
    plate.bind("thin_shell")
    ask_for_another_method(plate).join()
    ask_for_factor(plate.deformer)
    assert not inner.binding.busy()
    assert session_of(plate).bound.factor.recipe.method.id == "arap"


def test_a_bind_of_a_deformer_that_is_gone_is_dropped(plate: Rig):
    """Undo takes a deformer away without a word to us."""
    plate.bind("thin_shell")
    uid, session = plate.deformer.uid, session_of(plate)
    ask_for_another_method(plate).join()
    plate.obj.sinew.deformers.clear()
    inner.owners.forget_owners()
    catch_up()
    assert inner.binding.job(uid) is None
    assert session.bound.factor.recipe.method.id == "thin_shell"


# --- writes of render threads are carried out once: by the main thread where it serves, else by their own


@pytest.fixture
def relay(monkeypatch: pytest.MonkeyPatch):
    """As in a window whose interface is not locked."""
    found = inner.render_writes
    monkeypatch.setattr(found, "must_hand_over", lambda _scene: True)
    return found


class Render(threading.Thread):
    """Hands over one write; who carried it out, and what it gave."""

    def __init__(self, relay, write=lambda: True) -> None:
        super().__init__(daemon=True)
        self.relay, self.by, self.result = relay, [], None
        self.lock, self.write = threading.RLock(), write
        self.start()

    def run(self) -> None:
        def write() -> bool:
            self.by.append(threading.current_thread())
            return self.write()

        with self.lock:
            self.result = self.relay.write(SimpleNamespace(), write, self.lock)

    def serve(self) -> None:
        """The main thread carries out writes until one came; it may take the lock meanwhile."""
        while not self.by:
            with self.lock:
                self.relay.carry_out_writes()
        self.join(10.0)


def test_the_main_thread_carries_it_out(relay):
    render = Render(relay)
    render.serve()
    assert (render.by, render.result) == ([threading.main_thread()], True)


def test_without_an_answer_the_render_thread_does_it_itself_once(relay, monkeypatch):
    monkeypatch.setattr(relay, "PATIENCE", 0.05)
    render = Render(relay, lambda: False)
    render.join(10.0)
    relay.carry_out_writes()  # too late
    assert (render.by, render.result) == ([render], False)


def test_what_blender_forbids_the_main_thread_for_a_moment_is_tried_again(relay):
    tries = iter((AttributeError("Writing to ID classes in this context is not allowed"), None))

    def write() -> bool:
        error = next(tries)
        if error:
            raise error
        return True

    render = Render(relay, write)
    render.serve()
    assert (render.by, render.result) == ([threading.main_thread(), render], True)


@pytest.mark.parametrize(
    ("timer", "work"), [("_tick", "catch_up"), ("_write_for_renders", "refresh.look_at_renders")]
)
def test_timers_go_on_where_blender_forbids_writes_for_a_moment(monkeypatch, timer: str, work: str):
    deferred, said = inner.deferred, ["Writing to ID classes in this context is not allowed", "no such name"]

    def refuse() -> None:
        raise AttributeError(said.pop(0))

    monkeypatch.setattr(deferred, "_has_rigs_in_windows", lambda: True)
    monkeypatch.setattr(deferred, "_last_edit", 0.0)
    monkeypatch.setattr(f"{deferred.__name__}.{work}", refuse)
    assert getattr(deferred, timer)() > 0.0
    with pytest.raises(AttributeError, match="no such name"):
        getattr(deferred, timer)()


def test_locked_interfaces_and_background_renders_need_no_relay():
    relay = inner.render_writes
    assert not relay.must_hand_over(bpy.context.scene)
    assert relay.write(bpy.context.scene, lambda: True, threading.RLock()) is True
