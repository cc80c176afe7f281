# SPDX-License-Identifier: GPL-3.0-or-later
"""One table of events: what happens to a posed rig, on which rigs, and what must hold afterwards.

An event is a function of a rig that is bound and lifted by a half; ``rig.folder`` is its own. It may assert
what is seen on the way. ``then`` says what holds when it is over, and is the same for all rigs.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import bpy
import pytest
from inside import settle
from rigs.kinds import RIGS, HandleRig
from rigs.rig import make_active

ALL = tuple(RIGS)
MESHES = ("handles", "cage")  # about vertex groups, faces, modes or modifiers that curves do not have
REGIONS = ("handles",)  # about regions, or what only they have: bones, weights, an order
REBIND = "Topology changed - Rebind"


def lives_on(rig: HandleRig, tolerance: float = 0.0) -> None:
    """It shows the pose of its control in the viewport and in renders, and so does the next move."""
    for height in (0.0, 0.25):
        rig.lift(height)
        assert rig.is_right(tolerance)
    assert rig.renders(rig.at(rig.height), tolerance)
    assert rig.deformer.status_level == "INFO", rig.deformer.status


def keeps_its_shape(rig: HandleRig) -> None:
    """Nothing moves it any more, and nothing takes its shape away."""
    for frame in (1, 7):
        bpy.context.scene.frame_set(frame)
        assert rig.is_right()


def says_rebind(rig: HandleRig) -> None:
    """Rest and a word about it; right again after Rebind."""
    assert rig.is_at_rest()
    assert rig.deformer.status == REBIND
    is_bound_again(rig)


def is_bound_again(rig: HandleRig) -> None:
    """To the mesh and the groups of now, with the pose of before."""
    rig.press("bind")
    rebinds_by_itself(rig)


def rebinds_by_itself(rig: HandleRig) -> None:
    rig.poses.rebind(rig.obj)
    lives_on(rig, 1e-5)


def bind_restores(rig: HandleRig) -> None:
    """Rest and the advice to bind, which makes no second modifier."""
    assert rig.is_at_rest()
    assert rig.deformer.status_level in ("ERROR", "WARNING")
    assert "bind" in rig.deformer.status.lower()
    rig.press("bind")
    assert len(rig.obj.modifiers) == 1
    lives_on(rig)


def is_over(_rig: HandleRig) -> None:
    """The event itself has seen all there is to see."""


@dataclass(frozen=True)
class Event:
    happen: Callable[[HandleRig], object]
    rigs: tuple[str, ...]
    then: Callable[[HandleRig], None]

    def run(self, rig: HandleRig) -> None:
        self.happen(rig)
        settle()
        self.then(rig)

    def edit(self, rig: HandleRig, automatic: bool) -> None:
        """Other vertices come in, or others are joined to faces, with Automatic Rebind or without."""
        rig.deformer.auto_rebind = automatic
        self.happen(rig)
        settle()
        (rebinds_by_itself if automatic else says_rebind)(rig)


class Table(list[Event]):
    """Events of one kind."""

    def on(self, rigs: Iterable[str], then: Callable[[HandleRig], None] = lives_on) -> Callable:
        """The decorated function happens to these rigs."""

        def add(happen: Callable[[HandleRig], object]) -> Callable[[HandleRig], object]:
            self.append(Event(happen, tuple(rigs), then))
            return happen

        return add


def every(table: Iterable[Event]) -> pytest.MarkDecorator:
    """A test of each event on each of its rigs, as ``event`` and ``rig``."""
    cases = [(kind, event) for event in table for kind in event.rigs]
    names = [f"{event.happen.__name__}-{kind}" for kind, event in cases]
    return pytest.mark.parametrize(("rig", "event"), cases, ids=names, indirect=["rig"])


def duplicate(rig: HandleRig, linked: bool = False, control: bool = True) -> bpy.types.Object:
    """With the control or without; after a pause the copy has a shape and a key of its own."""
    make_active(rig.obj)
    rig.control.select_set(control)
    bpy.ops.object.duplicate(linked=linked)
    copy = bpy.context.object
    settle()
    own, theirs = rig.deformer, copy.sinew.deformers[0]
    assert (copy.data == rig.obj.data) == linked
    assert own.uid != theirs.uid
    assert own.proxy != theirs.proxy
    assert (rig.control_of(copy) == rig.control) == (not control)
    return copy
