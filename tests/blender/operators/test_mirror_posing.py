# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrored posing: what is moved on one side moves the control of the other, live, and nothing else does."""

import math

import bpy
import numpy as np
import pytest
from inside import calls_of, evaluated_by, inner, settle
from mathutils import Euler, Matrix, Quaternion, Vector
from probe import render
from rigs import rig as scenes
from rigs.sheet import WIDE, draw_panel
from test_mirror import assert_is_its_own_mirror_image, by_name

EDGE = 0.7
POSED = {"location": (0.1, 0.2, 0.4), "rotation_euler": (0.3, 0.5, -0.2), "scale": (1.0, 1.2, 0.9)}
MIRRORED = {"location": (-0.1, 0.2, 0.4), "rotation_euler": (0.3, -0.5, 0.2), "scale": (1.0, 1.2, 0.9)}
REST = {"location": (0.0, 0.0, 0.0), "rotation_euler": (0.0, 0.0, 0.0), "scale": (1.0, 1.0, 1.0)}


def add_handle(plate: scenes.Rig, name: str, where, kind: str = "HANDLE", **keywords) -> None:
    scenes.add_group(plate.obj, name, where)
    scenes.press(plate.obj, "handle_add", kind=kind, vertex_group=name, **keywords)
    scenes.make_active(plate.obj)


@pytest.fixture
def hands() -> scenes.Rig:
    """A plate with Hand.L and its mirror image, a head without a side, a fixed spine; the switch is on."""
    plate = scenes.Rig(scenes.grid_object())
    bpy.ops.sinew.deformer_add(method="thin_shell")
    add_handle(plate, "Hand.L", lambda point: point[0] > EDGE)
    bpy.ops.sinew.handle_mirror()
    add_handle(plate, "Head", lambda point: abs(point[0]) < 0.3 and point[1] > EDGE)
    add_handle(plate, "Spine", lambda point: abs(point[0]) < 0.1 and point[1] < 0.3, "FIXED")
    plate.deformer.use_mirror_x = True
    scenes.update()
    return plate


def control(plate: scenes.Rig, name: str) -> bpy.types.Object:
    return by_name(plate, name).control


def left(plate: scenes.Rig) -> bpy.types.Object:
    return control(plate, "Hand.L")


def right(plate: scenes.Rig) -> bpy.types.Object:
    return control(plate, "Hand.R")


def pose(obj: bpy.types.Object, **values) -> None:
    for name, value in values.items():
        setattr(obj, name, value)
    scenes.update()


def is_at(obj: bpy.types.Object, values: dict, tolerance: float = 2e-6) -> bool:
    return all(np.allclose(getattr(obj, name), value, atol=tolerance) for name, value in values.items())


@pytest.mark.parametrize(("one", "other"), [("Hand.L", "Hand.R"), ("Hand.R", "Hand.L")])
def test_the_other_side_follows(hands: scenes.Rig, tmp_path, one, other):
    """In the same evaluation: after it the shape is its own mirror image. And in a file."""
    for _ in range(2):
        leader, partner = control(hands, one), control(hands, other)
        pose(leader, **POSED)
        assert is_at(partner, MIRRORED)
        assert is_at(leader, POSED, 0.0 + 1e-7)
        assert_is_its_own_mirror_image(hands)
        assert np.abs(hands.points() - hands.rest()).max() > 0.3
        pose(leader, **REST)
        assert is_at(partner, REST)
        scenes.reopen(tmp_path / "mirrored.blend")


def test_it_is_off_until_it_is_switched_on(hands: scenes.Rig):
    hands.deformer.use_mirror_x = False
    scenes.update()
    pose(left(hands), **POSED)
    assert is_at(right(hands), REST)
    hands.deformer.use_mirror_x = True  # what was moved before is not mirrored now
    for _ in range(2):
        scenes.update()
    assert is_at(right(hands), REST)
    assert not scenes.add_regions(scenes.grid_object("Other"), "thin_shell", {}).use_mirror_x


TRANSFORMS = {
    "move": lambda: bpy.ops.transform.translate(value=(0.1, 0.2, 0.3)),
    "rotate": lambda: bpy.ops.transform.rotate(value=0.4, orient_axis="X"),
    "scale": lambda: bpy.ops.transform.resize(value=(2.0, 2.0, 2.0)),
}


