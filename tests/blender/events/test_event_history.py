# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of every operator, of settings and of control moves, also across binds and topology edits."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import ALL, MESHES, REGIONS, Event, Table, every
from expected import Expected
from inside import bind_in_thread, evaluated_by, finish, inner
from mathutils import Matrix
from registry import BY_ID
from rigs.kinds import HandleRig
from rigs.rig import (
    Rig,
    close,
    in_mode,
    linked,
    make_active,
    move_world,
    new_file,
    push,
    reopen,
    update,
)
from test_undo_of_buttons import BUTTONS

LIFT = Matrix.Translation((0.0, 0.0, 0.5))


def pose(plate: Rig) -> Expected:
    """Bound and lifted by a half, with an undo step of its own."""
    plate.bind()
    expected = Expected.of_rig(plate)
    push("bound")
    plate.lift(0.5)
    make_active(plate.obj)
    push("posed")
    return expected


def test_every_operator_has_its_undo_tested():
    """What changes nothing leaves no step. Some are tested where the operator is, one changes the mode."""
    names = set(dir(bpy.ops.sinew))
    with_undo = {n for n in names if "UNDO" in getattr(getattr(bpy.types, f"SINEW_OT_{n}"), "bl_options", ())}
    elsewhere = {
        "handle_stand",
        "puppet_pin",
        "puppet_rig",
        "armature_off",
        "refine",
        "keep_inside",
        "control_edit",
    }
    assert with_undo == {*elsewhere, *(names & set(BUTTONS) - {"start_task"})}
    without = {"cancel", "check_installation", "help", "key_jump", "preset_add", "report_renders", "watch"}
    beginnings = {"all_tasks", "choose_method", "drag_press", "drag_start", "start_task"}  # of what has steps
    assert names - with_undo <= without | beginnings


def set_factor(rig: HandleRig) -> np.ndarray:
    rig.deformer.factor = 0.5
    return 0.5 * rig.rest() + 0.5 * rig.at(0.5)


def stop_live(rig: HandleRig) -> np.ndarray:
    rig.deformer.live = False
    return rig.at(0.5)


def set_mask(rig: HandleRig) -> np.ndarray:
    rig.deformer.mask_group = "Top"
    shown = rig.rest()
    shown[rig.top] = rig.at(0.5)[rig.top]
    return shown


def switch_off_its_handle(rig: HandleRig) -> np.ndarray:
    rig.deformer.handles[0].enabled = False
    return rig.rest()


def press_bind(rig: HandleRig) -> np.ndarray:
    rig.press("bind")
    return rig.at(0.5)


def press_unbind(rig: HandleRig) -> np.ndarray:
    rig.press("unbind")
    return rig.rest()


def remove_deformer(rig: HandleRig) -> np.ndarray:
    rig.press("deformer_remove")
    return rig.rest()


def move_on(rig: HandleRig) -> np.ndarray:
    move_world(rig.control, Matrix.Translation((0.0, 0.0, 0.25)))
    return rig.at(0.75)


def change_topology(rig: HandleRig) -> np.ndarray:
    rig.change_topology()
    return rig.rest()


CHANGES = Table()
CHANGES.on(MESHES)(set_mask)
CHANGES.on(REGIONS)(switch_off_its_handle)
for changed in (set_factor, stop_live, press_bind, press_unbind, remove_deformer, move_on, change_topology):
    CHANGES.on(ALL)(changed)


@every(CHANGES)
def test_undo_and_redo_on_every_rig(posed: HandleRig, event: Event):
    make_active(posed.obj)
    push("posed")
    shape, whole = event.happen(posed), posed.at(0.5)
    push("changed")
    assert posed.shows(shape)
    for _ in range(2):
        go(bpy.ops.ed.undo, posed, len(whole))
        assert posed.is_right()
        go(bpy.ops.ed.redo, posed, len(shape))
        assert posed.shows(shape)
    go(bpy.ops.ed.undo, posed, len(whole))
    assert posed.is_right()
    posed.lift(0.25)  # and it lives on
    assert posed.is_right()


def go(way: Callable, rig: HandleRig, count: int) -> None:
    """Undo or redo, across the steps in Edit Mode, to so many points."""
    way()
    for _ in range(5):
        if rig.obj.mode != "OBJECT" or len(rig.rest()) != count:
            way()


def test_undo_and_redo_of_weights(plate: Rig):
    """A soft handle gives way: the library solves with the weight itself."""
    expected = pose(plate)
    plate.deformer.handles[0].weight = 0.25
    push("weight")
    plate.obj.vertex_groups["Top"].add([int(index) for index in plate.top], 0.25, "REPLACE")
    at_rest = plate.control.copy()  # an object in no scene keeps the matrix it is given
    at_rest.parent = None
    at_rest.matrix_world = LIFT.inverted() @ plate.control.matrix_world
    soft = Expected(plate.obj, at_rest).shape(LIFT)
    bpy.data.objects.remove(at_rest)
    assert np.abs(soft - expected.shape(LIFT)).max() > 1e-3
    assert close(plate.points(), soft)
    bpy.ops.ed.undo()
    assert close(plate.points(), expected.shape(LIFT))
    bpy.ops.ed.redo()
    assert close(plate.points(), soft)


