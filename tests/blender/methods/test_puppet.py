# SPDX-License-Identifier: GPL-3.0-or-later
"""Puppets: bones that are dragged and the figure that follows, pins, limits, and the skin."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import inner
from libraries import put_into_a_library, read
from mathutils import Matrix, Vector
from mouse import event, front_view
from rigs.puppets import BONES, FEET, end_of, figure, pose, standing
from rigs.rig import close, curves_of, linked, new_empty, new_file, refused, reopen, update

PLACES = 2e-5  # rotations go through float32 channels, from bone to bone


def channels(armature: bpy.types.Object) -> np.ndarray:
    names = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle")
    return np.array([np.concatenate([getattr(bone, name) for name in names]) for bone in armature.pose.bones])


def lengths(armature: bpy.types.Object) -> np.ndarray:
    ends = [(end_of(armature, name), end_of(armature, name, "head")) for name in BONES]
    return np.linalg.norm([tail - head for tail, head in ends], axis=1)


# Dragging


PLACED = Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.7, 4, (1, 2, 3)) @ Matrix.Scale(2.0, 4)
HERE = Matrix.Identity(4)


@pytest.mark.parametrize(
    ("mode", "world"),
    [("QUATERNION", HERE), ("XYZ", HERE), ("ZXY", HERE), ("AXIS_ANGLE", HERE), ("QUATERNION", PLACED)],
)
def test_a_hand_is_dragged_and_the_arm_follows(mode: str, world: Matrix):
    """By the numbers of the world, also where the armature is turned, moved and scaled."""
    armature = figure(mode)
    armature.matrix_world = world
    root, place, before = end_of(armature, "hip", "head"), end_of(armature, "hand.L"), lengths(armature)
    pose(armature, "hand.L", (-0.2, -0.3, 0.1))
    assert close(end_of(armature, "hand.L"), place + (-0.2, -0.3, 0.1), 2e-3)  # rest counts a little, too
    assert close(lengths(armature), before, PLACES)
    assert close(end_of(armature, "hip", "head"), root)  # that nothing holds stays
    legs = [armature.pose.bones[name] for name in BONES if "thigh" in name or "shin" in name]
    assert all(bone.matrix_basis == Matrix.Identity(4) for bone in legs)


def test_a_second_drag_begins_where_the_first_one_ended():
    armature = standing()
    pose(armature, "hip", (0.0, 0.0, -0.2))
    hip = end_of(armature, "hip", "head")
    pose(armature, "hand.L", (-0.1, -0.2, 0.1))
    assert np.linalg.norm(end_of(armature, "hip", "head") - hip) < 0.1  # not back at 1
    pose(armature, "hand.L", (0.0, 0.0, 0.0), from_rest=True)
    assert end_of(armature, "hip", "head")[2] == pytest.approx(1.0, abs=0.1)


def shown(armature: bpy.types.Object, name: str) -> np.ndarray:
    """How a bone is shown, (4, 4) in the world."""
    update()
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(posed.matrix_world @ posed.pose.bones[name].matrix)


@pytest.mark.parametrize("name", ["hip", "chest", "hand.L"])
def test_a_whole_bone_turns_about_its_own_length(name: str):
    armature = standing()
    before = shown(armature, name)
    pose(armature, name, part="WHOLE", mode="ROTATE", angle=0.4, axis=tuple(before[:3, 1]))
    turn = Matrix((shown(armature, name) @ np.linalg.inv(before))[:3, :3]).to_quaternion()
    assert turn.angle == pytest.approx(0.4, abs=0.02)
    assert abs(turn.axis.dot(Vector(before[:3, 1]))) > 0.999


@pytest.mark.parametrize(
    ("pinned", "bone", "value"),
    [
        (FEET, "hip", (0.05, 0.0, -0.3)),
        (FEET, "hip", (0.2, -0.15, -0.1)),
        (FEET, "hand.L", (-0.2, -0.4, -0.5)),
        (("foot.L", "shin.R"), "hand.L", (0.2, -0.2, 0.3)),
        (("lower.L", "hip"), "hand.L", (-0.05, 0.05, 0.02)),
    ],
)
def test_pinned_bones_are_held_as_a_whole(pinned, bone: str, value):
    armature = figure()
    for name in pinned:
        armature.pose.bones[name].sinew.pin = True
    armature.pose.bones["shin.L"].rotation_quaternion = Matrix.Rotation(0.3, 3, "X").to_quaternion()
    before, place = [shown(armature, name) for name in pinned], end_of(armature, bone)
    pose(armature, bone, value)
    after = [shown(armature, name) for name in pinned]
    assert close(np.array(after), np.array(before), 5e-3)  # pins count much, but not infinitely
    assert np.dot(end_of(armature, bone) - place, value) > 0.8 * np.dot(value, value)


# Limits


def bent(bone: bpy.types.PoseBone, order: str = "XYZ") -> np.ndarray:
    return np.array(bone.matrix_basis.to_euler(order))


def limit_ik(bone: bpy.types.PoseBone, **limits: tuple[float, float]) -> None:
    for axis, (least, most) in limits.items():
        setattr(bone, f"use_ik_limit_{axis}", True)
        setattr(bone, f"ik_min_{axis}", least)
        setattr(bone, f"ik_max_{axis}", most)


def limit_rotation(bone: bpy.types.PoseBone, **limits: tuple[float, float]) -> bpy.types.Constraint:
    limit = bone.constraints.new("LIMIT_ROTATION")
    limit.owner_space = "LOCAL"
    for axis, (least, most) in limits.items():
        setattr(limit, f"use_limit_{axis}", True)
        setattr(limit, f"min_{axis}", least)
        setattr(limit, f"max_{axis}", most)
    return limit


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "YZX"])
def test_limits_of_inverse_kinematics_are_never_exceeded(mode: str):
    armature, rng = standing(mode), np.random.default_rng(5)
    bones = [armature.pose.bones[name] for name in ("upper.L", "lower.L", "spine", "shin.L", "thigh.R")]
    for bone in bones:
        limit_ik(bone, x=(-0.3, 0.4), y=(-0.1, 0.1), z=(-0.2, 0.6))
    least, most, reached = np.array((-0.3, -0.1, -0.2)), np.array((0.4, 0.1, 0.6)), 0
    for _ in range(6):
        pose(armature, "hand.L", tuple(rng.normal(size=3) * 0.5), from_rest=True)
        for bone in bones:
            angles = bent(bone, mode if mode != "QUATERNION" else "XYZ")
            # One rounding of an angle that went through a float32 quaternion or matrix.
            assert (angles >= least - 1e-6).all(), (bone.name, angles)
            assert (angles <= most + 1e-6).all(), (bone.name, angles)
            reached += bool((np.abs(angles - most) < 1e-5).any())
    assert reached > 3  # they were needed


def test_limit_rotation_changes_nothing_of_what_a_drag_shows():
    armature = figure("XYZ")
    bones = [armature.pose.bones[name] for name in ("upper.L", "lower.L", "chest")]
    limits = [limit_rotation(bone, **dict.fromkeys("xyz", (-0.1, 0.2))) for bone in bones]
    pose(armature, "hand.L", (-0.6, -0.6, 0.3))
    shown = end_of(armature, "hand.L")
    for limit in limits:
        limit.mute = True
    assert close(end_of(armature, "hand.L"), shown, PLACES)
    angles = np.array([bone.rotation_euler for bone in bones])
    assert (np.minimum(np.abs(angles - 0.2), np.abs(angles + 0.1)) < 1e-6).any()  # they were needed


def test_of_limits_that_contradict_each_other_limit_rotation_wins():
    armature = figure("XYZ")
    bone = armature.pose.bones["lower.L"]
    limit_ik(bone, x=(-0.2, -0.1), z=(-1.0, 0.3))
    limit_rotation(bone, x=(0.1, 0.2), z=(-0.2, 1.0))
    pose(armature, "hand.L", (-0.4, 0.3, 0.4))
    assert 0.1 - 1e-6 <= bone.rotation_euler.x <= 0.2 + 1e-6  # Limit Rotation, as the two exclude each other
    assert -0.2 - 1e-6 <= bone.rotation_euler.z <= 0.3 + 1e-6  # both


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ"])
def test_locked_channels_stay(mode: str):
    armature = figure(mode)
    bone = armature.pose.bones["lower.L"]
    bone.matrix_basis = Matrix.Rotation(0.2, 4, "Y")
    bone.lock_rotation = (False, True, False)
    armature.pose.bones["upper.L"].lock_rotation = (True, True, True)
    armature.pose.bones["spine"].lock_ik_x = True
    update()
    pose(armature, "hand.L", (-0.3, -0.2, 0.2))
    assert bent(bone)[1] == pytest.approx(0.2, abs=1e-6)
    assert np.abs(bent(armature.pose.bones["upper.L"])).max() < 1e-6
    assert abs(bent(armature.pose.bones["spine"])[0]) < 1e-6
    assert np.abs(bent(armature.pose.bones["chest"])).max() > 1e-2
    assert armature.pose.bones["hip"].location == Vector((0.0, 0.0, 0.0))


def test_a_stiff_joint_turns_less():
    turned = []
    for stiffness in (0.0, 0.95):
        new_file()
        armature = figure()
        bone = armature.pose.bones["upper.L"]
        bone.ik_stiffness_x = bone.ik_stiffness_y = bone.ik_stiffness_z = stiffness
        pose(armature, "hand.L", (-0.3, -0.2, 0.2))
        turned.append(bone.matrix_basis.to_quaternion().angle)
    assert turned[1] < 0.5 * turned[0]


# What holds the figure


def test_the_target_of_a_chain_holds_its_bone():
    armature = figure()
    target = new_empty("Target", BONES["shin.L"][1])
    constraint = armature.pose.bones["shin.L"].constraints.new("IK")
    constraint.target, constraint.chain_count = target, 2
    update()
    pose(armature, "hip", (0.0, 0.0, -0.2))
    assert close(end_of(armature, "shin.L"), np.array(BONES["shin.L"][1]), 1e-3)
    constraint.mute = True  # the pose alone holds it there, too
    assert close(end_of(armature, "shin.L"), np.array(BONES["shin.L"][1]), 1e-3)
    constraint.mute = False
    refused("shin.L follows its target Target", "puppet_pose", bone="shin.L", value=(0.0, 0.0, 0.1))


def test_balance_keeps_the_centre_of_mass_over_the_feet():
    centres = []
    for balance in (False, True):
        new_file()
        armature = standing()
        pose(armature, "hand.L", (0.5, -0.9, -0.3), balance=balance)
        weights = np.linalg.norm([np.subtract(tail, head) for head, tail, _parent in BONES.values()], axis=1)
        middles = [(end_of(armature, name) + end_of(armature, name, "head")) / 2 for name in BONES]
        centres.append(np.average(middles, axis=0, weights=weights))
    (falling_x, falling_y, _), (x, y, _) = centres
    assert falling_y < -0.201 or abs(falling_x) > 0.121  # without, it would fall
    assert abs(x) <= 0.121
    assert -0.201 <= y <= 1e-3


def test_with_mirror_the_other_side_follows() -> None:
    """Unless it is pinned, or moves itself. The hip turns with the leg that is dragged, and has no image."""
    armature, flip = figure("XYZ"), np.diag((-1.0, 1.0, 1.0, 1.0))
    armature.pose.use_mirror_x = True
    pose(armature, "foot.L", (0.2, -0.3, 0.2), key=True)
    for name in ("thigh", "shin", "foot"):
        moved, image = (np.array(armature.pose.bones[f"{name}.{side}"].matrix_basis) for side in "LR")
        assert np.abs(moved - np.eye(4)).max() > 0.01
        assert np.allclose(flip @ moved @ flip, image, atol=1e-5)
    assert any('"shin.R"' in curve.data_path for curve in curves_of(armature))
    armature.pose.bones["foot.R"].sinew.pin = True
    held = end_of(armature, "foot.R")
    pose(armature, "foot.L", (0.1, 0.0, 0.0))
    assert close(end_of(armature, "foot.R"), held, 2e-3)


def test_bones_are_pinned_and_released():
    armature = figure()
    bpy.ops.object.mode_set(mode="POSE")
    for bone in armature.pose.bones:
        inner.compat.select_bone(armature, bone.name, bone.name in FEET)
    for action, pinned in (("TOGGLE", set(FEET)), ("PIN", set(FEET)), ("TOGGLE", set())):
        assert bpy.ops.sinew.puppet_pin(action=action) == {"FINISHED"}
        assert {bone.name for bone in armature.pose.bones if bone.sinew.pin} == pinned
    for name in FEET:
        inner.compat.select_bone(armature, name, False)
    refused("Select the bones to pin", "puppet_pin")


def test_pins_are_saved(tmp_path: Path):
    standing()
    reopen(tmp_path / "figure.blend")
    bones = bpy.data.objects["Figure"].pose.bones
    assert {bone.name for bone in bones if bone.sinew.pin} == set(FEET)


def test_bones_are_keyed_if_asked_or_with_auto_keying():
    armature = standing()
    pose(armature, "hip", (0.0, 0.0, -0.1))
    assert armature.animation_data is None
    pose(armature, "hip", (0.0, 0.0, -0.1), key=True)
    keyed = {curve.data_path for curve in curves_of(armature)}
    assert 'pose.bones["hip"].location' in keyed
    assert 'pose.bones["shin.L"].rotation_quaternion' in keyed
    assert not any("hand" in path for path in keyed)
    low, scene = end_of(armature, "hip"), bpy.context.scene
    scene.frame_set(10)
    scene.tool_settings.use_keyframe_insert_auto = True
    pose(armature, "hip", (0.0, 0.0, 0.2))
    scene.tool_settings.use_keyframe_insert_auto = False
    high = end_of(armature, "hip")
    assert high[2] > low[2] + 0.15
    for frame, place in ((1, low), (10, high)):
        scene.frame_set(frame)
        assert close(end_of(armature, "hip"), place, 1e-5)


# What is refused


def test_bones_that_do_not_inherit_rotation_are_in_the_way_of_their_own_chain_alone():
    armature = figure()
    armature.data.bones["chest"].use_inherit_rotation = False
    update()
    pose(armature, "thigh.L", (0.1, 0.0, 0.0))


def test_linked_armatures(tmp_path: Path):
    path = put_into_a_library(tmp_path / "library.blend", figure())
    armature = linked(read(path, True, "objects", "Figure"))
    said = "Figure is linked - make a library override first"
    refused(said, "puppet_pose", armature, bone="hand.L", value=(0.0, 0.0, 0.1))


# The mouse


class Mouse:
    """The tool itself, with events like Blender's: there is no window here."""

    def __init__(self, armature: bpy.types.Object, bone: str) -> None:
        typed, posing, axes = inner.typed_motion, inner.posing, np.eye(3)
        self.armature, self.x, self.y, self.view = armature, 0.0, 0.0, front_view(centre=(0.0, 0.0))
        graph = bpy.context.evaluated_depsgraph_get()
        drag = posing.PuppetDrag(armature, bone, graph, posing.PuppetOptions())
        motion = typed.TypedMotion(
            inner.motion.Mode.TRANSLATE, self.view, axes, (0.0, 0.0), 1.0, 1.0, math.pi / 180.0
        )
        self.tool = inner.puppeteering.Puppeteering(drag, motion, drag.place, axes)

    def send(self, kind: str, value: str = "PRESS", unicode: str = ""):
        sent = event(kind, value, self.x, self.y, unicode)
        return self.tool.process(self.armature, sent, self.view).value

    def go(self, x: float, y: float) -> np.ndarray:
        self.x, self.y = x, y
        assert self.send("MOUSEMOVE", "NOTHING") == "GO_ON"
        return channels(self.armature)


