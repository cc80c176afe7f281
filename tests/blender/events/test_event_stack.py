# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers added, removed, applied, muted, moved, copied; ours too, by the buttons that Blender has."""

from collections.abc import Callable

import bpy
import events
import numpy as np
import pytest
from expected import Expected
from inside import notes_of, settle
from mathutils import Matrix
from probe import render_points
from rigs import rig as scenes
from rigs.kinds import HandleRig

EVENTS = events.Table()
Add = Callable[[bpy.types.Object], bpy.types.Modifier]


def twist(obj: bpy.types.Object) -> bpy.types.Modifier:
    """It moves all vertices, and adds none."""
    modifier = obj.modifiers.new("Twist", "SIMPLE_DEFORM")
    modifier.deform_method, modifier.deform_axis, modifier.angle = "TWIST", "Y", 0.7
    return modifier


def subdivision(obj: bpy.types.Object, levels: int = 1, render_levels: int = 1) -> bpy.types.Modifier:
    return scenes.subdivided(obj, levels, render_levels)


def array(obj: bpy.types.Object) -> bpy.types.Modifier:
    modifier = obj.modifiers.new("Array", "ARRAY")
    modifier.relative_offset_displace = (0.0, 0.0, 0.0)
    modifier.use_constant_offset, modifier.constant_offset_displace = True, (0.0, 0.0, 3.0)
    return modifier


def solidify(obj: bpy.types.Object) -> bpy.types.Modifier:
    modifier = obj.modifiers.new("Solidify", "SOLIDIFY")
    modifier.thickness = 0.1
    return modifier


def by_blender(rig: scenes.Rig, points: np.ndarray, *modifiers: Add) -> np.ndarray:
    """What Blender's modifiers make of the rig's mesh with these points."""
    mesh = rig.obj.data.copy()
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.update()
    plain = scenes.linked(bpy.data.objects.new("Plain", mesh))
    for add in modifiers:
        add(plain)
    found = scenes.evaluated_points(plain)
    bpy.data.objects.remove(plain)
    bpy.data.meshes.remove(mesh)
    return found


def move_to(rig: scenes.Rig, name: str, index: int) -> None:
    """A modifier, in the stack."""
    scenes.make_active(rig.obj)
    bpy.ops.object.modifier_move_to_index(modifier=name, index=index)


def apply(rig: scenes.Rig, name: str) -> None:
    """By Blender's own button."""
    scenes.make_active(rig.obj)
    bpy.ops.object.modifier_apply(modifier=name)
    settle()


# --- Blender's modifiers


@EVENTS.on(events.REGIONS)
def a_deforming_modifier_before_ours_applied(rig: HandleRig) -> None:
    """The mesh takes its shape; what enters ours stays the same, and so does what is seen."""
    rig.press("unbind")
    rig.relax()
    rig.lift_to(0.0)
    twist(rig.obj)
    move_to(rig, "Twist", 0)
    rig.press("bind")
    twisted = by_blender(rig, rig.rest(), twist)
    rig.poses.rebind(rig.obj, twisted)
    rig.lift(0.5)
    assert rig.is_right()
    apply(rig, "Twist")
    assert scenes.close(rig.rest(), twisted)


@EVENTS.on(events.MESHES)
def a_constructive_modifier_added_after_ours_and_removed(rig: HandleRig) -> None:
    for add in (subdivision, array, solidify):
        modifier = add(rig.obj)
        for _ in range(2):
            shown = by_blender(rig, rig.at(rig.height), add)
            assert rig.shows(shown, tolerance=1e-5)
            assert rig.renders(shown, 1e-5)
            rig.lift(0.1)
        rig.obj.modifiers.remove(modifier)
        settle()
        assert rig.is_right()


def is_noticed(rig: HandleRig, automatic: bool, resting: np.ndarray) -> None:
    """Other vertices enter: rest and a word about it, right after Rebind or by itself."""
    settle()
    if not automatic:
        assert rig.shows(resting)
        assert rig.deformer.status == events.REBIND
        rig.press("bind")


