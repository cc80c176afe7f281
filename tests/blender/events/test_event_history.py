# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of every operator, of settings and of control moves, also across binds and topology edits."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import ALL, MESHES, REGIONS, Event, Table, every
from inside import bind_in_thread, finish, inner, settle
from mathutils import Matrix
from registry import BY_ID
from rigs.kinds import HandleRig
from rigs.rig import (
    Rig,
    close,
    duplicated,
    evaluated_points,
    make_active,
    move_world,
    new_empty,
    new_file,
    push,
    reopen,
    update,
)
from test_undo_of_buttons import BUTTONS

LIFT = Matrix.Translation((0.0, 0.0, 0.5))


def test_every_operator_has_its_undo_tested():
    """What changes nothing leaves no step. Some are tested where the operator is, one changes the mode."""
    names = set(dir(bpy.ops.sinew))
    with_undo = {n for n in names if "UNDO" in getattr(getattr(bpy.types, f"SINEW_OT_{n}"), "bl_options", ())}
    elsewhere = {"handle_stand", "puppet_pin", "puppet_rig", "armature_off", "refine", "keep_inside"}
    assert with_undo == {*elsewhere, "control_edit", *(names & set(BUTTONS) - {"start_task"})}
    without = {"cancel", "check_installation", "help", "key_jump", "preset_add", "report_renders", "watch"}
    beginnings = {"all_tasks", "choose_method", "drag_press", "drag_start", "start_task"}  # of what has steps
    assert names - with_undo <= without | beginnings


def set_factor(rig: HandleRig) -> np.ndarray:
    rig.deformer.factor = 0.25
    return 0.75 * rig.rest() + 0.25 * rig.at(0.5)


def stop_live(rig: HandleRig) -> np.ndarray:
    rig.deformer.live = False
    return rig.at(0.5)


def set_mask(rig: HandleRig) -> np.ndarray:
    """The masked vertices are whole or at rest to the last bit."""
    shown, whole = rig.rest(), rig.points()
    shown[rig.top] = whole[rig.top]
    rig.deformer.mask_group = "Top"
    assert np.array_equal(rig.points(), shown)
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


def turn(rig: HandleRig) -> np.ndarray:
    move_world(rig.control, Matrix.Rotation(0.4, 4, "X"))
    return rig.now()


def constrain(rig: HandleRig) -> np.ndarray:
    rig.control.constraints.new("CHILD_OF").target = new_empty("Parent")
    update()
    return rig.now()


def move_its_parent(rig: HandleRig) -> np.ndarray:
    constrain(rig)
    push("constrained")
    bpy.data.objects["Parent"].location.x = 0.3
    update()
    return rig.now()


CHANGES = Table()
CHANGES.on(MESHES)(set_mask)
CHANGES.on(REGIONS)(switch_off_its_handle)
ON_ALL = (set_factor, stop_live, press_bind, press_unbind, remove_deformer, change_topology)
for changed in (*ON_ALL, move_on, turn, constrain, move_its_parent):
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


# --- pointers
# Blender's undo may bring back a pointer to a removed object as one to the object that holds the pointer.
# Whether it does depends on where Blender puts things in memory, so the tests make such a step themselves.


@pytest.mark.parametrize("lost", [("VIEWPORT",), ("RENDER",), ("VIEWPORT", "RENDER")], ids=str)
def test_a_deformer_finds_its_hidden_shapes_again(plate: Rig, lost: tuple[str, ...]):
    """So does a copy."""
    plate.bind()
    names = plate.name, duplicated(plate.obj).name
    settle()
    plate.lift(0.5)

    def seen() -> list[tuple]:
        objects = [bpy.data.objects[name] for name in names]
        rows = [obj.sinew.deformers[0] for obj in objects]
        assert all(row.proxy.users and row.proxy_render.users for row in rows)
        return [
            (row.proxy.name, row.proxy_render.name, evaluated_points(obj).tolist(), row.status_level)
            for obj, row in zip(objects, rows, strict=True)
        ]

    before = seen()
    assert before[0][:2] != before[1][:2]
    push("moved")
    for name in names:
        obj = bpy.data.objects[name]
        for mode in lost:
            obj.sinew.deformers[0].shape(mode).user_remap(obj)
    push("with pointers to the targets themselves")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    assert seen() == before
    assert before[0][3] == "INFO"
    plate.lift(0.5)
    assert close(plate.points()[plate.top], plate.rest()[plate.top] + (0.0, 0.0, 1.0))
