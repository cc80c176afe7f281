# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Once by events, as a window would send them."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from editing import centre, edit, edited, grab, placed_object, selection
from inside import inner, use_threads
from mouse import event, front_view
from registry import GRABBING
from rigs.rig import grid_object


class Hand:
    """A person at the mouse and keyboard, before a front view where a pixel is a centimetre."""

    def __init__(self, obj: bpy.types.Object, method: str = "thin_shell", radius: float = 0.4) -> None:
        typed = inner.typed_motion
        self.obj, self.x, self.y, self.before = obj, 500.0, 300.0, edited(obj)
        self.outcomes, self.view = inner.grabbing.Outcome, front_view()
        grab = inner.grab.Grab(obj, inner.methods.BY_ID[method])
        motion = typed.TypedMotion(typed.Mode.TRANSLATE, self.view, np.eye(3), (self.x, self.y))
        self.tool = inner.grabbing.Grabbing(grab, motion, grab.selection.mean(axis=0), np.eye(3), radius)

    def send(self, kind: str, value: str = "PRESS", **modifiers: bool):
        text = {"PERIOD": ".", "MINUS": "-", "ZERO": "0", "TWO": "2", "FIVE": "5"}.get(kind, "")
        return self.tool.process(self.obj, event(kind, value, self.x, self.y, text, **modifiers), self.view)

    def move(self, x: float, y: float, **modifiers: bool):
        self.x, self.y = self.x + x, self.y + y
        return self.send("MOUSEMOVE", "NOTHING", **modifiers)

    def type(self, *keys: str) -> None:
        for key in keys:
            assert self.send(key) is self.outcomes.GO_ON


@pytest.fixture
def hand() -> Hand:
    obj = grid_object(cells=20)
    edit(obj, centre)
    return Hand(obj)


def lifted(hand: Hand) -> np.ndarray:
    """How the selection moved, (3,)."""
    obj = hand.obj
    chosen = [vertex.index for vertex in bmesh.from_edit_mesh(obj.data).verts if vertex.select]
    obj.update_from_editmode()
    return (edited(obj)[chosen] - hand.before[chosen]).mean(axis=0)


def test_the_mouse_moves_in_the_plane_of_the_view(hand: Hand):
    """A turned view keeps the motion, and it goes on from there."""
    hand.move(30, 50)
    assert np.allclose(lifted(hand), (0.3, 0.0, 0.5), atol=1e-6)
    hand.move(10, 0, shift=True)
    assert np.allclose(lifted(hand), (0.31, 0.0, 0.5), atol=1e-6)
    right, up, toward = np.eye(3)[[1, 2, 0]]
    hand.view = hand.view.__class__(right=right, up=up, toward=toward, pixel=0.02, centre=(410.0, 300.0))
    hand.move(200, -100)
    assert np.allclose(lifted(hand), (0.31, 0.0, 0.5), atol=1e-6)
    hand.move(10, 5)
    assert np.allclose(lifted(hand), (0.31, 0.2, 0.6), atol=1e-6)


def test_axis_and_number_by_keys(hand: Hand):
    hand.send("Z")
    hand.send("Z", is_repeat=True)  # a key that is held counts once
    hand.move(30, 50)
    assert not hand.tool.typed.motion.local
    assert np.allclose(lifted(hand), (0.0, 0.0, 0.5), atol=1e-6)
    hand.type("ZERO", "PERIOD", "FIVE", "MINUS")
    assert np.allclose(lifted(hand), (0.0, 0.0, -0.5), atol=1e-6)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    assert np.allclose(lifted(hand), (0.0, 0.0, -0.5), atol=1e-6)


@pytest.mark.parametrize("method", GRABBING)
@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
def test_cancel_restores_every_bit_and_the_selection(key: str, method: str):
    obj = placed_object()
    random = np.random.default_rng(5)
    for vertex, z in zip(obj.data.vertices, random.normal(0.0, 0.05, len(obj.data.vertices))):
        vertex.co.z = z
    edit(obj, centre)
    before, chosen = edited(obj), selection(obj)
    hand = Hand(obj, method, radius=1.0)
    hand.move(30, 50)
    hand.type("R")
    hand.move(-80, 120)
    for _ in range(4):
        hand.send("WHEELDOWNMOUSE")
    hand.send("A")
    hand.move(7, 3)
    hand.send("TIMER", "NOTHING")
    assert not np.array_equal(edited(obj), before)
    assert hand.send(key) is hand.outcomes.CANCELLED
    assert edited(obj).tobytes() == before.tobytes()
    assert selection(obj) == chosen


