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
from rigs.rig import (
    close,
    curves_of,
    linked,
    new_empty,
    new_file,
    refused,
    reopen,
    update,
)

PLACES = 2e-5  # rotations go through float32 channels, from bone to bone


def channels(armature: bpy.types.Object) -> np.ndarray:
    return np.array(
        [
            (*bone.location, *bone.rotation_quaternion, *bone.rotation_euler, *bone.rotation_axis_angle)
            for bone in (armature.pose.bones if armature.pose else ())
        ]
    )


def lengths(armature: bpy.types.Object) -> np.ndarray:
    return np.array(
        [np.linalg.norm(end_of(armature, name) - end_of(armature, name, "head")) for name in BONES]
    )


# Dragging


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "ZXY", "AXIS_ANGLE"])
def test_a_hand_is_dragged_and_the_arm_follows(mode: str):
    armature = figure(mode)
    before, place = lengths(armature), end_of(armature, "hand.L")
    pose(armature, "hand.L", (-0.2, -0.3, 0.1))
    assert close(end_of(armature, "hand.L"), place + (-0.2, -0.3, 0.1), 2e-3)  # rest counts a little, too
    assert close(lengths(armature), before, PLACES)
    assert close(
        end_of(armature, "hip", "head"), np.array((0.0, 0.0, 1.0))
    )  # a root that nothing holds stays
    legs = [armature.pose.bones[name] for name in BONES if "thigh" in name or "shin" in name]
    assert all(bone.matrix_basis == Matrix.Identity(4) for bone in legs)


def test_pinned_feet_stay_when_the_hip_sinks_and_the_knees_bend():
    armature = standing()
    feet = [end_of(armature, name, end) for name in FEET for end in ("head", "tail")]
    pose(armature, "hip", (0.05, 0.0, -0.3))
    assert close(end_of(armature, "hip", "head"), np.array((0.05, 0.0, 0.7)), 5e-3)
    assert close(end_of(armature, "hip"), np.array((0.05, 0.0, 0.9)), 5e-3)  # upright: the whole bone moved
    now = [end_of(armature, name, end) for name in FEET for end in ("head", "tail")]
    assert close(np.array(now), np.array(feet), 1e-4)
    for side in "LR":
        assert armature.pose.bones[f"shin.{side}"].matrix_basis.to_quaternion().angle > 0.5


def test_a_pulled_hand_takes_the_body_along_and_leaves_the_feet():
    armature = standing()
    feet = np.array([end_of(armature, name) for name in FEET])
    pose(armature, "hand.L", (0.4, -0.3, -0.4))
    assert np.linalg.norm(end_of(armature, "hip", "head") - (0.0, 0.0, 1.0)) > 0.05
    assert close(np.array([end_of(armature, name) for name in FEET]), feet, 2e-3)


def test_what_is_out_of_reach_is_approached():
    armature = figure()
    root = end_of(armature, "hip", "head")
    pose(armature, "hand.L", (5.0, 0.0, 0.0))
    hand = end_of(armature, "hand.L")
    goal = np.array((5.85, 0.0, 1.55))
    # No bone could get nearer: they all point at the goal, but for the shoulder, whose place is fixed.
    assert np.linalg.norm(hand - root) > 1.2
    assert np.linalg.norm(goal - hand) < np.linalg.norm(goal - root) - 1.2


def test_the_same_place_gives_the_same_pose_to_the_bit():
    armature = standing()
    drag = inner.posing.PuppetDrag(
        armature, "hand.L", bpy.context.evaluated_depsgraph_get(), inner.posing.PuppetOptions()
    )
    shift = lambda x, z: np.array(Matrix.Translation((x, 0.0, z)))  # noqa: E731
    drag.move(armature, shift(0.1, 0.2))
    first = channels(armature)
    for angle in np.linspace(0.0, 6.0, 9):
        drag.move(armature, shift(0.5 * math.sin(angle), 0.4 * math.cos(angle)))
    assert not (channels(armature) == first).all()
    drag.move(armature, shift(0.1, 0.2))
    assert (channels(armature) == first).all()
    drag.move(armature, np.eye(4))
    assert np.abs(channels(armature) - rest_channels(armature)).max() < 1e-6
    drag.restore(armature)
    assert (channels(armature) == rest_channels(armature)).all()