@pytest.mark.parametrize("transform", TRANSFORMS.values(), ids=TRANSFORMS)
def test_blenders_transforms_are_followed(hands: scenes.Rig, transform):
    """And so are those that clear them."""
    flip = np.diag((-1.0, 1.0, 1.0, 1.0))
    scenes.make_active(left(hands))
    before = [np.array(side(hands).matrix_world) for side in (left, right)]
    transform()
    scenes.update()
    motion = np.array(left(hands).matrix_world) @ np.linalg.inv(before[0])
    assert np.abs(motion - np.eye(4)).max() > 0.1
    assert np.allclose(right(hands).matrix_world, flip @ motion @ flip @ before[1], atol=1e-5)
    assert_is_its_own_mirror_image(hands)
    for clear in ("location_clear", "rotation_clear", "scale_clear"):
        getattr(bpy.ops.object, clear)()
    scenes.update()
    assert is_at(right(hands), REST)
    assert np.abs(hands.points() - hands.rest()).max() < 2e-5


def test_a_turn_of_more_than_half_a_circle_goes_on(hands: scenes.Rig):
    for degrees in range(0, 400, 40):
        pose(left(hands), rotation_euler=(0.0, 0.0, math.radians(degrees)))
        assert np.allclose(right(hands).rotation_euler, (0.0, 0.0, -math.radians(degrees)), atol=1e-5)


@pytest.mark.parametrize("mode", ["QUATERNION", "AXIS_ANGLE", "ZYX"])
def test_the_other_control_may_turn_in_another_mode(hands: scenes.Rig, mode):
    right(hands).rotation_mode = mode
    scenes.update()
    assert is_at(left(hands), REST)  # choosing a mode moves nothing
    pose(left(hands), **POSED)
    assert_is_its_own_mirror_image(hands)
    for other in ("XYZ", mode):
        right(hands).rotation_mode = other
        scenes.update()
        assert is_at(left(hands), POSED, 1e-7)
    if mode == "QUATERNION":
        turn = Quaternion((0.0, 0.0, 1.0), 0.5)
        pose(right(hands), rotation_quaternion=turn)
        turned = left(hands).rotation_euler.to_quaternion()
        assert turned.rotation_difference(turn.inverted()).angle < 1e-3


def test_both_moved_at_once_keep_what_the_transform_gave_them(hands: scenes.Rig):
    """And one without a side moves no other."""
    scenes.make_active(left(hands), right(hands))
    bpy.ops.transform.translate(value=(0.1, 0.2, 0.3))
    pose(control(hands, "Head"), location=(0.0, 0.0, 0.3))
    for side in (left, right):
        assert is_at(side(hands), {"location": (0.1, 0.2, 0.3)})


@pytest.mark.parametrize("by", ["evaluations", "Mirror"])
def test_the_first_control_is_moved_no_further(hands: scenes.Rig, by: str):
    def numbers() -> list[tuple]:
        return [tuple(getattr(left(hands), name)) for name in POSED]

    pose(left(hands), **POSED)
    given = numbers()
    if by == "Mirror":
        hands.deformer.active_handle = 0
        scenes.press(hands.obj, "handle_mirror")
    for _ in range(3):
        bpy.context.view_layer.objects.active = hands.obj
        hands.obj.update_tag()
        scenes.update()
    assert numbers() == given
    pose(left(hands), **REST)
    assert is_at(right(hands), REST)


def test_animation_is_not_mirrored(hands: scenes.Rig):
    """Neither by playback, scrubbing and renders, nor by an edit of something else on such a frame."""
    scenes.key(left(hands), {1: {"location": (0.0, 0.0, 0.0)}, 11: {"location": (0.0, 0.0, 0.5)}})
    scene = bpy.context.scene
    scene.frame_set(1)
    pose(right(hands), location=(0.0, 0.0, 0.0))
    for frame in (11, 6, 1, 7):
        scene.frame_set(frame)
        render()
        assert is_at(right(hands), REST)
    hands.obj.data.update_tag()
    scenes.new_empty("Other")
    pose(control(hands, "Head"), location=(0.0, 0.0, 0.1))
    assert left(hands).location.z > 0.1
    scenes.curves_of(left(hands))[2].keyframe_points[0].co.y = -0.5  # the curve is edited, not the control
    left(hands).animation_data.action.update_tag()
    scenes.update()
    assert is_at(right(hands), REST)
    pose(left(hands), location=(0.0, 0.2, 0.0))  # and what is moved on such a frame is mirrored
    assert is_at(right(hands), {"location": (0.0, 0.2, 0.0)})


