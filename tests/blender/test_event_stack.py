# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers added, removed, applied, muted, moved, copied; ours too, by the buttons that Blender has."""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from expected import Expected, Poses
from inside import settle
from probe import render_points
from rig import (
    FLOAT32,
    Rig,
    add_armature,
    add_group,
    base_points,
    close,
    evaluated_points,
    grid_object,
    make_active,
    update,
)
from rigs import HandleRig

BEND = 0.7


def lattice_modifier(obj: bpy.types.Object) -> bpy.types.Modifier:
    """Simple Deform: it moves all vertices, and adds none."""
    modifier = obj.modifiers.new("Bend", "SIMPLE_DEFORM")
    modifier.deform_method, modifier.deform_axis, modifier.angle = "TWIST", "Y", BEND
    return modifier


def by_blender(points: np.ndarray, *modifiers: Callable[[bpy.types.Object], object]) -> np.ndarray:
    """What Blender's modifiers make of a plate with these points."""
    plain = grid_object("Plain", cells=round(len(points) ** 0.5) - 1)
    plain.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    plain.data.update()
    for add in modifiers:
        add(plain)
    found = evaluated_points(plain)
    mesh = plain.data
    bpy.data.objects.remove(plain)
    bpy.data.meshes.remove(mesh)
    return found


def to_the_top(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> None:
    make_active(obj)
    bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def to_the_end(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> None:
    make_active(obj)
    bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=len(obj.modifiers) - 1)


def test_a_deforming_modifier_below_above_moved_and_removed(posed_plate: tuple[Rig, Expected]):
    """Before ours in the stack its result is what we deform; after ours it works on our result."""
    plate, expected = posed_plate
    obj = plate.obj
    twist = lattice_modifier(obj)
    after = by_blender(expected.lifted(0.5), lattice_modifier)
    assert close(plate.points(), after)
    to_the_top(obj, twist)
    twisted = by_blender(plate.rest(), lattice_modifier)
    before = expected.now(obj, plate.control, incoming=twisted)
    assert np.abs(before - after).max() > 1e-2
    assert close(plate.points(), before)
    to_the_end(obj, obj.modifiers["Bend"])
    assert close(plate.points(), after)
    obj.modifiers["Bend"].show_viewport = False
    assert close(plate.points(), expected.lifted(0.5))
    assert close(render_points(obj), after)
    obj.modifiers["Bend"].show_viewport = True
    obj.modifiers.remove(obj.modifiers["Bend"])
    assert close(plate.points(), expected.lifted(0.5))
    settle()
    assert close(plate.points(), expected.lifted(0.5))
    assert plate.deformer.status_level == "INFO"


def test_a_deforming_modifier_before_ours_applied(plate: Rig):
    """The mesh takes its shape; what enters ours stays the same, and so does what is seen."""
    lattice_modifier(plate.obj)
    twisted = plate.points()
    plate.bind()
    expected = Expected(plate.obj, plate.control, points=twisted)
    plate.lift(0.5)
    assert close(plate.points(), expected.lifted(0.5))
    make_active(plate.obj)
    bpy.ops.object.modifier_apply(modifier="Bend")
    settle()
    assert close(plate.rest(), twisted)
    assert close(plate.points(), expected.lifted(0.5))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    assert plate.deformer.status_level == "INFO"


def subdivision(obj: bpy.types.Object) -> bpy.types.Modifier:
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 1
    return modifier


def array(obj: bpy.types.Object) -> bpy.types.Modifier:
    modifier = obj.modifiers.new("Array", "ARRAY")
    modifier.relative_offset_displace = (0.0, 0.0, 0.0)
    modifier.use_constant_offset, modifier.constant_offset_displace = True, (0.0, 0.0, 3.0)
    return modifier


def solidify(obj: bpy.types.Object) -> bpy.types.Modifier:
    modifier = obj.modifiers.new("Solidify", "SOLIDIFY")
    modifier.thickness = 0.1
    return modifier


@pytest.mark.parametrize("add", [subdivision, array, solidify], ids=lambda add: add.__name__)
def test_a_constructive_modifier_after_ours_added_applied_and_removed(posed_plate: tuple[Rig, Expected], add):
    plate, expected = posed_plate
    modifier = add(plate.obj)
    for height in (0.5, 0.75):
        plate.lift(height - 0.5)
        assert close(plate.points(), by_blender(expected.lifted(height), add), 1e-5)
        assert close(render_points(plate.obj), by_blender(expected.lifted(height), add), 1e-5)
    plate.obj.modifiers.remove(modifier)
    settle()
    assert close(plate.points(), expected.lifted(0.75))
    assert plate.deformer.status_level == "INFO"


@pytest.mark.parametrize("automatic", [False, True])
def test_a_constructive_modifier_after_ours_applied(posed_plate: tuple[Rig, Expected], automatic: bool):
    """Blender applies it to the mesh, without the pose: the deformer has another mesh before it then."""
    plate, expected = posed_plate
    plate.deformer.auto_rebind = automatic
    subdivision(plate.obj)
    plate.points()
    make_active(plate.obj)
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    assert len(plate.rest()) > 400
    settle()
    if not automatic:
        assert close(plate.points(), plate.rest())
        assert plate.deformer.status == "Topology changed - Rebind"
        bpy.ops.sinew.bind()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5), 1e-5)
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75), 1e-5)


