# SPDX-License-Identifier: GPL-3.0-or-later
"""What an update costs when nothing of ours changed: counted in calls, the same on every machine."""

import bpy
import pytest
from inside import CONTROL_READS, LOOKS, READS, WORK, calls_of, catch_up, functions, inner
from rigs.rig import Rig, linked, make_active, update

UNRELATED = 1000


def crowd(count: int) -> list[bpy.types.Object]:
    """Empties and meshes that have nothing to do with us."""
    mesh = bpy.data.meshes.new("Point")
    mesh.vertices.add(1)
    made = []
    for number in range(count):
        obj = linked(bpy.data.objects.new(f"Unrelated {number}", mesh if number % 2 else None))
        made.append(obj)
    update()
    return made


def nudge(obj: bpy.types.Object) -> None:
    obj.location.x += 0.1
    update()


@pytest.fixture
def crowded(plate: Rig) -> tuple[Rig, list[bpy.types.Object]]:
    """One bound and posed plate among a thousand objects; two updates have passed."""
    plate.bind().lift(0.5)
    others = crowd(UNRELATED)
    make_active(others[0])
    for _ in range(2):
        nudge(others[0])
    return plate, others


def test_moving_something_else_does_no_work_of_ours(crowded):
    _plate, others = crowded
    for obj in others[:4]:
        found = calls_of(lambda obj=obj: nudge(obj))
        assert found["on_depsgraph_update"] == 1, found
        assert not WORK & found.keys(), found
        assert found.total() < 60, found


def test_what_an_update_calls_does_not_grow_with_the_scene_or_the_mesh():
    counts = []
    for unrelated, cells in ((4, 6), (UNRELATED, 30)):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        Rig.plate(cells=cells).bind().lift(0.5)
        others = crowd(unrelated)
        for _ in range(2):
            nudge(others[0])
        counts.append(calls_of(lambda others=others: nudge(others[1])).total())
    assert counts[0] == counts[1]
    assert counts[0] < 60


def test_without_a_deformer_an_update_calls_next_to_nothing():
    others = crowd(8)
    nudge(others[0])
    assert calls_of(lambda: nudge(others[0])).total() <= 6


def test_changing_the_frame_solves_nothing_when_nothing_of_ours_moves(crowded):
    plate, others = crowded
    others[0].keyframe_insert("location", frame=1)
    others[0].location.x += 1.0
    others[0].keyframe_insert("location", frame=11)
    scene = bpy.context.scene
    for frame in (1, 11):
        scene.frame_set(frame)
    found = calls_of(lambda: scene.frame_set(5))
    assert found["on_frame_change"] == 1, found
    assert not {"solve", "write_shape", "write_positions", "read_rest"} & found.keys(), found
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=1e-6)


def test_objects_that_are_not_ours_get_no_settings(crowded):
    """Blender makes settings where they are read, in render threads too, and saves them with the file."""
    plate, others = crowded
    bpy.context.scene.frame_set(5)
    catch_up()
    make_active(others[1])
    assert not bpy.ops.sinew.bind.poll()
    assert plate.obj.is_property_set("sinew")
    assert not any(obj.is_property_set("sinew") for obj in (*others, plate.control))


def test_a_deformer_has_all_its_settings_before_a_render_reads_them(crowded):
    plate, _others = crowded
    assert all(plate.deformer.is_property_set(name) for name in ("bake", *inner.methods.BY_ID))


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