def rest_channels(armature: bpy.types.Object) -> np.ndarray:
    return channels(figure())


def test_a_second_drag_begins_where_the_first_one_ended():
    armature = standing()
    pose(armature, "hip", (0.0, 0.0, -0.2))
    hip = end_of(armature, "hip", "head")
    pose(armature, "hand.L", (-0.1, -0.2, 0.1))
    assert np.linalg.norm(end_of(armature, "hip", "head") - hip) < 0.1  # not back at 1
    pose(armature, "hand.L", (0.0, 0.0, 0.0), from_rest=True)
    assert end_of(armature, "hip", "head")[2] == pytest.approx(1.0, abs=0.1)


def test_turned_moved_and_scaled_armatures_are_dragged_in_the_world():
    armature = standing()
    armature.matrix_world = (
        Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.7, 4, (1, 2, 3)) @ Matrix.Scale(2.0, 4)
    )
    update()
    place = end_of(armature, "hand.L")
    pose(armature, "hand.L", (-0.2, 0.1, -0.2))
    assert close(end_of(armature, "hand.L"), place + (-0.2, 0.1, -0.2), 4e-3)


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
    before = [shown(armature, name) for name in pinned]
    pose(armature, bone, value)
    after = [shown(armature, name) for name in pinned]
    assert close(np.array(after), np.array(before), 5e-3)  # pins count much, but not infinitely


def mirrored(armature: bpy.types.Object) -> float:
    """By how much the two legs of the figure differ. It has one arm alone."""
    pairs = [name[:-2] for name in BONES if name.endswith(".R")]
    return max(
        np.abs(end_of(armature, f"{name}.L", end) * (-1, 1, 1) - end_of(armature, f"{name}.R", end)).max()
        for name in pairs
        for end in ("head", "tail")
    )


@pytest.mark.parametrize(
    ("bone", "direction"), [("hip", (0.0, 0.0, -0.01)), ("chest", (0.0, -0.008, -0.008))]
)
def test_a_symmetric_drag_keeps_a_symmetric_figure_symmetric(bone: str, direction):
    armature = standing()
    assert mirrored(armature) < 1e-7
    knees, last = [], None
    for step in range(41):
        pose(armature, bone, tuple(step * np.array(direction)), part="WHOLE", from_rest=True)
        assert mirrored(armature) < 1e-6
        ends = np.array([end_of(armature, name) for name in BONES])
        # The first centimetres bend legs that are almost straight: knees move far, whoever bends them.
        assert step < 5 or np.linalg.norm(ends - last, axis=1).max() < 0.03
        last = ends
        knees.append(end_of(armature, "thigh.L"))
        for name in BONES:
            armature.pose.bones[name].matrix_basis = Matrix.Identity(4)
        update()
    knees = np.array(knees)
    assert (knees[:, 0] > 0.1).all()  # on its own side
    assert (np.diff(knees[:, 1]) < 1e-4).all()  # ever farther ahead
    assert knees[-1, 1] < -0.2


# Limits