def test_drivers_constraints_and_parents_are_not_mirrored(hands: scenes.Rig):
    master = scenes.new_empty("Master")
    driver = left(hands).driver_add("location", 2).driver
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id, target.data_path = master, "location[0]"
    scenes.update()
    pose(master, location=(0.4, 0.0, 0.0))
    assert left(hands).location.z == pytest.approx(0.4)
    assert is_at(right(hands), REST)
    left(hands).driver_remove("location", 2)
    pose(left(hands), location=(0.0, 0.0, 0.0))
    constraint = left(hands).constraints.new("COPY_LOCATION")
    constraint.target, constraint.use_offset = master, True
    scenes.update()
    for mover, place in ((master, (0.0, 0.4, 0.0)), (hands.obj, (1.0, 2.0, 3.0))):
        pose(mover, location=place)
        assert is_at(right(hands), REST)


def push_before_the_partner_follows(message: str) -> None:
    """As an operator of a window ends: Blender takes the step, and evaluates afterwards."""
    running = bpy.app.handlers.depsgraph_update_pre
    ours = list(running)
    running.clear()
    with evaluated_by(None):
        bpy.ops.ed.undo_push(message=message)
    running.extend(ours)


def test_steps_of_undo_that_lack_the_partner_are_completed(hands: scenes.Rig):
    """In both directions, and beside steps that have both."""
    scenes.push("Before")
    pose(left(hands), **POSED)
    scenes.push("Move")
    for name, value in REST.items():
        setattr(left(hands), name, value)
    push_before_the_partner_follows("Clear")
    assert is_at(right(hands), MIRRORED)
    left(hands).update_tag()
    scenes.update()
    assert is_at(right(hands), REST)
    pose(control(hands, "Head"), location=(0.0, 0.0, 0.2))
    scenes.push("Another Move")
    undo, redo = bpy.ops.ed.undo, bpy.ops.ed.redo
    for step, moved in ((undo, False), (undo, True), (undo, False), (redo, True), (redo, False)):
        step()
        scenes.update()
        assert is_at(left(hands), POSED if moved else REST)
        assert is_at(right(hands), MIRRORED if moved else REST)
        assert_is_its_own_mirror_image(hands)


def aside(hands: scenes.Rig, one: bpy.types.Object, other: bpy.types.Object) -> None:
    other.location = (-0.7, 0.3, 0.2)
    one.rotation_euler, other.rotation_euler = (0.1, 0.2, 0.3), (1.0, -0.4, 2.0)
    other.rotation_mode = "QUATERNION"


def aside_of_a_placed_mesh(hands: scenes.Rig, one: bpy.types.Object, other: bpy.types.Object) -> None:
    aside(hands, one, other)
    hands.obj.matrix_world = scenes.some_motion() @ Matrix.Scale(1.5, 4)


def carried_by_bones(hands: scenes.Rig, one: bpy.types.Object, other: bpy.types.Object) -> None:
    """As a child, and by Child Of."""
    armature = scenes.new_armature(
        one=((0.9, 0.0, 0.0), (0.9, 0.0, 0.5)), other=((-0.9, 0, 0), (-0.9, 0.3, 0.4))
    )
    one.parent, one.parent_type, one.parent_bone = armature, "BONE", "one"
    child_of = other.constraints.new("CHILD_OF")
    child_of.target, child_of.subtarget = armature, "other"


@pytest.mark.parametrize("stand", [aside, aside_of_a_placed_mesh, carried_by_bones])
def test_controls_that_rest_otherwise_follow_as_mirror_does(hands: scenes.Rig, stand):
    """Objects of the user: a pose is relative to the mesh, whatever carries them."""
    ours = [scenes.new_empty("Grip.L", (0.9, 0.1, 0.0)), scenes.new_empty("Grip.R", (-0.9, 0.1, 0.0))]
    stand(hands, *ours)
    scenes.update()
    for name, empty in zip(("Hand.L", "Hand.R"), ours, strict=True):
        by_name(hands, name).control = empty
    scenes.press(hands.obj, "bind")
    assert np.abs(hands.points() - hands.rest()).max() < 2e-5
    for leader in ours:
        turn = Matrix.Translation((0.1, 0.2, 0.3)) @ Euler((0.3, -0.2, 0.4)).to_matrix().to_4x4()
        scenes.move_world(leader, turn)
        assert_is_its_own_mirror_image(hands)
    assert np.abs(hands.points() - hands.rest()).max() > 0.1