@pytest.mark.parametrize("automatic", [False, True])
@pytest.mark.parametrize("rig", events.MESHES, indirect=True)
@pytest.mark.parametrize("add", [subdivision, array], ids=lambda add: add.__name__)
def test_a_constructive_modifier_put_before_ours(posed: HandleRig, add: Add, automatic: bool):
    """And so when it goes."""
    posed.deformer.auto_rebind = automatic
    rest = posed.rest()
    modifier = add(posed.obj)
    move_to(posed, modifier.name, 0)
    entering = by_blender(posed, rest, add)
    is_noticed(posed, automatic, entering)
    shown = posed.points()
    assert np.abs(shown - entering).max() > 0.4
    if posed.deformer.handles:
        fresh = HandleRig(scenes.grid_object("Fresh"))
        add(fresh.obj)
        fresh.bind()
        fresh.lift(0.5)
        assert posed.shows(fresh.points())
    else:
        assert posed.shows(posed.poses.warp(entering) + (0.0, 0.0, 0.5), tolerance=1e-5)
    posed.obj.modifiers.remove(posed.obj.modifiers[0])
    settle()
    (events.rebinds_by_itself if automatic else events.says_rebind)(posed)


@pytest.mark.parametrize("automatic", [False, True])
def test_a_constructive_modifier_after_ours_applied(posed_plate: HandleRig, automatic: bool):
    """Blender applies it to the mesh, without the pose: the deformer has another mesh before it then."""
    posed_plate.deformer.auto_rebind = automatic
    subdivision(posed_plate.obj)
    posed_plate.points()
    apply(posed_plate, "Subdivision")
    assert len(posed_plate.rest()) > 400
    is_noticed(posed_plate, automatic, posed_plate.rest())
    events.rebinds_by_itself(posed_plate)


@EVENTS.on(events.REGIONS)
def shape_keys_added_blended_and_removed(rig: HandleRig) -> None:
    obj, entering = rig.obj, rig.rest()
    wave = scenes.add_key(obj, "Wave", scenes.slope(0.2))
    settle()
    for value in (0.0, 1.0, 0.5):
        wave.value = value
        entering[:, 2] = value * 0.2 * entering[:, 0]
        assert rig.shows(rig.now(incoming=entering))
    obj.shape_key_clear()


@EVENTS.on(events.MESHES, then=events.is_over)
def an_armature_added_before_it(rig: HandleRig) -> None:
    """The skin comes after the pose: the deformer then works on what the bones give it."""
    armature = scenes.add_armature(rig.obj)
    move_to(rig, "Armature", 0)
    bone = armature.pose.bones["high"]
    bone.rotation_euler = (0.0, 0.0, 0.4)
    scenes.update()
    turned = rig.rest()
    high = turned[:, 1] > 0.0
    turned[high] = scenes.apply_matrix(bone.matrix @ bone.bone.matrix_local.inverted(), turned[high])
    assert rig.shows(rig.now(incoming=turned), tolerance=1e-5)


