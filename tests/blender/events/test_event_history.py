# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of settings and of control moves, and what is done while a thread binds."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import ALL, MESHES, REGIONS
from inside import bind_in_thread, finish, inner, settle
from mathutils import Matrix
from registry import BY_ID
from rigs import rig as scenes
from rigs.kinds import HandleRig
from test_undo_of_buttons import BUTTONS

Act = Callable[[HandleRig], object]
Shape = Callable[[HandleRig], np.ndarray]


def test_every_operator_has_its_undo_tested():
    """What changes nothing leaves no step. Some are tested where the operator is, one changes the mode."""
    names = set(dir(bpy.ops.sinew))
    with_undo = {n for n in names if "UNDO" in getattr(getattr(bpy.types, f"SINEW_OT_{n}"), "bl_options", ())}
    elsewhere = {"handle_stand", "puppet_pin", "puppet_rig", "armature_off"}
    elsewhere |= {"keep_inside", "refine", "use_factor"}
    assert with_undo == {*elsewhere, "control_edit", *(names & set(BUTTONS) - {"start_task"})}
    without = {"cancel", "check_installation", "diagnose", "help"}
    without |= {"key_jump", "preset_add", "report_renders", "watch"}
    beginnings = {"all_tasks", "choose_method", "drag_press", "drag_start", "start_task"}  # of what has steps
    assert names - with_undo <= without | beginnings


# --- what changes a rig that is lifted by a half, and what is to be seen then


def half(rig: HandleRig) -> np.ndarray:
    return rig.at(0.5)


def at_rest(rig: HandleRig) -> np.ndarray:
    return rig.rest()


def now(rig: HandleRig) -> np.ndarray:
    return rig.now()


def faded(rig: HandleRig) -> np.ndarray:
    return 0.75 * rig.rest() + 0.25 * rig.at(0.5)


def masked(rig: HandleRig) -> np.ndarray:
    """The masked vertices are whole or at rest to the last bit."""
    seen, shown = rig.points(), rig.rest()
    rig.deformer.mask_group = ""
    shown[rig.top] = rig.points()[rig.top]
    rig.deformer.mask_group = "Top"
    assert np.array_equal(seen, shown)
    return shown


def sets(name: str, value: object) -> Act:
    return lambda rig: setattr(rig.deformer, name, value)


def pressed(operator: str) -> Act:
    return lambda rig: rig.press(operator)


def moved(motion: Matrix) -> Act:
    return lambda rig: scenes.move_world(rig.control, motion)


def release(rig: HandleRig) -> None:
    rig.deformer.handles[0].enabled = False


def constrain(rig: HandleRig) -> None:
    rig.control.constraints.new("CHILD_OF").target = scenes.new_empty("Parent")
    scenes.update()


def move_its_parent(rig: HandleRig) -> None:
    constrain(rig)
    scenes.push("constrained")
    bpy.data.objects["Parent"].location.x = 0.3


CHANGES: dict[str, tuple[tuple[str, ...], Act, Shape]] = {
    "set_factor": (ALL, sets("factor", 0.25), faded),
    "set_mask": (MESHES, sets("mask_group", "Top"), masked),
    "stop_live": (ALL, sets("live", False), half),
    "switch_off_its_handle": (REGIONS, release, at_rest),
    "press_bind": (ALL, pressed("bind"), half),
    "press_unbind": (ALL, pressed("unbind"), at_rest),
    "remove_deformer": (ALL, pressed("deformer_remove"), at_rest),
    "change_topology": (ALL, lambda rig: rig.change_topology(), at_rest),
    "move_on": (ALL, moved(Matrix.Translation((0.0, 0.0, 0.25))), lambda rig: rig.at(0.75)),
    "turn": (ALL, moved(Matrix.Rotation(0.4, 4, "X")), now),
    "constrain": (ALL, constrain, now),
    "move_its_parent": (ALL, move_its_parent, now),
}


