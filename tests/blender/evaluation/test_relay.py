# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes of render threads are carried out once, by the main thread where it serves, else by their own."""

import threading
from types import SimpleNamespace

import bpy
import pytest
from inside import inner


@pytest.fixture
def relay(monkeypatch: pytest.MonkeyPatch):
    """As in a window whose interface is not locked."""
    found = inner.render_writes
    monkeypatch.setattr(found, "must_hand_over", lambda _scene: True)
    return found


class Render(threading.Thread):
    """Hands over one write; who carried it out, and what it gave."""

    def __init__(self, relay, write=None) -> None:
        super().__init__(daemon=True)
        self.relay, self.by, self.result = relay, [], None
        self.lock = threading.RLock()
        self.write = write or (lambda: True)

    def run(self) -> None:
        def write() -> bool:
            self.by.append(threading.current_thread())
            return self.write()

        with self.lock:
            self.result = self.relay.write(SimpleNamespace(), write, self.lock)


def test_the_main_thread_carries_it_out_and_may_take_the_lock_meanwhile(relay):
    render = Render(relay)
    render.start()
    while not render.by:
        with render.lock:
            relay.carry_out_writes()
    render.join(10.0)
    assert render.by == [threading.main_thread()]
    assert render.result is True


def test_without_an_answer_the_render_thread_does_it_itself_once(relay, monkeypatch):
    monkeypatch.setattr(relay, "PATIENCE", 0.05)
    render = Render(relay, lambda: False)
    render.start()
    render.join(10.0)
    relay.carry_out_writes()  # too late
    assert render.by == [render]
    assert render.result is False


def test_what_blender_forbids_the_main_thread_for_a_moment_is_tried_again(relay):
    tries = []

    def write() -> bool:
        tries.append(1)
        if len(tries) == 1:
            raise AttributeError("Writing to ID classes in this context is not allowed")
        return True

    render = Render(relay, write)
    render.start()
    while not render.by:
        relay.carry_out_writes()
    render.join(10.0)
    assert render.by == [threading.main_thread(), render]
    assert render.result is True


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