def bent(bone: bpy.types.PoseBone, order: str = "XYZ") -> np.ndarray:
    return np.array(bone.matrix_basis.to_euler(order))


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "YZX"])
def test_limits_of_inverse_kinematics_are_never_exceeded(mode: str):
    armature = standing(mode)
    bones = [armature.pose.bones[name] for name in ("upper.L", "lower.L", "spine", "shin.L", "thigh.R")]
    for bone in bones:
        for axis, (least, most) in zip("xyz", ((-0.3, 0.4), (-0.1, 0.1), (-0.2, 0.6)), strict=True):
            setattr(bone, f"use_ik_limit_{axis}", True)
            setattr(bone, f"ik_min_{axis}", least)
            setattr(bone, f"ik_max_{axis}", most)
    rng = np.random.default_rng(5)
    order = mode if mode != "QUATERNION" else "XYZ"
    reached = 0
    for _ in range(6):
        pose(armature, "hand.L", tuple(rng.normal(size=3) * 0.5), from_rest=True)
        for bone in bones:
            angles = bent(bone, order)
            # One rounding of an angle that went through a float32 quaternion or matrix.
            assert (angles >= np.array((-0.3, -0.1, -0.2)) - 1e-6).all(), (bone.name, angles)
            assert (angles <= np.array((0.4, 0.1, 0.6)) + 1e-6).all(), (bone.name, angles)
            reached += bool((np.abs(angles - (0.4, 0.1, 0.6)) < 1e-5).any())
    assert reached > 3  # they were needed


def test_limit_rotation_changes_nothing_of_what_a_drag_shows():
    armature = figure("XYZ")
    for name in ("upper.L", "lower.L", "chest"):
        limit = armature.pose.bones[name].constraints.new("LIMIT_ROTATION")
        limit.owner_space = "LOCAL"
        for axis in "xyz":
            setattr(limit, f"use_limit_{axis}", True)
            setattr(limit, f"min_{axis}", -0.1)
            setattr(limit, f"max_{axis}", 0.2)
    pose(armature, "hand.L", (-0.6, -0.6, 0.3))
    shown = end_of(armature, "hand.L")
    for name in ("upper.L", "lower.L", "chest"):
        armature.pose.bones[name].constraints[0].mute = True
    assert close(end_of(armature, "hand.L"), shown, PLACES)
    angles = np.array([armature.pose.bones[name].rotation_euler for name in ("upper.L", "lower.L", "chest")])
    at_limit = np.minimum(np.abs(angles - 0.2), np.abs(angles + 0.1)) < 1e-6
    assert at_limit.any()  # they were needed


def test_of_limits_that_contradict_each_other_limit_rotation_wins():
    armature = figure("XYZ")
    bone = armature.pose.bones["lower.L"]
    bone.use_ik_limit_x, bone.ik_min_x, bone.ik_max_x = True, -0.2, -0.1
    bone.use_ik_limit_z, bone.ik_min_z, bone.ik_max_z = True, -1.0, 0.3
    limit = bone.constraints.new("LIMIT_ROTATION")
    limit.owner_space = "LOCAL"
    limit.use_limit_x, limit.min_x, limit.max_x = True, 0.1, 0.2
    limit.use_limit_z, limit.min_z, limit.max_z = True, -0.2, 1.0
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
    support = 0.12 + 1e-3, -0.2 - 1e-3, 1e-3
    assert centres[0][1] < support[1] or abs(centres[0][0]) > support[0]  # it would fall
    assert abs(centres[1][0]) <= support[0]
    assert support[1] <= centres[1][1] <= support[2]


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
    compat = inner.compat
    armature = figure()
    bpy.ops.object.mode_set(mode="POSE")
    for bone in armature.pose.bones:
        compat.select_bone(armature, bone.name, bone.name in FEET)
    pinned = lambda: {bone.name for bone in armature.pose.bones if bone.sinew.pin}  # noqa: E731
    assert bpy.ops.sinew.puppet_pin() == {"FINISHED"}
    assert pinned() == set(FEET)
    bpy.ops.sinew.puppet_pin(action="PIN")
    assert pinned() == set(FEET)
    bpy.ops.sinew.puppet_pin()
    assert pinned() == set()
    for bone in armature.pose.bones:
        compat.select_bone(armature, bone.name, False)
    with pytest.raises(RuntimeError, match="Select the bones to pin"):
        bpy.ops.sinew.puppet_pin()


