# SPDX-License-Identifier: GPL-3.0-or-later
"""Corrections of a shape that bones, shape keys or another rig pose: they ride on the surface that enters.

The far edge of a plate is carried by one bone alone, so a correction that was made at one frame must follow
that bone at every other: the oracle is the matrix of the bone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest
from editing import edit
from inside import notes_of, settle
from libraries import add_collection, override, put_into_a_library
from mathutils import Matrix
from probe import render_points
from registry import BY_ID, WITH_HANDLES
from rigs import rig as scenes
from rigs.sheet import draw

MADE, FRAMES = 20, (1, 7, 20, 30)
ITERATED = 1e-2  # where handles are not moved, an iteration may stop this far from what enters
APPROXIMATE = {"inverse_ffd": 1e-3}  # handles are met as well as a lattice can
LIFT = Matrix.Translation((0.05, -0.1, 0.2))
TURN = LIFT @ Matrix.Rotation(0.4, 4, "Z")


class Posed(scenes.Rig):
    """A plate whose far part one bone bends and moves over the frames; it is made at the frame MADE."""

    @classmethod
    def new(cls) -> Posed:
        plate = cls.plate()
        bone = scenes.add_armature(plate.obj, split=-0.3).pose.bones["high"]
        turns = {1: (0.0, 0.0, 0.0), MADE: (1.4, 0.3, -0.5), 30: (-0.6, 0.0, 0.8)}
        scenes.key(bone, {frame: {"rotation_euler": turn} for frame, turn in turns.items()})
        scenes.key(bone, {1: {"location": (0.0, 0.0, 0.0)}, 30: {"location": (0.2, 0.1, -0.3)}})
        go(MADE)
        return plate

    def correct(self, motion: Matrix = TURN) -> Posed:
        """Move the control in the world of this frame."""
        scenes.move_world(self.control, motion)
        self.made, self.motion = bone_now(), np.array(motion)
        return self

    def far_edge(self, obj: bpy.types.Object | None = None) -> np.ndarray:
        obj = obj or self.obj
        return scenes.apply_matrix(obj.matrix_world, scenes.evaluated_points(obj)[self.top])

    def expected(self) -> np.ndarray:
        """The far edge now in the world, as ``correct`` moved it when the bone was where it was then."""
        return scenes.apply_matrix(self.carried() @ self.motion @ self.made, self.at_rest())

    def at_rest(self) -> np.ndarray:
        return scenes.apply_matrix(self.obj.matrix_world, scenes.base_points(self.obj)[self.top])

    def carried(self) -> np.ndarray:
        """How the bone has moved since ``correct``, (4, 4)."""
        return bone_now() @ np.linalg.inv(self.made)

    def is_right(self, tolerance: float = scenes.MATRIX, obj: bpy.types.Object | None = None) -> bool:
        """The far edge is right in every frame."""
        return all(scenes.close(self.far_edge(obj), self.expected(), tolerance) for _frame in frames())

    def renders_right(self, tolerance: float) -> bool:
        def rendered() -> np.ndarray:
            return scenes.apply_matrix(self.obj.matrix_world, render_points(self.obj)[self.top])

        return all(scenes.close(rendered(), self.expected(), tolerance) for _frame in frames())


@pytest.fixture
def arm() -> Posed:
    return Posed.new()


@pytest.fixture
def corrected(arm: Posed) -> Posed:
    arm.bind("thin_shell")
    return arm.correct()


def go(frame: int) -> None:
    bpy.context.scene.frame_set(frame)


def frames() -> Iterator[int]:
    """Each while it is shown."""
    for frame in FRAMES:
        go(frame)
        yield frame


def bone_now() -> np.ndarray:
    """What the far bone does to the mesh in this frame, in the world, (4, 4)."""
    rig = next(obj for obj in bpy.data.objects if obj.type == "ARMATURE" and obj.users_scene)
    armature = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
    bone = armature.pose.bones["high"]
    return np.array(bone.matrix @ bone.bone.matrix_local.inverted(), dtype=float)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_correction_rides_on_the_surface(arm: Posed, method: str):
    arm.bind(method)
    assert arm.deformer.handles[0].stands_on == "SURFACE"
    off, modifier = ITERATED if BY_ID[method].iterative else scenes.MATRIX, arm.obj.modifiers[-1]
    for frame in frames():  # without one, the bones alone count
        shown = arm.points()
        modifier.show_viewport = False
        assert scenes.close(shown, arm.points(), off), frame
        modifier.show_viewport = True
    go(MADE)
    arm.correct()
    off = APPROXIMATE.get(method, scenes.MATRIX)
    assert arm.is_right(off)
    assert arm.renders_right(off)


def test_the_control_stands_on_the_surface_in_every_frame(corrected: Posed):
    place = np.array(corrected.control.matrix_world)
    for frame in frames():
        scenes.update()
        assert scenes.close(
            np.array(corrected.control.matrix_world), corrected.carried() @ place, scenes.MATRIX
        ), frame
        bpy.context.view_layer.objects.active = corrected.control
    corrected.control.matrix_basis = Matrix()  # Alt G, R, S
    go(7)
    assert scenes.close(
        corrected.far_edge(), scenes.apply_matrix(bone_now(), corrected.at_rest()), scenes.MATRIX
    )


def saved_and_loaded(arm: Posed, folder: Path) -> None:
    go(7)
    scenes.reopen(folder / "arm.blend")


def undone_and_redone(arm: Posed, _folder: Path) -> None:
    scenes.push("corrected")
    scenes.move_world(arm.control, Matrix.Translation((1.0, 0.0, 0.0)))
    scenes.push("moved on")
    go(1)
    bpy.ops.ed.undo()
    assert arm.is_right()
    bpy.ops.ed.redo()
    bpy.ops.ed.undo()


def bound_again_at_another_frame(arm: Posed, _folder: Path) -> None:
    go(7)
    scenes.press(arm.obj, "bind")


def given_another_handle_at_another_frame(arm: Posed, _folder: Path) -> None:
    scenes.add_group(arm.obj, "Near", lambda point: -0.75 < point[1] < -0.5)
    go(30)
    scenes.press(arm.obj, "handle_add", kind="HANDLE", vertex_group="Near")


def given_a_new_control_at_another_frame(arm: Posed, _folder: Path) -> None:
    bpy.data.objects.remove(arm.control)
    assert arm.is_right()  # the correction stays on the skin meanwhile
    go(7)
    scenes.press(arm.obj, "control_new")


def moved_turned_and_applied(arm: Posed, _folder: Path) -> None:
    """The mesh is brought back by its own points, so that the bone still moves the same places."""
    bend = Matrix.Translation((0.3, 0.2, 0.1)) @ Matrix.Rotation(0.7, 4, "X")
    bend @= Matrix.Diagonal((1, 2, 0.5, 1))
    go(7)
    arm.obj.matrix_world = bend
    arm.obj.data.transform(bend.inverted())
    scenes.make_active(arm.obj)
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)


def renamed_with_its_control(arm: Posed, _folder: Path) -> None:
    arm.control.name = "Elsewhere"
    arm.obj.name = arm.name = "Renamed"
    arm.deformer.handles[0].name = "Hand L"


def switched_to_the_world_and_back(arm: Posed, _folder: Path) -> None:
    """By the button, with undo and redo, and by a script."""
    go(7)
    scenes.make_active(arm.obj)
    scenes.push("corrected")
    shown, place = arm.far_edge(), np.array(arm.control.matrix_world)

    def stands(on: str) -> None:
        assert arm.deformer.handles[0].stands_on == on
        assert scenes.close(arm.far_edge(), shown, scenes.MATRIX)
        assert scenes.close(np.array(arm.control.matrix_world), place, scenes.MATRIX)

    for on in ("WORLD", "SURFACE", "WORLD"):
        assert bpy.ops.sinew.handle_stand(on=on, index=0) == {"FINISHED"}
        scenes.push(on)
        stands(on)
    for step, on in ((bpy.ops.ed.undo, "SURFACE"), (bpy.ops.ed.redo, "WORLD"), (bpy.ops.ed.undo, "SURFACE")):
        step()
        stands(on)
    for on in ("WORLD", "SURFACE"):
        arm.deformer.handles[0].stands_on = on
        stands(on)


def moved_by_a_script_in_the_world(arm: Posed, _folder: Path) -> None:
    """To a place in the world, in another frame: there the surface goes."""
    go(7)
    scenes.update()
    place = arm.control.matrix_world.copy()
    arm.control.matrix_world = LIFT @ place
    assert scenes.close(arm.far_edge(), scenes.apply_matrix(np.array(LIFT), arm.expected()), scenes.MATRIX)
    assert scenes.close(np.array(arm.control.matrix_world), np.array(LIFT @ place), scenes.MATRIX)
    arm.control.matrix_world = place


LIVES_THROUGH: list[Callable[[Posed, Path], None]] = [
    saved_and_loaded,
    undone_and_redone,
    bound_again_at_another_frame,
    given_another_handle_at_another_frame,
    given_a_new_control_at_another_frame,
    moved_turned_and_applied,
    renamed_with_its_control,
    switched_to_the_world_and_back,
    moved_by_a_script_in_the_world,
]


@pytest.mark.parametrize("happens", LIVES_THROUGH, ids=lambda row: row.__name__)
def test_a_correction_lives_through(corrected: Posed, tmp_path: Path, happens):
    happens(corrected, tmp_path)
    assert corrected.is_right(2e-5)
    assert corrected.renders_right(2e-5)


def parented_to_the_bone(control: bpy.types.Object) -> None:
    armature = bpy.data.objects["Rig"]
    scenes.make_active(armature)
    armature.data.bones.active = armature.data.bones["high"]
    control.select_set(True)
    assert bpy.ops.object.parent_set(type="BONE", keep_transform=True) == {"FINISHED"}


def constrained_to_the_bone(control: bpy.types.Object) -> None:
    constraint = control.constraints.new("CHILD_OF")
    constraint.target, constraint.subtarget = bpy.data.objects["Rig"], "high"
    scenes.update()
    armature = bpy.data.objects["Rig"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    constraint.inverse_matrix = (armature.matrix_world @ armature.pose.bones["high"].matrix).inverted()


@pytest.mark.parametrize("take", [parented_to_the_bone, constrained_to_the_bone])
def test_a_parent_that_moves_the_mesh_already_does_not_count_twice(corrected: Posed, take):
    take(corrected.control)
    scenes.update()
    assert "Top now follows high" in notes_of(corrected.deformer)
    if take is parented_to_the_bone:  # a constraint is not carried by the mesh as well
        assert corrected.is_right(2e-5)
    scenes.make_active(corrected.control)
    for constraint in corrected.control.constraints:
        corrected.control.constraints.remove(constraint)
    bpy.ops.object.parent_clear(type="CLEAR_KEEP_TRANSFORM")
    scenes.update()
    assert not any("high" in note for note in notes_of(corrected.deformer))


def test_keyframes_are_converted(arm: Posed):
    arm.bind("thin_shell")
    shown = {}
    for frame, motion in ((7, LIFT), (30, TURN)):
        go(frame)
        arm.control.matrix_basis = motion
        for channel in ("location", "rotation_euler"):
            arm.control.keyframe_insert(channel, frame=frame)
        shown[frame] = arm.far_edge()
    for on in ("WORLD", "SURFACE"):
        go(MADE)
        scenes.press(arm.obj, "handle_stand", on=on, index=0)
        assert arm.deformer.handles[0].stands_on == on
        for frame, shape in shown.items():
            go(frame)
            assert scenes.close(arm.far_edge(), shape, 1e-4), (on, frame)


def test_where_nothing_moves_the_mesh_handles_stand_in_the_world(arm: Posed, plate: scenes.Rig):
    """And Surface is grey; so do objects of the user. *From Rest* is shown for handles that use it alone."""
    panel = bpy.types.SINEW_PT_region
    for rig, on, says in ((arm, "SURFACE", ""), (plate, "WORLD", "Nothing before Sinew moves this mesh")):
        rig.bind("thin_shell")
        scenes.make_active(rig.obj)
        rig.deformer.active_handle = 0
        drawn = draw(panel)
        switches = [properties.on for name, properties in drawn.operators() if name == "sinew.handle_stand"]
        assert switches == ["WORLD", "SURFACE"]
        assert rig.deformer.handles[0].stands_on == on
        assert says in drawn.texts()
        assert "from_rest" not in drawn.properties()
    scenes.refused("Nothing before Sinew moves this mesh", "handle_stand", plate.obj, on="SURFACE", index=0)
    plate.deformer.handles[0].from_rest = True
    assert "from_rest" in draw(panel).properties()
    scenes.new_empty("Mine")
    arm.bind("thin_shell", control_object="Mine")
    assert arm.deformer.handles[0].stands_on == "WORLD"


def test_a_bone_as_a_control_does_not_count_twice_on_the_surface(arm: Posed):
    arm.bind("thin_shell", control_object="Rig", bone="high")
    arm.deformer.handles[0].stands_on = "SURFACE"
    arm.made, arm.motion = bone_now(), np.eye(4)
    assert arm.is_right()


def test_copies_ride_by_themselves(corrected: Posed):
    copy = scenes.duplicated(corrected.obj, corrected.control)
    settle()
    control = copy.sinew.deformers[0].handles[0].control
    assert control not in (None, corrected.control)
    assert corrected.is_right(obj=copy)
    control.matrix_basis = Matrix()
    go(7)
    assert scenes.close(
        corrected.far_edge(copy), scenes.apply_matrix(bone_now(), corrected.at_rest()), scenes.MATRIX
    )
    assert corrected.is_right()


@pytest.mark.parametrize("bring", [add_collection, override])
def test_a_rig_from_a_library_rides(corrected: Posed, tmp_path: Path, bring):
    objects = (corrected.obj, corrected.control, bpy.data.objects["Rig"])
    bring(put_into_a_library(tmp_path / "asset.blend", *objects))
    corrected.name = next(obj.name for obj in bpy.context.scene.objects if obj.sinew.deformers)
    assert corrected.is_right(2e-5)
    if bring is override:
        scenes.refused("does not save new drivers", "drive_by_bone", corrected.obj)


@pytest.mark.parametrize("method", ["arap", "inverse_ffd"])
def test_sinew_drag_makes_controls_that_ride(arm: Posed, method: str):
    vertex = int(np.argmin(np.linalg.norm(arm.rest() - (0.6, 0.6, 0.0), axis=1)))
    place, normal, made = arm.points()[vertex], bone_now()[:3, 2], bone_now()
    pressed = {"origin": place + normal, "direction": -normal}
    bpy.ops.sinew.drag(**pressed, value=(0.0, 0.0, 0.3), radius=0.15, method=method)
    assert arm.deformer.handles[arm.deformer.active_handle].stands_on == "SURFACE"
    for frame in frames():
        turned = (bone_now() @ np.linalg.inv(made))[:3, :3] @ (0.0, 0.0, 0.3)
        wanted = scenes.apply_matrix(bone_now(), arm.rest()[[vertex]]) + turned
        assert scenes.close(arm.points()[[vertex]], wanted, scenes.MATRIX if method == "arap" else 0.02), (
            frame
        )


def test_factor_follows_the_bend_of_a_bone_and_so_does_a_shape_key_made_of_it(corrected: Posed):
    def follows(value: Callable[[], float]) -> None:
        for frame, factor in ((1, 0.0), (MADE, 1.0)):
            go(frame)
            assert value() == pytest.approx(factor, abs=1e-5)

    scenes.make_active(corrected.obj)
    rig = bpy.data.objects["Rig"]
    rig.rotation_euler = (2.0, 0.0, 1.0)  # where it stands does not count
    scenes.update()
    assert bpy.ops.sinew.drive_by_bone() == {"FINISHED"}
    rig.rotation_euler = (0.0, 0.0, 0.0)
    follows(lambda: corrected.obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).sinew.active.factor)
    scenes.press(corrected.obj, "apply", as_shape_key=True, keep_deformer=True)
    corrected.obj.modifiers[-1].show_viewport = False
    follows(lambda: corrected.obj.data.shape_keys.key_blocks[-1].value)
    assert scenes.close(corrected.far_edge(), corrected.expected(), scenes.MATRIX)
    go(1)
    scenes.refused("is bent now", "drive_by_bone", corrected.obj)
    scenes.refused("no bone 'hand'", "drive_by_bone", corrected.obj, armature="Rig", bone="hand")


@pytest.mark.parametrize("on_cage", [True, False])
def test_grab_region_moves_what_is_seen_as_far_as_the_mouse(arm: Posed, on_cage: bool):
    """Without the armature in Edit Mode, the mesh at rest is seen."""
    seen = arm.points if on_cage else arm.rest
    before = seen()
    arm.obj.modifiers[0].show_in_editmode = arm.obj.modifiers[0].show_on_cage = on_cage
    edit(arm.obj, lambda point: point.y > 0.75)
    bpy.ops.sinew.grab_region(value=(0.1, 0.2, 0.3), radius=0.3)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert scenes.close(seen()[arm.top], before[arm.top] + (0.1, 0.2, 0.3), scenes.MATRIX)


SIDES = {"L": 1.0, "R": -1.0}


@pytest.mark.parametrize("live", [True, False])
def test_the_other_side_follows_in_the_frame_of_its_own_surface(arm: Posed, live: bool):
    """By Mirror while the arm is bent, or by Mirror where both sides are posed alike."""
    go(1)
    ends = {
        side: scenes.add_group(
            arm.obj, f"Hand.{side}", lambda point, s=sign: s * point[0] > 0.5 and point[1] > 0.75
        )
        for side, sign in SIDES.items()
    }
    bpy.ops.sinew.deformer_add(method="thin_shell")
    for side in SIDES if live else "L":
        scenes.press(arm.obj, "handle_add", kind="HANDLE", vertex_group=f"Hand.{side}")
    scenes.press(arm.obj, "handle_add", kind="FIXED", vertex_group="Base")
    arm.deformer.use_mirror_x = live
    scenes.update()
    go(7)
    arm.correct(LIFT)
    at_rest = np.linalg.inv(arm.made) @ arm.motion @ arm.made
    if not live:
        go(1)
        arm.deformer.active_handle = 0
        scenes.press(arm.obj, "handle_mirror")
    assert [handle.stands_on for handle in arm.deformer.handles if handle.control] == ["SURFACE"] * 2
    for frame in frames():
        shown = arm.points()
        for side, sign in SIDES.items():
            flip = np.diag((sign, 1.0, 1.0, 1.0))
            wanted = scenes.apply_matrix(bone_now() @ flip @ at_rest @ flip, arm.rest()[ends[side]])
            assert scenes.close(shown[ends[side]], wanted, 2e-5), (frame, side)


@pytest.mark.parametrize("whose", ["the mesh", "the control"])
def test_a_scale_of_zero_is_named_and_right_again_afterwards(corrected: Posed, whose: str):
    scaled = corrected.obj if whose == "the mesh" else corrected.control
    scale = scaled.scale.copy()
    go(7)
    scaled.scale.x = 0.0
    scenes.update()
    assert whose == "the control" or "scaled to zero" in corrected.deformer.status
    go(9)
    scaled.scale = scale
    assert corrected.is_right()