@pytest.mark.parametrize("add", [subdivision, array], ids=lambda add: add.__name__)
@pytest.mark.parametrize("automatic", [False, True])
def test_a_constructive_modifier_put_before_ours(posed_plate: tuple[Rig, Expected], add, automatic: bool):
    """Other vertices enter: rest and a word about it, right after Rebind or by itself, right when it goes."""
    plate, expected = posed_plate
    obj = plate.obj
    plate.deformer.auto_rebind = automatic
    to_the_top(obj, add(obj))
    settle()
    if not automatic:
        assert close(plate.points(), by_blender(plate.rest(), add))
        assert plate.deformer.status == "Topology changed - Rebind"
        make_active(obj)
        bpy.ops.sinew.bind()
    entering = by_blender(plate.rest(), add)
    fresh = Rig(grid_object("Fresh"))
    add(fresh.obj)
    fresh.bind()
    fresh.lift(0.5)
    shown = fresh.points()
    assert np.abs(shown - entering).max() > 0.4
    assert close(plate.points(), shown)
    obj.modifiers.remove(obj.modifiers[0])
    settle()
    if not automatic:
        assert close(plate.points(), plate.rest())
        make_active(obj)
        bpy.ops.sinew.bind()
    assert close(plate.points(), expected.lifted(0.5))


@pytest.mark.parametrize("levels", [(1, 2), (2, 1), (0, 1)])
def test_other_subdivision_levels_in_renders_before_ours(plate: Rig, levels: tuple[int, int]):
    """Each as a rig of its own that has these levels in the viewport."""
    subdivision(plate.obj)
    plate.obj.modifiers["Subdivision"].levels, plate.obj.modifiers["Subdivision"].render_levels = levels
    plate.bind()
    plate.lift(0.5)
    expected = []
    for level in levels:
        fresh = Rig(grid_object(f"Level {level}"))
        subdivision(fresh.obj)
        fresh.obj.modifiers["Subdivision"].levels = fresh.obj.modifiers["Subdivision"].render_levels = level
        fresh.bind()
        fresh.lift(0.5)
        expected.append(fresh.points())
    for _ in range(2):
        assert close(plate.points(), expected[0])
        assert close(render_points(plate.obj), expected[1])
    assert plate.deformer.status_level == "INFO"


@pytest.mark.parametrize("shown_in", ["viewport", "render"])
def test_a_modifier_before_ours_that_is_shown_in_one_place_only(plate: Rig, shown_in: str):
    twist = lattice_modifier(plate.obj)
    twist.show_viewport = twist.show_render = True
    twisted = plate.points()
    twist.show_viewport, twist.show_render = shown_in == "viewport", shown_in == "render"
    plate.bind()
    flat = plate.rest()
    expected = Expected(plate.obj, plate.control, points=twisted if shown_in == "viewport" else flat)
    plate.lift(0.5)
    in_viewport, in_render = (twisted, flat) if shown_in == "viewport" else (flat, twisted)
    assert close(plate.points(), expected.now(plate.obj, plate.control, incoming=in_viewport))
    assert close(render_points(plate.obj), expected.now(plate.obj, plate.control, incoming=in_render))