class Story:
    """Undo steps with what each must show. A check is None where the mesh is in Edit Mode."""

    def __init__(self, plate: Rig) -> None:
        self.plate = plate
        self.steps: list[tuple[str, np.ndarray | None]] = []

    def tell(self, name: str, shape: np.ndarray | None) -> None:
        push(name)
        self.steps.append((name, shape))
        self.check(len(self.steps) - 1)

    def check(self, number: int) -> None:
        name, shape = self.steps[number]
        if shape is not None:
            assert self.plate.obj.mode == "OBJECT", name
            assert close(self.plate.points(), shape), name

    def walk(self, start: int, end: int) -> None:
        """Undo or redo one step at a time, looking at each."""
        direction = 1 if end > start else -1
        for number in range(start + direction, end + direction, direction):
            (bpy.ops.ed.redo if direction > 0 else bpy.ops.ed.undo)()
            self.check(number)


def test_undo_to_a_step_that_was_saved_before_it_was_solved(plate: Rig):
    """Blender then brings back a shape mesh that is older than the pose."""
    plate.bind()
    push("bound")
    with evaluated_by(None):
        plate.lift(0.5)
        push("moved, not solved")
    plate.obj.update_tag()
    moved = plate.points()
    assert close(moved[plate.top], plate.rest()[plate.top] + (0.0, 0.0, 0.5))
    plate.obj.location.x += 1.0
    push("later")
    bpy.ops.ed.undo()
    assert np.array_equal(plate.points(), moved)


def test_history_across_binds_and_topology_edits(plate: Rig):
    story = Story(plate)
    make_active(plate.obj)
    story.tell("start", plate.rest())
    plate.bind()
    expected = Expected.of_rig(plate)
    story.tell("bound", plate.rest())
    plate.lift(0.5)
    story.tell("moved", expected.lifted(0.5))
    with in_mode(plate.obj):
        story.tell("Edit Mode", None)
        bpy.ops.mesh.select_all(action="SELECT")
        story.tell("selected", None)
        bpy.ops.mesh.subdivide()
        story.tell("subdivided", None)
    story.tell("topology changed", plate.rest())
    move_world(plate.control, LIFT.inverted())
    fine = Expected.of_rig(plate)
    move_world(plate.control, LIFT)
    bpy.ops.sinew.bind()
    story.tell("rebound", fine.lifted(0.5))
    plate.lift(-0.2)
    story.tell("moved again", fine.lifted(0.3))
    bpy.ops.sinew.unbind()
    story.tell("unbound", plate.rest())
    bpy.ops.sinew.bind()
    story.tell("bound where it stood", plate.rest())
    plate.lift(0.4)
    story.tell("moved at last", fine.lifted(0.4))

    last = len(story.steps) - 1
    story.walk(last, 0)
    assert len(plate.obj.sinew.deformers) == len(plate.obj.modifiers) == 0
    for start, end in ((0, last), (last, 2), (2, 7), (7, 5), (5, last)):
        story.walk(start, end)


def test_history_of_a_drag_and_of_what_drives_it(plate: Rig):
    """Moves, a turn, a constraint, a parent: whatever moves a control is taken back with it."""
    plate.bind()
    expected = Expected.of_rig(plate)
    story = Story(plate)
    story.tell("bound", plate.rest())
    for height in (0.1, 0.2, 0.3):
        plate.lift(0.1)
        story.tell("moved", expected.lifted(height))
    turn = Matrix.Rotation(0.4, 4, "X")
    move_world(plate.control, turn)
    story.tell("turned", expected.now(plate.obj, plate.control))
    parent = linked(bpy.data.objects.new("Parent", None))
    plate.control.constraints.new("CHILD_OF").target = parent
    story.tell("constrained", expected.now(plate.obj, plate.control))
    parent.location.x = 0.3
    update()
    story.tell("parent moved", expected.now(plate.obj, plate.control))
    last = len(story.steps) - 1
    story.walk(last, 0)
    story.walk(0, last)


# --- while a thread binds: what the user does meanwhile, and what is seen then


def undone(rig: HandleRig) -> np.ndarray:
    bpy.ops.ed.undo()
    return rig.at(0.0)


def saved_and_loaded(rig: HandleRig) -> np.ndarray:
    reopen(rig.folder / "rig.blend")
    return rig.at(0.5)


def rendered(rig: HandleRig) -> np.ndarray:
    assert rig.renders(rig.at(0.5))
    return rig.at(0.5)


def frame_changed(rig: HandleRig) -> np.ndarray:
    bpy.context.scene.frame_set(5)
    return rig.at(0.5)


def switched_forth_and_back(rig: HandleRig) -> np.ndarray:
    method = rig.deformer.method
    rig.deformer.method = next(other for other in (*rig.methods, *BY_ID) if other != method)
    update()
    rig.deformer.method = method
    return rig.at(0.5)


def deleted(rig: HandleRig) -> None:
    make_active(rig.obj)
    bpy.ops.object.delete()


def replaced_by_a_new_file(_rig: HandleRig) -> None:
    new_file()


MEANWHILE = (undone, saved_and_loaded, rendered, frame_changed, set_factor, switched_forth_and_back)
MEANWHILE += (press_unbind, deleted, replaced_by_a_new_file)


@pytest.mark.parametrize("event", MEANWHILE, ids=lambda event: event.__name__)
def test_while_a_thread_binds_a_rig_is(rig: HandleRig, monkeypatch, tmp_path: Path, event: Callable):
    """What the thread was asked for is no longer wanted, or comes later: the shape is that of now."""
    rig.folder = tmp_path
    rig.start()
    push("bound")
    rig.lift(0.5)
    push("posed")
    bind_in_thread(rig.obj, rig.deformer, monkeypatch)
    shape = event(rig)
    assert finish()
    if shape is None:
        assert inner.owners.owners() == []
        fresh = type(rig).new("Fresh").start()
        fresh.lift(0.25)
        assert fresh.is_right()
    else:
        assert rig.shows(shape)
    assert not inner.binding.busy()