def test_a_modifier_that_makes_other_vertices_gets_displacements(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    plate.bind()
    plate.obj.modifiers.new("Remesh", "REMESH").voxel_size = 0.1
    plate.lift(0.5)
    armature.pose.bones["high"].location = (0.0, 0.0, 0.2)
    assert plate.points()[:, 2].max() > 0.3


def test_vertices_in_another_order_keep_their_own_displacement(plate: scenes.Rig):
    """Build can shuffle the vertices of a complete mesh: the set of points must stay what it was."""
    plate.bind().lift(0.5)
    ordered = plate.points()
    build = plate.obj.modifiers.new("Build", "BUILD")
    build.frame_start, build.frame_duration = -100.0, 1.0
    build.use_random_order, build.seed = True, 3
    plate.lift(0.0)
    shuffled = plate.points()
    assert not np.array_equal(shuffled, ordered)
    assert scenes.close(*(points[np.lexsort(np.round(points, 4).T)] for points in (ordered, shuffled)))
    assert any("displacement" in text for text in notes_of(plate.deformer))


@pytest.mark.parametrize("levels", [(1, 2), (2, 1), (0, 1), (0, 2)])
def test_other_subdivision_levels_in_renders_before_ours(plate: scenes.Rig, levels: tuple[int, int]):
    """Each as a rig of its own that has these levels in the viewport."""
    expected = []
    for level in levels:
        fresh = scenes.Rig(scenes.grid_object(f"Level {level}"))
        subdivision(fresh.obj, level, level)
        fresh.bind().lift(0.5)
        expected.append(fresh.points())
    subdivision(plate.obj, *levels)
    plate.bind().lift(0.5)
    for _ in range(2):
        assert scenes.close(plate.points(), expected[0])
        assert scenes.close(render_points(plate.obj), expected[1])
    assert plate.deformer.status_level == "INFO"


@pytest.mark.parametrize("in_viewport", [True, False])
def test_a_modifier_before_ours_that_is_shown_in_one_place_only(plate: scenes.Rig, in_viewport: bool):
    modifier, flat = twist(plate.obj), plate.rest()
    modifier.show_viewport, modifier.show_render = in_viewport, not in_viewport
    shapes = [by_blender(plate, flat, twist), flat]
    viewport, rendered = shapes if in_viewport else shapes[::-1]
    plate.bind()
    plate.deformer.handles[0].stands_on = "WORLD"  # as its pose is read there
    expected = Expected(plate.obj, plate.control, points=viewport)
    plate.lift(0.5)
    assert scenes.close(plate.points(), expected.now(plate.obj, plate.control, incoming=viewport))
    assert scenes.close(render_points(plate.obj), expected.now(plate.obj, plate.control, incoming=rendered))


# --- ours, by Blender's own buttons


@EVENTS.on(events.ALL)
def ours_muted_and_shown(rig: HandleRig) -> None:
    modifier = rig.obj.modifiers[0]
    modifier.show_viewport = False
    for lift in (0.0, 0.25):
        rig.lift(lift)
        assert rig.is_at_rest()
    assert rig.renders(rig.at(0.75))
    modifier.show_viewport, modifier.show_render = True, False
    assert rig.is_right()
    assert rig.renders(rig.rest())
    assert rig.is_right()
    modifier.show_render = True


@EVENTS.on(events.MESHES)
def ours_copied(rig: HandleRig) -> None:
    """Two modifiers show one shape: the pose is seen once, not twice."""
    scenes.make_active(rig.obj)
    bpy.ops.object.modifier_copy(modifier=rig.obj.modifiers[0].name)
    for _ in range(3):
        settle()
        assert rig.is_right()
        rig.lift(0.25)
    bpy.ops.object.modifier_remove(modifier=rig.obj.modifiers[0].name)


@EVENTS.on(events.MESHES, then=events.is_over)
def ours_applied(rig: HandleRig) -> None:
    """The mesh takes the shape once; the deformer left behind deforms nothing, and says what to do."""
    apply(rig, rig.obj.modifiers[0].name)
    shape = rig.at(0.5)
    assert scenes.close(rig.rest(), shape)
    for _ in range(2):
        assert rig.shows(shape)
        rig.lift(0.25)
    assert rig.deformer.status_level in ("ERROR", "WARNING")
    rig.press("deformer_remove")
    assert rig.shows(shape)


@EVENTS.on(events.ALL, then=events.bind_restores)
def ours_removed(rig: HandleRig) -> None:
    scenes.make_active(rig.obj)
    bpy.ops.object.modifier_remove(modifier=rig.obj.modifiers[0].name)


@EVENTS.on(events.MESHES)
def ours_copied_to_another_object(rig: HandleRig) -> None:
    """It shows the shape as a mirror does; the rig stays one."""
    other = scenes.linked(bpy.data.objects.new("Other", rig.obj.data.copy()))
    scenes.make_active(rig.obj, other)
    bpy.ops.object.make_links_data(type="MODIFIERS")
    settle()
    rig.lift(0.25)
    assert rig.is_right()
    assert rig.shows(rig.at(0.75), other)
    bpy.data.objects.remove(other)


@EVENTS.on(events.MESHES, then=events.is_over)
def converted_to_a_mesh(rig: HandleRig) -> None:
    subdivision(rig.obj)
    smooth = by_blender(rig, rig.at(0.5), subdivision)
    scenes.make_active(rig.obj)
    bpy.ops.object.convert(target="MESH")
    for _ in range(2):
        settle()
        assert rig.shows(smooth, tolerance=1e-5)
        rig.obj.update_tag()


# --- several deformers

LIFT, SHIFT = Matrix.Translation((0.0, 0.0, 0.5)), Matrix.Translation((0.2, 0.0, 0.0))


def test_the_second_of_two_deformers_is_right_at_once_in_a_jump(plate: scenes.Rig):
    """No frame of delay: the answer after one jump is the answer after many evaluations."""
    first = plate.bind().control
    for name, where in (("Corner", lambda p: min(p[:2]) > 0.3), ("Rest", lambda p: min(p[:2]) < 0.1)):
        scenes.add_group(plate.obj, name, where)
    scenes.add_regions(plate.obj, "arap", {"Corner": "HANDLE", "Rest": "FIXED"})
    scenes.key_heights(first, {1: 0.0, 10: 0.8})
    plate.obj.sinew.deformers[1].handles[0].control.rotation_euler.x = 0.4
    bpy.context.scene.frame_set(1)
    bpy.context.scene.frame_set(10)
    once = plate.points()
    assert np.abs(once - plate.rest()).max() > 0.7
    for _ in range(3):
        plate.obj.update_tag()
        scenes.update()
    assert np.array_equal(once, plate.points())


@pytest.mark.parametrize("moved", [True, False])
def test_the_second_follows_at_once_where_the_first_lets_go(plate: scenes.Rig, moved: bool):
    """What enters it in that evaluation is still what the first one showed before."""
    control = plate.bind().control
    bpy.ops.sinew.deformer_add(method="arap")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Top")
    if moved:
        scenes.move_world(control, Matrix.Translation((0.0, 0.0, 0.5)))
    assert (np.abs(plate.points() - plate.rest()).max() > 0.4) == moved
    handle = plate.obj.sinew.deformers[0].handles[1]
    handle.vertex_group = "Top"  # refused, since the other region has these vertices
    assert scenes.close(plate.points(), plate.rest())
    handle.vertex_group = "Base"
    assert (np.abs(plate.points() - plate.rest()).max() > 0.4) == moved


@EVENTS.on(events.MESHES)
def given_deformers_without_regions_between(rig: HandleRig) -> None:
    """What they let through reaches the next at once."""
    for _ in range(2):
        rig.press("deformer_add", method="thin_shell")
    extent = np.abs(rig.rest()).max()
    scenes.add_group(rig.obj, "Corner", lambda p: p[0] < -0.75 * extent and p[1] < 0.5 * extent)
    rig.press("handle_add", kind="HANDLE", vertex_group="Corner")
    rig.obj.sinew.active_deformer = 0
    rig.lift(0.4)
    once = rig.points()
    rig.obj.update_tag()
    assert np.array_equal(rig.points(), once)
    rig.press("deformer_remove", index=2)
    rig.press("deformer_remove", index=1)
    rig.obj.sinew.active_deformer = 0


# --- each of them


@events.every(EVENTS)
def test_a_rig_lives_through(posed: HandleRig, event: events.Event):
    event.run(posed)
