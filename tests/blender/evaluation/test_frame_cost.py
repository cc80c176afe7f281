# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame costs: calls of Blender and of the native module, and bytes: the same on any machine."""

from __future__ import annotations

import tracemalloc
from collections import Counter
from collections.abc import Callable

import bpy
import pytest
from inside import LOOKS, READS, calls_of, inner
from registry import BY_ID, WITH_HANDLES
from rigs.kinds import HandleRig
from rigs.rig import Rig, add_armature, update

CELLS = 60  # 3,721 vertices: one array of them is larger than all else that a frame allocates
SHAPE = 12  # bytes a vertex, of a shape array
# What looks at the rig, once its target has changed.
RIG = {"modifier_input", "tell_copies_apart", "follow_renamed_groups", "_layout", "read_incoming"}


@pytest.fixture
def native(count_native) -> Counter:
    """How often the native module was asked for something."""
    module = inner.backend.availability().module
    return count_native(
        module,
        "SurfaceMesh",
        "diagnose",
        "set_handles",
        "bind",
        "rebind",
        "solve",
        "solve_frame",
        "warp",
        "warp_poses",
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


def of_one_vertex(rig: Rig, size: int) -> float:
    return size / len(rig.obj.data.vertices)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_moved_control_is_one_solve_and_one_write(method: str, native: Counter):
    plate = Rig.plate(CELLS).bind(method)
    for _ in range(3):
        plate.lift(0.1)
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
    plate = Rig.plate(CELLS, edge=0.99 if BY_ID[method].is_space else 0.75).bind(method)
    for _ in range(3):
        plate.lift(0.1)
    assert SHAPE < of_one_vertex(plate, peak_of(lambda: plate.lift(0.1))) < 1.5 * SHAPE


def test_a_drag_widens_the_shape_that_it_starts_from():
    """And holds no other array as large as the mesh."""
    plate = Rig.plate(CELLS).bind("arap")
    evaluate, update_all = inner.evaluate, inner.evaluate.update
    for _ in range(3):
        plate.lift(0.1)

    def drag() -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(evaluate, "update", lambda graph, **_: update_all(graph, preview=True, edit=True))
            plate.lift(0.1)

    assert 3.0 * SHAPE < of_one_vertex(plate, peak_of(drag)) < 3.5 * SHAPE
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