def test_the_mouse_drags_and_a_click_keeps():
    armature = standing()
    goal = end_of(armature, "hand.L") + (-0.2, 0.0, 0.1)
    mouse = Mouse(armature, "hand.L")
    mouse.go(-20.0, 10.0)
    assert close(end_of(armature, "hand.L"), goal, 3e-3)
    assert mouse.send("LEFTMOUSE") == "CONFIRMED"
    assert close(end_of(armature, "hand.L"), goal, 3e-3)


def test_the_same_place_gives_the_same_bits_and_escape_puts_everything_back():
    armature = standing("XYZ")
    pose(armature, "hand.L", (-0.1, -0.1, 0.0))
    before = channels(armature)
    mouse = Mouse(armature, "hip")
    first = mouse.go(10.0, -30.0)
    for angle in np.linspace(0.0, 6.0, 9):
        assert not np.array_equal(mouse.go(50.0 * math.sin(angle), 40.0 * math.cos(angle)), first)
    assert np.array_equal(mouse.go(10.0, -30.0), first)
    assert np.abs(mouse.go(0.0, 0.0) - before).max() < 1e-6
    assert mouse.send("ESC") == "CANCELLED"
    assert np.array_equal(channels(armature), before)


def test_axes_and_numbers_are_typed():
    armature = standing()
    hip = end_of(armature, "hip", "head")
    mouse = Mouse(armature, "hip")
    mouse.go(5.0, 5.0)
    for kind, text in (("Z", "z"), ("MINUS", "-"), ("PERIOD", "."), ("TWO", "2")):
        mouse.send(kind, unicode=text)
    assert mouse.send("RET") == "CONFIRMED"
    assert close(end_of(armature, "hip", "head"), hip + (0.0, 0.0, -0.2), 3e-3)
