# SPDX-License-Identifier: GPL-3.0-or-later
"""The order of deformers and handles: list, modifier stack and animation move together."""

import bpy
import numpy as np
import pytest
from inside import inner
from mathutils import Matrix
from rigs import rig as scenes


def three_deformers(plate: scenes.Rig) -> bpy.types.Object:
    """Deformers A, B, C with a handle each, an Armature on top and a Smooth between A and B."""
    obj = plate.obj
    obj.modifiers.new("First", "ARMATURE")
    plate.bind()
    obj.modifiers.new("Between", "SMOOTH").factor = 0.0
    for name, where in (("Left", lambda p: p[0] < -0.75), ("Right", lambda p: p[0] > 0.75)):
        scenes.add_group(obj, name, where)
        scenes.add_regions(obj, "thin_shell", {name: "HANDLE"})
    for deformer, name in zip(obj.sinew.deformers, "ABC", strict=True):
        deformer.name = name
    return obj


def names(obj: bpy.types.Object) -> str:
    return "".join(deformer.name for deformer in obj.sinew.deformers)


def stack(obj: bpy.types.Object) -> list[str]:
    """Names of the modifiers; those of deformers by the deformer they show."""
    find = inner.modified.shown_by
    labels = {find(obj, deformer).name: deformer.name for deformer in obj.sinew.deformers}
    return [labels.get(modifier.name, modifier.name) for modifier in obj.modifiers]


def test_modifiers_follow_the_list_and_others_keep_their_place(plate: scenes.Rig):
    """A move past the end does nothing."""
    obj = three_deformers(plate)
    assert stack(obj) == ["First", "A", "Between", "B", "C"]
    assert bpy.ops.sinew.deformer_move(direction="UP", index=0) == {"CANCELLED"}
    assert bpy.ops.sinew.deformer_move(direction="DOWN", index=2) == {"CANCELLED"}
    assert bpy.ops.sinew.handle_move(direction="UP", index=0) == {"CANCELLED"}
    scenes.refused("3 deformers", "deformer_move", direction="UP", index=3)
    assert names(obj) == "ABC"
    assert bpy.ops.sinew.deformer_move(direction="UP", index=2) == {"FINISHED"}
    assert names(obj) == "ACB"
    assert stack(obj) == ["First", "A", "Between", "C", "B"]
    obj.sinew.active_deformer = 0
    bpy.ops.sinew.deformer_move(direction="DOWN")
    assert names(obj) == "CAB"
    assert obj.sinew.active.name == "A"
    assert stack(obj) == ["First", "C", "Between", "A", "B"]


def test_a_modifier_dragged_by_the_user_falls_in_line_with_the_list(plate: scenes.Rig):
    obj = three_deformers(plate)
    last = obj.modifiers[-1].name
    bpy.ops.object.modifier_move_to_index(modifier=last, index=0)
    assert stack(obj) == ["C", "First", "A", "Between", "B"]
    scenes.move_world(obj.sinew.deformers[2].handles[0].control, Matrix.Translation((0.0, 0.0, 0.5)))
    right = plate.rest()[:, 0] > 0.75
    assert np.abs(plate.points()[right, 2]).max() == pytest.approx(0.5, abs=0.05)
    assert all(deformer.status_level == "INFO" for deformer in obj.sinew.deformers)
    bpy.ops.sinew.deformer_move(direction="DOWN", index=0)
    assert names(obj) == "BAC"
    assert stack(obj) == ["B", "First", "A", "Between", "C"]


def keyed(obj: bpy.types.Object) -> None:
    second, third = obj.sinew.deformers[1:]
    scenes.key(second, {1: {"factor": 0.0}, 11: {"factor": 1.0}})
    scenes.key(third.handles[0], {1: {"weight": 0.0}, 11: {"weight": 1.0}})


def values(obj: bpy.types.Object) -> dict[tuple[str, int], tuple[float, float]]:
    found = {}
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        for row in obj.sinew.deformers:
            found[row.name, frame] = (round(row.factor, 4), round(row.handles[0].weight, 4))
    return found


def test_keyframes_stay_with_their_deformer_and_go_with_it(plate: scenes.Rig):
    obj = three_deformers(plate)
    keyed(obj)
    before = values(obj)
    assert before["B", 6][0] == pytest.approx(0.5, abs=0.01)
    bpy.ops.sinew.deformer_move(direction="UP", index=1)
    bpy.ops.sinew.deformer_move(direction="UP", index=2)
    assert names(obj) == "BCA"
    assert values(obj) == before
    for index, left in ((2, "BC"), (0, "C")):
        bpy.ops.sinew.deformer_remove(index=index)
        assert names(obj) == left
        assert values(obj) == {of: pair for of, pair in before.items() if of[0] in left}
    assert values(obj)["C", 1][0] == 1.0  # B's keyframes of Factor went with B