def test_ours_muted_and_shown(posed: tuple[HandleRig, Poses]):
    rig, expected = posed
    modifier = rig.obj.modifiers[0]
    modifier.show_viewport = False
    assert rig.shows(rig.rest())
    rig.lift(0.25)
    assert rig.shows(rig.rest())
    assert close(render_points(rig.obj), expected.lifted(0.75), rig.tolerance)
    modifier.show_viewport = True
    assert rig.shows(expected.lifted(0.75))
    modifier.show_render = False
    assert close(render_points(rig.obj), rig.rest(), rig.tolerance)
    assert rig.shows(expected.lifted(0.75))


def test_ours_applied_by_blenders_own_button(posed_plate: tuple[Rig, Expected]):
    """The mesh takes the shape once; the deformer left behind deforms nothing, and says what to do."""
    plate, expected = posed_plate
    make_active(plate.obj)
    bpy.ops.object.modifier_apply(modifier=plate.obj.modifiers[0].name)
    settle()
    assert close(plate.rest(), expected.lifted(0.5))
    assert close(plate.points(), expected.lifted(0.5))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.5))
    assert plate.deformer.status_level in ("ERROR", "WARNING")
    make_active(plate.obj)
    bpy.ops.sinew.deformer_remove()
    assert close(plate.points(), expected.lifted(0.5))


def test_ours_removed_by_blenders_own_button_and_bound_again(posed: tuple[HandleRig, Poses]):
    rig, expected = posed
    make_active(rig.obj)
    bpy.ops.object.modifier_remove(modifier=rig.obj.modifiers[0].name)
    settle()
    assert rig.shows(rig.rest())
    assert rig.deformer.status_level in ("ERROR", "WARNING")
    bpy.ops.sinew.bind()
    assert rig.shows(expected.lifted(0.5))
    assert len(rig.obj.modifiers) == 1


@pytest.mark.parametrize("rig", ["handles", "cage"], indirect=True)
def test_ours_copied_by_blenders_own_button(posed: tuple[HandleRig, Poses]):
    """Two modifiers show one shape: the pose is seen once, not twice."""
    rig, expected = posed
    make_active(rig.obj)
    bpy.ops.object.modifier_copy(modifier=rig.obj.modifiers[0].name)
    for height in (0.5, 0.75, 1.0):
        settle()
        assert rig.shows(expected.lifted(height))
        rig.lift(0.25)
    bpy.ops.object.modifier_remove(modifier=rig.obj.modifiers[0].name)
    settle()
    assert rig.shows(expected.lifted(1.25))


def test_modifiers_copied_to_another_object(posed_plate: tuple[Rig, Expected]):
    """It shows the shape as a mirror does; the rig stays one."""
    plate, expected = posed_plate
    other = grid_object("Other")
    make_active(plate.obj)
    other.select_set(True)
    bpy.ops.object.make_links_data(type="MODIFIERS")
    settle()
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    assert close(evaluated_points(other), expected.lifted(0.75))
    bpy.data.objects.remove(other)
    settle()
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(1.0))