@pytest.mark.parametrize("method", GRABBING)
def test_what_was_confirmed_is_what_the_properties_repeat(method: str):
    obj = grid_object(cells=20)
    edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, method)
    hand.move(33, 47)
    hand.type("R", "Y")
    hand.move(-11, 90)
    hand.send("WHEELDOWNMOUSE")
    assert hand.send("LEFTMOUSE") is hand.outcomes.CONFIRMED
    after, motion = edited(obj), hand.tool.typed.motion
    hand.tool.grab.restore(obj)
    assert np.array_equal(edited(obj), before)
    grab(mode="ROTATE", angle=motion.angle, axis=motion.axis, radius=hand.tool.radius, method=method)
    np.testing.assert_array_equal(edited(obj), after)


def test_the_wheel_changes_how_much_follows(hand: Hand):
    def moved() -> int:
        return (edited(hand.obj) != hand.before).any(axis=1).sum()

    hand.move(0, 50)
    narrow = moved()
    for _ in range(5):
        hand.send("PAGE_UP")
    assert moved() > 1.5 * narrow
    for _ in range(5):
        hand.send("WHEELUPMOUSE")
    assert moved() == narrow
    assert hand.tool.radius == pytest.approx(0.4)
    hand.send("A")
    assert moved() == len(hand.before)


def test_navigation_passes_through_and_other_keys_do_not(hand: Hand):
    assert hand.send("MIDDLEMOUSE") is hand.outcomes.PASS
    assert hand.send("WHEELUPMOUSE", ctrl=True) is hand.outcomes.PASS
    assert hand.send("NDOF_MOTION", "NOTHING") is hand.outcomes.PASS
    hand.type("DEL", "NONE")
    assert np.array_equal(edited(hand.obj), hand.before)


def test_a_preview_goes_on_while_the_mouse_rests():
    obj = grid_object(cells=40)
    edit(obj, centre)
    hand = Hand(obj, "arap", radius=0.7)
    hand.move(10, 80)
    for _ in range(100):
        hand.send("TIMER", "NOTHING")
    assert hand.tool.grab.settled
    rested = edited(obj)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    assert np.abs(edited(obj) - rested).max() < 0.02


def test_a_mesh_that_changed_under_the_tool_is_left_alone(hand: Hand):
    hand.move(0, 50)
    bmesh.from_edit_mesh(hand.obj.data).verts.new((9.0, 9.0, 9.0))
    with pytest.raises(inner.errors.TopologyChangedError, match="edited meanwhile"):
        hand.move(0, 10)


@pytest.mark.parametrize("key", ["RET", "ESC"])
def test_a_heavy_region_binds_in_a_thread_and_is_confirmed_when_ready(
    monkeypatch: pytest.MonkeyPatch, key: str
):
    """Or cancelled at once."""
    use_threads(monkeypatch)
    obj = grid_object(cells=30)
    edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, "arap")
    assert hand.tool.grab.job is not None
    hand.move(0, 50)
    assert np.array_equal(edited(obj), before)
    outcome = hand.send(key)
    if key == "ESC":
        assert (outcome, hand.tool.grab.job) == (hand.outcomes.CANCELLED, None)
        assert np.array_equal(edited(obj), before)
        return
    for _ in range(10_000):
        if outcome is not hand.outcomes.GO_ON:
            break
        outcome = hand.send("TIMER", "NOTHING")
        hand.tool.grab.job and hand.tool.grab.job.thread.join()
    assert outcome is hand.outcomes.CONFIRMED
    after = edited(obj)
    hand.tool.grab.restore(obj)
    grab(value=hand.tool.typed.motion.move, radius=0.4, method="arap")
    assert np.array_equal(edited(obj), after)


def test_scaling_all_that_is_connected_binds_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch):
    """Moved and turned, a surface that nothing holds goes as one piece, without a bind."""
    use_threads(monkeypatch)
    obj = grid_object(cells=20)
    chosen = edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, radius=np.inf)
    assert hand.tool.grab.job is None
    hand.move(0, 50)
    assert np.allclose(edited(obj), before + (0.0, 0.0, 0.5), atol=1e-6)
    hand.type("S", "TWO")
    hand.tool.grab.job.thread.join()
    hand.send("TIMER", "NOTHING")
    assert np.allclose(edited(obj)[chosen], before[chosen] * 2.0, atol=1e-6)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    after = edited(obj)
    hand.tool.grab.restore(obj)
    grab(mode="RESIZE", scale=(2.0, 2.0, 2.0), unlimited=True, method="thin_shell")
    assert np.array_equal(edited(obj), after)