def two_handles_with_animation(plate: scenes.Rig) -> bpy.types.Object:
    """Top's weight is keyed and drives Reader's x, Base's weight is driven by Source's x."""
    obj = plate.bind().obj
    handles = plate.deformer.handles
    scenes.key(handles[0], {1: {"weight": 0.2}, 11: {"weight": 0.8}})
    reader, source = scenes.new_empty("Reader"), scenes.new_empty("Source", (0.5, 0.0, 0.0))
    drive(reader.driver_add("location", 0).driver, obj, "sinew.deformers[0].handles[0].weight")
    drive(handles[1].driver_add("weight").driver, source, "location.x")
    return obj


def drive(driver: bpy.types.Driver, source: bpy.types.Object, path: str) -> None:
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id, target.data_path = source, path


def weights(obj: bpy.types.Object, frame: int) -> dict[str, float]:
    """Evaluated weights by name of handle, and what Reader reads, at a frame."""
    bpy.context.scene.frame_set(frame)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    found = {handle.name: round(handle.weight, 4) for handle in evaluated.sinew.deformers[0].handles}
    return {**found, "Reader": round(bpy.data.objects["Reader"].location.x, 4)}


def test_keyframes_and_drivers_stay_with_their_handle(plate: scenes.Rig):
    obj = two_handles_with_animation(plate)
    assert weights(obj, 1) == {"Top": 0.2, "Base": 0.5, "Reader": 0.2}
    bpy.ops.sinew.handle_move(direction="DOWN", index=0)
    assert obj.sinew.active.handles.keys() == ["Base", "Top"]
    assert weights(obj, 11) == {"Top": 0.8, "Base": 0.5, "Reader": 0.8}
    bpy.data.objects["Source"].location.x = 0.25
    assert weights(obj, 1) == {"Top": 0.2, "Base": 0.25, "Reader": 0.2}


def test_drivers_that_read_a_control_follow_its_row(plate: scenes.Rig):
    """Whichever kind of control a list of them belongs to; rows of other deformers, and handles, stay."""
    obj, paths = plate.obj, inner.animation_paths
    for name in ("First", "Second"):
        obj.sinew.deformers.add().uid = name
    rows = ["[0].controls[1].owned", "[1].controls[1].owned"]
    rows += ["[0].handles[1].weight", "[0].controls[0].owned"]
    obj["read"] = [0.0] * len(rows)
    for index, row in enumerate(rows):
        drive(obj.driver_add('["read"]', index).driver, obj, f"sinew.deformers{row}")
    paths.rows_reordered(obj, obj.sinew.deformers[0], "controls", paths.moved(2, 0, 1))
    read = [curve.driver.variables[0].targets[0].data_path for curve in obj.animation_data.drivers]
    assert read == [f"sinew.deformers{row}" for row in (rows[3], rows[1], rows[2], rows[0])]


def test_keyframes_of_a_removed_handle_go(plate: scenes.Rig):
    obj = two_handles_with_animation(plate)
    bpy.ops.sinew.handle_remove(index=0)
    (base,) = obj.sinew.active.handles
    assert base.name == "Base"
    driven = {curve.data_path for curve in obj.animation_data.drivers if "handles" in curve.data_path}
    assert driven == {"sinew.deformers[0].handles[0].weight"}
    assert not [curve for curve in scenes.curves_of(obj) if "handles" in curve.data_path]
    bpy.context.scene.frame_set(6)
    assert base.weight == pytest.approx(0.5, abs=1e-6)  # Source drives it, and Top's keyframes do not


def test_a_shared_action_slot_of_another_object_is_left_alone(plate: scenes.Rig):
    """From Blender 4.4 an action animates several objects, each by a slot of its own."""
    obj = three_deformers(plate)
    keyed(obj)
    action = obj.animation_data.action
    if not hasattr(action, "slots"):
        pytest.skip("actions have no slots here")
    other = scenes.linked(obj.copy())
    other.animation_data.action_slot = action.slots.new("OBJECT", "Other")
    scenes.update()
    other.sinew.deformers[1].factor = 0.25
    other.sinew.deformers[1].keyframe_insert("factor", frame=1)
    scenes.press(obj, "deformer_move", direction="UP", index=1)
    bag = action.layers[0].strips[0].channelbag(other.animation_data.action_slot)
    assert [curve.data_path for curve in bag.fcurves] == ["sinew.deformers[1].factor"]
