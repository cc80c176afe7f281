# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame costs: calls of Blender and of the native module, and bytes: the same on any machine."""

from __future__ import annotations

import tracemalloc
from collections import Counter
from collections.abc import Callable

import bpy
import pytest
from inside import CONTROL_READS, LOOKS, READS, WORK, calls_of, catch_up, dragging, functions, inner
from registry import BY_ID, WITH_HANDLES
from rigs.kinds import HandleRig
from rigs.rig import Rig, add_armature, key_heights, linked, make_active, new_file, update

CELLS = 60  # 3,721 vertices: one array of them is larger than all else that a frame allocates
SHAPE = 12  # bytes a vertex, of a shape array
# What looks at the rig, once its target has changed.
RIG = {"modifier_input", "tell_copies_apart", "follow_renamed_groups", "_layout", "read_incoming"}


@pytest.fixture
def native(count_native) -> Counter:
    """How often the native module was asked for something."""
    binds = ("SurfaceMesh", "diagnose", "set_handles", "bind", "rebind")
    return count_native(
        inner.backend.availability().module, *binds, "solve", "solve_frame", "warp", "warp_poses"
    )


def peak_of(action: Callable[[], object]) -> int:
    """The most bytes that Python and NumPy held at once during the action, beyond those before it."""
    tracemalloc.start()
    try:
        action()
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        action()
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()


def bytes_per_vertex(rig: Rig, action: Callable[[], object]) -> float:
    return peak_of(action) / len(rig.obj.data.vertices)


def moving(rig: Rig) -> Rig:
    """After some moves, as in a drag."""
    for _ in range(3):
        rig.lift(0.1)
    return rig


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_moved_control_is_one_solve_and_one_write(method: str, native: Counter):
    plate = moving(Rig.plate(CELLS).bind(method))
    native.clear()
    found = calls_of(lambda: plate.lift(0.1))
    row = BY_ID[method]
    assert native == {"warp_poses" if row.is_space else "solve_frame" if row.keyed else "solve": 1}
    assert found["write_shape"] == found["write_positions"] == found["_answer"] == 1, found
    assert found["read_poses"] == found["shape_array"] == 1, found
    assert not (READS | LOOKS | RIG) & found.keys(), found
    native.clear()
    found = calls_of(update)
    assert not native
    assert found.total() < 60, found
    plate.obj.update_tag()
    assert calls_of(update).keys() >= RIG


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_moved_control_needs_one_new_array(method: str):
    """The shape that is written; the solver keeps its own memory from frame to frame.

    A space method needs the posed points of its handles too, so its regions are small here.
    """
    plate = moving(Rig.plate(CELLS, edge=0.99 if BY_ID[method].is_space else 0.75).bind(method))
    assert SHAPE < bytes_per_vertex(plate, lambda: plate.lift(0.1)) < 1.5 * SHAPE


def test_a_drag_widens_the_shape_that_it_starts_from():
    """And holds no other array as large as the mesh."""
    plate = moving(Rig.plate(CELLS).bind("arap"))

    def drag() -> None:
        with dragging():
            plate.lift(0.1)

    assert 3.0 * SHAPE < bytes_per_vertex(plate, drag) < 3.5 * SHAPE
    assert inner.sessions.unsettled()


def test_an_animated_pose_below_costs_one_read(native: Counter):
    """What enters is read once, compared, and given to the solver as it is."""
    plate = Rig.plate(CELLS)
    armature = add_armature(plate.obj)
    plate.bind("thin_shell")
    bone = armature.pose.bones["high"]

    def turn() -> None:
        bone.rotation_mode = "XYZ"
        bone.rotation_euler.x += 0.1
        update()

    for _ in range(3):
        turn()
    native.clear()
    found = calls_of(turn)
    assert native == {"solve": 1}
    assert found["read_incoming"] == found["write_positions"] == 1, found
    assert found["read_poses"] == 1, found
    assert not ((READS | LOOKS) - {"read_incoming"}) & found.keys(), found