@pytest.mark.parametrize("mode", ["XYZ", "QUATERNION", "AXIS_ANGLE"])
def test_locked_channels_stay(hands: scenes.Rig, mode: str):
    """Of Euler angles one; of other modes of rotation all."""
    partner, euler = right(hands), mode == "XYZ"
    partner.rotation_mode, partner.lock_location = mode, (False, False, True)
    partner.lock_rotation, partner.lock_rotation_w = (True, not euler, not euler), True
    name = "rotation_euler" if euler else f"rotation_{mode.lower()}"
    wanted = (0.0, -0.5, 0.2) if euler else tuple(getattr(partner, name))
    pose(left(hands), **POSED)
    assert is_at(partner, {"location": (-0.1, 0.2, 0.0), name: wanted})


def test_what_cannot_be_mirrored_stays_quietly(hands: scenes.Rig):
    """Scaled to zero, not a number, deleted, given to another object, renamed: no traceback."""
    pose(left(hands), **POSED)
    pose(hands.obj, scale=(0.0, 1.0, 1.0))
    pose(left(hands), location=(0.0, 0.0, 0.1))
    pose(hands.obj, scale=(1.0, 1.0, 1.0))
    pose(left(hands), location=(0.0, 0.0, math.nan))
    assert np.isfinite(right(hands).location).all()
    pose(left(hands), **POSED)
    hands.name = "Renamed"
    bpy.data.objects["Plate"].name = hands.name
    scenes.update()
    pose(left(hands), location=(0.1, 0.0, 0.0))
    assert is_at(right(hands), {"location": (-0.1, 0.0, 0.0)})
    other = by_name(hands, "Hand.R").control = scenes.new_empty("Elsewhere", (-2.0, 0.0, 0.0))
    scenes.update()
    pose(left(hands), location=(0.2, 0.0, 0.0))
    assert np.allclose(other.location, (-2.1, 0.0, 0.0), atol=1e-5)
    bpy.data.objects.remove(other)
    pose(left(hands), **REST)
    bpy.data.objects.remove(hands.obj)
    scenes.update()


def test_names_of_groups_and_of_controls_tell_the_side_too(hands: scenes.Rig):
    for name, new, grip in (("Hand.L", "One", "Grip_l"), ("Hand.R", "Two", "Grip_r")):
        handle = by_name(hands, name)
        handle.name, handle.control.name = new, grip
    hands.obj.vertex_groups["Hand.L"].name = "Group One"
    scenes.update()
    pose(bpy.data.objects["Grip_l"], **POSED)
    assert is_at(bpy.data.objects["Grip_r"], MIRRORED)


def test_automatic_keyframes_key_the_partner_too(hands: scenes.Rig, monkeypatch):
    """When the artist pauses: Blender keys the control that was moved, and Sinew the same channels."""
    scene = bpy.context.scene
    scene.tool_settings.use_keyframe_insert_auto = True
    monkeypatch.setattr(bpy.context.preferences.edit, "use_keyframe_insert_available", False)
    scenes.make_active(left(hands))
    for frame, move in ((1, (0.1, 0.2, 0.3)), (11, (0.0, 0.0, 0.5))):
        scene.frame_set(frame)
        bpy.ops.transform.translate(value=move)
        settle()
        assert keys_of(left(hands))
        assert keys_of(right(hands)) == keys_of(left(hands))
    for frame, height in ((1, 0.3), (11, 0.8)):
        scene.frame_set(frame)
        assert is_at(right(hands), {"location": (-0.1, 0.2, height)}, 1e-5)
    scene.tool_settings.use_keyframe_insert_auto = False
    scene.frame_set(5)
    bpy.ops.transform.translate(value=(0.0, 0.1, 0.0))
    settle()
    assert all(len(frames) <= 2 for frames in keys_of(right(hands)).values())


def insert_keyframes(kind: str = "LocRotScale") -> None:
    """As the key I does, for what is selected; then the artist pauses."""
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=window.screen.areas[0]):
        assert bpy.ops.anim.keyframe_insert_by_name(type=kind) == {"FINISHED"}
    settle()


def keys_of(obj: bpy.types.Object) -> dict[tuple[str, int], list[float]]:
    curves = [] if obj.animation_data is None else scenes.curves_of(obj)
    return {(c.data_path, c.array_index): [point.co.x for point in c.keyframe_points] for c in curves}