# Keys, undo, files


def test_bones_are_keyed_if_asked_or_with_auto_keying():
    armature = standing()
    pose(armature, "hip", (0.0, 0.0, -0.1))
    assert armature.animation_data is None
    pose(armature, "hip", (0.0, 0.0, -0.1), key=True)
    keyed = {curve.data_path for curve in curves_of(armature)}
    assert 'pose.bones["hip"].location' in keyed
    assert 'pose.bones["shin.L"].rotation_quaternion' in keyed
    assert not any("hand" in path for path in keyed)
    low = end_of(armature, "hip")
    bpy.context.scene.frame_set(10)
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    pose(armature, "hip", (0.0, 0.0, 0.2))
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = False
    high = end_of(armature, "hip")
    bpy.context.scene.frame_set(1)
    assert close(end_of(armature, "hip"), low, 1e-5)
    bpy.context.scene.frame_set(10)
    assert close(end_of(armature, "hip"), high, 1e-5)
    assert high[2] > low[2] + 0.15


def test_pins_are_saved(tmp_path: Path):
    standing()
    reopen(tmp_path / "figure.blend")
    bones = bpy.data.objects["Figure"].pose.bones
    assert {bone.name for bone in bones if bone.sinew.pin} == set(FEET)


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
        typed, posing = inner.typed_motion, inner.posing
        self.armature, self.x, self.y = armature, 0.0, 0.0
        self.view, axes = front_view(centre=(0.0, 0.0)), np.eye(3)
        drag = posing.PuppetDrag(
            armature, bone, bpy.context.evaluated_depsgraph_get(), posing.PuppetOptions()
        )
        motion = typed.TypedMotion(
            inner.motion.Mode.TRANSLATE, self.view, axes, (0.0, 0.0), 1.0, 1.0, math.pi / 180.0
        )
        self.tool = inner.puppeteering.Puppeteering(drag, motion, drag.place, axes)

    def send(self, kind: str, value: str = "PRESS", unicode: str = ""):
        sent = event(kind, value, self.x, self.y, unicode)
        return self.tool.process(self.armature, sent, self.view).value

    def move(self, x: float, y: float) -> str:
        self.x, self.y = self.x + x, self.y + y
        return self.send("MOUSEMOVE", "NOTHING")


def test_the_mouse_drags_and_a_click_keeps():
    armature = standing()
    place = end_of(armature, "hand.L")
    mouse = Mouse(armature, "hand.L")
    assert mouse.move(-20.0, 10.0) == "GO_ON"
    assert close(end_of(armature, "hand.L"), place + (-0.2, 0.0, 0.1), 3e-3)
    assert mouse.send("LEFTMOUSE") == "CONFIRMED"
    assert close(end_of(armature, "hand.L"), place + (-0.2, 0.0, 0.1), 3e-3)


def test_escape_puts_everything_back_to_the_bit():
    armature = standing("XYZ")
    pose(armature, "hand.L", (-0.1, -0.1, 0.0))
    before = channels(armature)
    mouse = Mouse(armature, "hip")
    mouse.move(10.0, -30.0)
    assert not (channels(armature) == before).all()
    assert mouse.send("ESC") == "CANCELLED"
    assert (channels(armature) == before).all()


def test_axes_and_numbers_are_typed():
    armature = standing()
    hip = end_of(armature, "hip", "head")
    mouse = Mouse(armature, "hip")
    mouse.move(5.0, 5.0)
    mouse.send("Z", unicode="z")
    for kind, text in (("MINUS", "-"), ("PERIOD", "."), ("TWO", "2")):
        mouse.send(kind, unicode=text)
    assert mouse.send("RET") == "CONFIRMED"
    assert close(end_of(armature, "hip", "head"), hip + (0.0, 0.0, -0.2), 3e-3)