def test_all_modifiers_applied_by_converting_to_a_mesh(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    subdivision(plate.obj)
    smooth = by_blender(expected.lifted(0.5), subdivision)
    make_active(plate.obj)
    bpy.ops.object.convert(target="MESH")
    settle()
    assert close(plate.points(), smooth, 1e-5)
    plate.obj.update_tag()
    settle()
    assert close(plate.points(), smooth, 1e-5)


# --- several deformers


def second_deformer(plate: Rig) -> tuple[bpy.types.Object, Expected]:
    """A corner that moves by itself; its control, and what it does to what enters."""
    obj = plate.obj
    add_group(obj, "Corner", lambda point: point[0] > 0.75 and point[1] > 0.75)
    add_group(obj, "Rest", lambda point: point[0] < 0.3 or point[1] < 0.3)
    make_active(obj)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Corner")
    make_active(obj)
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Rest")
    control = obj.sinew.deformers[1].handles[0].control
    return control, Expected(obj, control, handle="Corner", fixed=("Rest",))


def test_our_modifiers_in_another_order_keep_their_own_settings(plate: Rig):
    plate.bind()
    first = Expected.of_rig(plate)
    control = plate.control
    corner, second = second_deformer(plate)
    control.matrix_world.translation.z += 0.5
    corner.location.x += 0.2
    update()
    rest = plate.rest()
    one = second.now(plate.obj, corner, incoming=first.now(plate.obj, control).astype(np.float32))
    assert close(plate.points(), one, 2 * FLOAT32)
    names = [modifier.name for modifier in plate.obj.modifiers]
    to_the_end(plate.obj, plate.obj.modifiers[0])
    assert [modifier.name for modifier in plate.obj.modifiers] == names[::-1]
    settle()
    two = first.now(plate.obj, control, incoming=second.now(plate.obj, corner).astype(np.float32))
    assert close(plate.points(), two, 2 * FLOAT32)
    plate.obj.modifiers[0].show_viewport = False
    settle()
    assert close(plate.points(), first.now(plate.obj, control))
    plate.obj.modifiers[0].show_viewport = True
    make_active(plate.obj)
    bpy.ops.sinew.deformer_remove(index=0)
    settle()
    assert close(plate.points(), second.now(plate.obj, corner))
    assert close(plate.rest(), rest)


def test_a_modifier_between_two_of_ours_comes_and_goes(plate: Rig):
    plate.bind()
    first = Expected.of_rig(plate)
    control = plate.control
    corner, second = second_deformer(plate)
    control.matrix_world.translation.z += 0.5
    corner.location.x += 0.2
    lattice_modifier(plate.obj)
    make_active(plate.obj)
    bpy.ops.object.modifier_move_to_index(modifier="Bend", index=1)
    settle()
    twisted = by_blender(first.now(plate.obj, control), lattice_modifier)
    between = second.now(plate.obj, corner, incoming=twisted.astype(np.float32))
    assert close(plate.points(), between, 1e-5)
    plate.obj.modifiers.remove(plate.obj.modifiers["Bend"])
    settle()
    straight = second.now(plate.obj, corner, incoming=first.now(plate.obj, control).astype(np.float32))
    assert close(plate.points(), straight, 2 * FLOAT32)


def test_shape_keys_added_blended_and_removed(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    obj = plate.obj
    obj.shape_key_add(name="Basis")
    wave = obj.shape_key_add(name="Wave")
    for point in wave.data:
        point.co.z = 0.2 * point.co.x
    settle()
    for value in (0.0, 1.0, 0.5):
        wave.value = value
        entering = base_points(obj).copy()
        entering[:, 2] += value * 0.2 * entering[:, 0]
        assert close(plate.points(), expected.now(obj, plate.control, incoming=entering))
    obj.shape_key_clear()
    settle()
    assert close(plate.points(), expected.lifted(0.5))


def test_an_armature_added_before_a_living_deformer(posed_plate: tuple[Rig, Expected]):
    """The skin comes after the pose: the deformer then works on what the bones give it."""
    plate, expected = posed_plate
    armature = add_armature(plate.obj)
    to_the_top(plate.obj, plate.obj.modifiers["Armature"])
    bone = armature.pose.bones["high"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = (0.0, 0.0, 0.4)
    update()
    turned = plate.rest()
    high = turned[:, 1] > 0.0
    matrix = np.array(bone.matrix @ bone.bone.matrix_local.inverted())
    turned[high] = turned[high] @ matrix[:3, :3].T + matrix[:3, 3]
    assert close(plate.points(), expected.now(plate.obj, plate.control, incoming=turned), 1e-5)