@pytest.mark.parametrize(("one", "other"), [(left, right), (right, left)])
def test_inserting_keyframes_keys_the_partner_too(hands: scenes.Rig, one, other):
    """At rest, moved, moved once more; and one channel alone."""
    scene = bpy.context.scene
    scenes.make_active(one(hands))
    high = {"location": (0.1, 0.2, 0.7)}
    for frame, values, kind in (
        (1, {}, "LocRotScale"),
        (11, POSED, "LocRotScale"),
        (11, POSED | high, "LocRotScale"),
        (21, {"location": (0.0, 0.5, 0.0)}, "Location"),
    ):
        scene.frame_set(frame)
        pose(one(hands), **values)
        insert_keyframes(kind)
        assert keys_of(other(hands)) == keys_of(one(hands))
    assert keys_of(one(hands))["location", 0] == [1.0, 11.0, 21.0]
    assert keys_of(one(hands))["scale", 0] == [1.0, 11.0]
    there = {1: REST, 11: MIRRORED | {"location": (-0.1, 0.2, 0.7)}, 21: {"location": (0.0, 0.5, 0.0)}}
    for frame, values in there.items():
        scene.frame_set(frame)
        assert is_at(other(hands), values, 1e-5)


def test_only_what_is_keyed_by_hand_is_keyed_on_the_other_side(hands: scenes.Rig):
    """Not what a script names, nor what is keyed while both are selected or while the switch is off."""

    def paths() -> set[str]:
        return {path for path, _axis in keys_of(right(hands))}

    scenes.make_active(control(hands, "Head"))
    left(hands).keyframe_insert("location", frame=1)
    settle()
    assert paths() == set()
    scenes.make_active(left(hands), right(hands))
    insert_keyframes("Location")
    assert paths() == {"location"}
    scenes.make_active(left(hands))
    pose(left(hands), **POSED)
    bpy.context.scene.frame_set(5)  # what was not keyed is gone
    insert_keyframes("Scaling")
    hands.deformer.use_mirror_x = False
    scenes.update()
    insert_keyframes("Rotation")
    assert paths() == {"location", "scale"}


def test_both_sides_are_one_solve_and_without_it_nothing_is_called_for_it(hands: scenes.Rig):
    inside = inner.mirroring
    ours = {
        name for name, value in vars(inside).items() if getattr(value, "__module__", "") == inside.__name__
    }
    ours |= {"before_depsgraph_update", "listen", "control_pairs"}
    assert {"move_partners", "note_seen", "note_target", "_mirror"} <= ours
    for height in (0.1, 0.2):
        pose(left(hands), location=(0.0, 0.0, height))
    found = calls_of(lambda: pose(left(hands), location=(0.0, 0.0, 0.1)))
    assert {"before_depsgraph_update", "move_partners", "note_seen", "_mirror"} <= found.keys()
    assert found["write_shape"] == found["_mirror"] == 1, found
    other = scenes.new_empty("Other")
    scenes.update()
    found = calls_of(lambda: pose(other, location=(0.0, 0.0, 0.3)))
    assert not {"write_shape", "_mirror", "solve"} & found.keys(), found
    hands.deformer.use_mirror_x = False
    scenes.update()
    for _ in range(2):
        pose(control(hands, "Head"), location=(0.0, 0.0, 0.01))
    bpy.context.scene.frame_set(2)
    for act, by in (
        (lambda: pose(left(hands), location=(0.0, 0.0, 0.3)), "write_shape"),
        (lambda: bpy.context.scene.frame_set(3), "on_frame_change"),
    ):
        found = calls_of(act)
        assert found[by] == 1, found
        assert not ours & found.keys(), found


def test_the_panel_has_the_switch_and_for_bones_that_of_blender(hands: scenes.Rig):
    sheet = draw_panel(WIDE)
    drawn = [(given[1], words.get("icon")) for name, given, words, _ in sheet.calls if name == "prop"]
    assert ("use_mirror_x", "MOD_MIRROR") in drawn
    assert "Mirror makes it" not in sheet.texts()
    assert "Bones of" not in str(sheet.calls)
    arms = scenes.new_armature(
        **{f"Arm.{side}": ((x, 0, 0), (x, 0, 0.5)) for side, x in (("L", 0.9), ("R", -0.9))}
    )
    for side in "LR":
        handle = by_name(hands, f"Hand.{side}")
        handle.control, handle.bone = arms, f"Arm.{side}"
    scenes.press(hands.obj, "bind")
    arms.pose.bones["Arm.L"].location = (0.0, 0.2, 0.0)
    scenes.update()
    assert arms.pose.bones["Arm.R"].location == Vector()
    assert "Bones of Rig" in str(draw_panel(WIDE).calls)
    for _ in range(2):
        bpy.ops.sinew.handle_remove(index=0)
    assert "Mirror makes it" in draw_panel(WIDE).texts()