@pytest.mark.parametrize("event", ["move", "frame"])
def test_an_evaluation_reads_a_control_once(rig: HandleRig, event: str):
    """It is compared with the last evaluation, and solved with, as it was read."""
    rig.start()
    for height, frame in ((0.1, 1), (0.2, 11)):
        rig.lift(height)
        rig.control.keyframe_insert("location", frame=frame)
    for frame in (1, 3, 5):
        bpy.context.scene.frame_set(frame)
    found = calls_of((lambda: bpy.context.scene.frame_set(8)) if event == "frame" else lambda: rig.lift(0.1))
    evaluations = found["on_frame_change"] + found["on_depsgraph_update"]
    assert found["write_shape"] == 1, found
    assert found["read_state"] == found["read_place"] == evaluations, found
    assert found["foreach_get"] == evaluations * rig.point_arrays, found


# --- an update in which nothing of ours has changed


UNRELATED = 1000


def crowd(count: int) -> list[bpy.types.Object]:
    """Empties and meshes that have nothing to do with us; two updates have passed."""
    mesh = bpy.data.meshes.new("Point")
    mesh.vertices.add(1)
    new = bpy.data.objects.new
    made = [linked(new(f"Unrelated {number}", mesh if number % 2 else None)) for number in range(count)]
    make_active(made[0])
    for _ in range(2):
        nudge(made[0])
    return made


def nudge(obj: bpy.types.Object) -> None:
    obj.location.x += 0.1
    update()


@pytest.fixture
def crowded(plate: Rig) -> tuple[Rig, list[bpy.types.Object]]:
    """One bound and posed plate among a thousand objects."""
    plate.bind().lift(0.5)
    return plate, crowd(UNRELATED)


def test_moving_something_else_does_no_work_of_ours(crowded):
    for obj in crowded[1][:4]:
        found = calls_of(lambda obj=obj: nudge(obj))
        assert found["on_depsgraph_update"] == 1, found
        assert not WORK & found.keys(), found
        assert found.total() < 60, found


def test_what_an_update_calls_does_not_grow_with_the_scene_or_the_mesh():
    """Without a deformer it calls next to nothing."""
    counts = []
    for unrelated, cells in ((8, None), (4, 6), (UNRELATED, 30)):
        new_file()
        if cells is not None:
            Rig.plate(cells=cells).bind().lift(0.5)
        others = crowd(unrelated)
        counts.append(calls_of(lambda others=others: nudge(others[1])).total())
    assert counts[0] <= 6
    assert counts[1] == counts[2] < 60


def test_changing_the_frame_solves_nothing_when_nothing_of_ours_moves(crowded):
    plate, others = crowded
    key_heights(others[0], {1: 0.0, 11: 1.0})
    scene = bpy.context.scene
    for frame in (1, 11):
        scene.frame_set(frame)
    found = calls_of(lambda: scene.frame_set(5))
    assert found["on_frame_change"] == 1, found
    assert not {"solve", "write_shape", "write_positions", "read_rest"} & found.keys(), found
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=1e-6)


def test_objects_that_are_not_ours_get_no_settings_and_a_deformer_has_all(crowded):
    """Blender makes settings where they are read, in render threads too, and saves them with the file."""
    plate, others = crowded
    assert all(plate.deformer.is_property_set(name) for name in ("bake", *inner.methods.BY_ID))
    bpy.context.scene.frame_set(5)
    catch_up()
    make_active(others[1])
    assert not bpy.ops.sinew.bind.poll()
    assert plate.obj.is_property_set("sinew")
    assert not any(obj.is_property_set("sinew") for obj in (*others, plate.control))


def test_the_functions_that_are_counted_exist():
    assert (WORK | READS | CONTROL_READS | LOOKS) - functions() == set()


def test_looking_at_edited_meshes_evaluates_the_scene_as_often_for_many_rigs_as_for_one(plate: Rig):
    plate.bind().lift(0.5)
    found = []
    for copies in (0, 9):
        for _ in range(copies):
            bpy.context.scene.collection.objects.link(plate.obj.copy())
        update()
        for obj in [obj for obj in bpy.data.objects if obj.sinew.deformers]:
            obj.data.update_tag()
        update()
        found.append(calls_of(inner.refresh.refresh)["on_depsgraph_update"])
    assert found[0] == found[1] > 0, found