@pytest.mark.parametrize(
    ("rig", "act", "shape"),
    [pytest.param(kind, *row[1:], id=f"{name}-{kind}") for name, row in CHANGES.items() for kind in row[0]],
    indirect=["rig"],
)
def test_undo_and_redo_on_every_rig(posed: HandleRig, act: Act, shape: Shape):
    scenes.make_active(posed.obj)
    scenes.push("posed")
    act(posed)
    changed, whole = shape(posed), posed.at(0.5)
    scenes.push("changed")
    assert posed.shows(changed)
    for _ in range(2):
        go(bpy.ops.ed.undo, posed, len(whole))
        assert posed.is_right()
        go(bpy.ops.ed.redo, posed, len(changed))
        assert posed.shows(changed)
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


def switch_forth_and_back(rig: HandleRig) -> None:
    method = rig.deformer.method
    rig.deformer.method = next(other for other in (*rig.methods, *BY_ID) if other != method)
    scenes.update()
    rig.deformer.method = method


def delete(rig: HandleRig) -> None:
    scenes.make_active(rig.obj)
    bpy.ops.object.delete()


MEANWHILE: dict[str, tuple[Act, Shape | None]] = {
    "undone": (lambda _rig: bpy.ops.ed.undo(), lambda rig: rig.at(0.0)),
    "saved_and_loaded": (lambda rig: scenes.reopen(rig.folder / "rig.blend"), half),
    "rendered": (lambda rig: rig.renders(rig.at(0.5)) or pytest.fail("the render"), half),
    "frame_changed": (lambda _rig: bpy.context.scene.frame_set(5), half),
    "set_factor": (sets("factor", 0.25), faded),
    "switched_forth_and_back": (switch_forth_and_back, half),
    "press_unbind": (pressed("unbind"), at_rest),
    "deleted": (delete, None),
    "replaced_by_a_new_file": (lambda _rig: scenes.new_file(), None),
}


@pytest.mark.parametrize(("act", "shape"), MEANWHILE.values(), ids=MEANWHILE)
def test_while_a_thread_binds_a_rig_is(rig: HandleRig, monkeypatch, tmp_path: Path, act: Act, shape):
    """What the thread was asked for is no longer wanted, or comes later: the shape is that of now."""
    rig.folder = tmp_path
    rig.start()
    scenes.push("bound")
    rig.lift(0.5)
    scenes.push("posed")
    bind_in_thread(rig.obj, rig.deformer, monkeypatch)
    act(rig)
    assert finish()
    if shape is None:
        assert inner.owners.owners() == []
        rig, shape = type(rig).new("Fresh").start(), now
    assert rig.shows(shape(rig))
    assert not inner.binding.busy()


# --- pointers
# Blender's undo may bring back a pointer to a removed object as one to the object that holds the pointer.
# Whether it does depends on where Blender puts things in memory, so the tests make such a step themselves.


@pytest.mark.parametrize("lost", [("VIEWPORT",), ("RENDER",), ("VIEWPORT", "RENDER")], ids=str)
def test_a_deformer_finds_its_hidden_shapes_again(plate: scenes.Rig, lost: tuple[str, ...]):
    """So does a copy."""
    plate.bind()
    names = plate.name, scenes.duplicated(plate.obj).name
    settle()
    plate.lift(0.5)

    def seen() -> list[tuple]:
        objects = [bpy.data.objects[name] for name in names]
        rows = [obj.sinew.deformers[0] for obj in objects]
        assert all(row.proxy.users and row.proxy_render.users for row in rows)
        return [
            (row.proxy.name, row.proxy_render.name, scenes.evaluated_points(obj).tolist(), row.status_level)
            for obj, row in zip(objects, rows, strict=True)
        ]

    before = seen()
    assert before[0][:2] != before[1][:2]
    scenes.push("moved")
    for name in names:
        obj = bpy.data.objects[name]
        for mode in lost:
            obj.sinew.deformers[0].shape(mode).user_remap(obj)
    scenes.push("with pointers to the targets themselves")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    assert seen() == before
    assert before[0][3] == "INFO"
    plate.lift(0.5)
    assert scenes.close(plate.points()[plate.top], plate.rest()[plate.top] + (0.0, 0.0, 1.0))
