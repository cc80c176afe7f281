# SPDX-License-Identifier: GPL-3.0-or-later
"""Reset Pose brings every kind of control back to rest, and Key Pose keys all of them."""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from rigs import rig as scenes
from rigs.kinds import RIGS, CageRig

REST = 1e-6  # of shapes of about the size of 1
MOVE = Matrix.Translation((0.3, -0.2, 0.7)) @ Matrix.Rotation(0.6, 4, (0.2, 0.5, 0.9)) @ Matrix.Scale(1.2, 4)


def stretched(control: bpy.types.Object) -> None:
    """Its points are edited by hand, if it has some."""
    if control.type != "EMPTY":
        scenes.on_all(control, bpy.ops.transform.resize, value=(1.1, 0.9, 1.2))


def by_a_shape_key(control: bpy.types.Object) -> None:
    if control.type in ("MESH", "LATTICE"):
        scenes.add_key(control, "Bent", Matrix.Diagonal((1.3, 1.0, 1.0, 1.0))).value = 1.0


def edited_in_its_mode(control: bpy.types.Object) -> None:
    stretched(control)
    scenes.make_active(control)
    if control.type != "EMPTY":
        bpy.ops.object.mode_set(mode="EDIT")


def moved(control: bpy.types.Object) -> None:
    scenes.move_world(control, MOVE)


@pytest.mark.parametrize("kind", RIGS)
@pytest.mark.parametrize("pose", [moved, stretched, by_a_shape_key, edited_in_its_mode])
def test_every_control_rests(kind: str, pose: Callable) -> None:
    rig = RIGS[kind].new().start()
    rig.lift()
    pose(rig.control)
    scenes.update()
    assert not rig.is_at_rest()
    assert bpy.ops.sinew.reset_pose() == {"FINISHED"}
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(rig.points() - rig.rest()).max() <= REST


def test_a_tool_rests_without_its_path() -> None:
    rig = RIGS["tools"].new().start()
    for _ in range(2):
        rig.lift(0.2)
        rig.press("tool_stop")
    rig.press("reset_pose")
    assert np.abs(rig.points() - rig.rest()).max() <= REST
    rig.lift(-0.4)
    assert rig.shows(rig.at(-0.4)), "it goes straight again"


def test_a_path_of_bones_rests(plate: scenes.Rig) -> None:
    """The second bone is a child of the first, and both are posed."""
    armature = scenes.new_armature(low=((0, -1, 0), (0, 0, 0)), high=((0, 0, 0), (0, 1, 0), "low"))
    for group, bone in (("Base", "low"), ("Top", "high")):
        scenes.press(
            plate.obj, "handle_add", kind="HANDLE", vertex_group=group, control_object="Rig", bone=bone
        )
        armature.pose.bones[bone].rotation_euler = (0.5, 0.2, -0.3)
    assert not scenes.close(plate.points(), plate.rest(), 0.1)
    scenes.in_pose_mode(armature, "high", plate.obj)
    assert bpy.ops.sinew.reset_pose(selected=True) == {"FINISHED"}
    scenes.update()
    low, high = armature.pose.bones
    assert np.abs(low.rotation_euler.x - 0.5) < REST
    placed = plate.obj.matrix_world.inverted() @ armature.matrix_world @ high.matrix
    assert scenes.close(np.array(placed), np.array(plate.deformer.handles[1].rest_matrix), 1e-5)
    bpy.ops.sinew.reset_pose()
    assert np.abs(plate.points() - plate.rest()).max() <= REST
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_control_that_rides_goes_back_onto_the_surface(plate: scenes.Rig) -> None:
    armature = scenes.add_armature(plate.obj)
    plate.bind()
    assert plate.deformer.handles[0].stands_on == "SURFACE"
    armature.pose.bones["high"].rotation_euler.x = 1.0
    posed = plate.points()
    plate.lift(0.4)
    assert not scenes.close(plate.points(), posed, 0.1)
    plate.control.lock_location[0] = True
    scenes.press(plate.obj, "reset_pose")
    assert np.abs(plate.points() - posed).max() <= REST
    assert plate.control.matrix_basis == Matrix.Identity(4)


def test_what_something_else_poses_is_named(bound_plate: scenes.Rig, capfd) -> None:
    held = bound_plate.control.constraints.new("COPY_LOCATION")
    held.target = scenes.new_empty("Elsewhere", (0.0, 0.0, 3.0))
    scenes.press(bound_plate.obj, "reset_pose")
    assert f"Something else poses {bound_plate.control.name}" in "".join(capfd.readouterr())


@pytest.mark.parametrize("kept", [None, 3, {}, {"place": [1.0], "points": b"", "values": {}}])
@pytest.mark.parametrize("kind", ["cage", "lattice"])
def test_files_of_earlier_builds_have_the_shape_of_rest(kind: str, kept: object) -> None:
    """Their rest meshes do not tell where the object was, nor do those that somebody has spoiled."""
    rig = RIGS[kind].new().start()
    row = rig.deformer.controls[0] if len(rig.deformer.controls) else None
    rest = rig.deformer.cage_rest if row is None else row.rest
    del rest["sinew_pose"]
    if kept is not None:
        rest["sinew_pose"] = kept
    rig.lift()
    rig.press("reset_pose")
    assert scenes.close(rig.points(), rig.rest(), 2e-6)


def test_it_rests_after_apply_and_in_a_file(tmp_path) -> None:
    rig = RIGS["cage"].new().start()
    rig.obj.location, rig.obj.rotation_euler = (1.0, 2.0, 0.5), (0.3, 0.2, 0.1)
    scenes.update()
    rig.press("bind")
    rig.press("cage_set_rest")
    expected = scenes.apply_matrix(rig.obj.matrix_world, rig.points())
    scenes.make_active(rig.obj)
    bpy.ops.object.transform_apply()
    scenes.reopen(tmp_path / "applied.blend")
    scenes.move_world(rig.control, MOVE)
    stretched(rig.control)
    rig.press("reset_pose")
    assert scenes.close(rig.points(), expected, 1e-5)


# Keys


def keyed(control: bpy.types.ID) -> list[str]:
    return sorted({curve.data_path for curve in scenes.curves_of(control)})


def test_auto_keying_keys_what_rests(bound_plate: scenes.Rig, monkeypatch) -> None:
    bound_plate.lift()
    with monkeypatch.context() as patch:
        patch.setattr(bpy.context.scene.tool_settings, "use_keyframe_insert_auto", True)
        scenes.press(bound_plate.obj, "reset_pose")
    assert keyed(bound_plate.control) == ["location", "rotation_euler", "scale"]
    bpy.context.scene.frame_set(10)
    assert bound_plate.control.location == Vector()


def test_key_pose_keys_both_sides_and_says_what_it_cannot_key(capfd) -> None:
    obj = scenes.grid_object()
    for name, side in (("Hand.L", 1.0), ("Hand.R", -1.0)):
        scenes.add_group(obj, name, lambda point, side=side: side * point[0] > 0.75)
        scenes.press(obj, "handle_add", kind="HANDLE", vertex_group=name)
    scenes.press(obj, "key_pose")
    for handle in obj.sinew.active.handles:
        assert keyed(handle.control) == ["location", "rotation_euler", "scale"]
    rig = CageRig.new().start()
    rig.press("key_pose")
    assert "The points of Cage are not keyed" in "".join(capfd.readouterr())
    by_a_shape_key(rig.control)
    rig.press("key_pose")
    bent = rig.control.data.shape_keys.key_blocks["Bent"]
    bent.value = 0.3
    bpy.context.scene.frame_set(10)
    assert bent.value == 1.0, "it was keyed"
