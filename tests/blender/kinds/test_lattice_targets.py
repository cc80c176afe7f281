# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattice objects as targets, as far as they differ from curves: shape keys show what moves them.

What holds for them as for curves is tested in ``test_cage_kinds`` and ``test_moves_anything``.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import inner, settle
from libraries import add_collection, override, put_into_a_library
from mathutils import Vector
from probe import render, render_points
from rigs.cages import ball
from rigs.lattice_objects import FLOAT32, UP, follower, held, key_of, moved_up, points_of
from rigs.point_objects import attach, bend, bind, lattice
from rigs.rig import (
    apply_matrix,
    duplicated,
    evaluated_points,
    in_mode,
    key,
    linked,
    make_active,
    new_empty,
    new_file,
    on_all,
    press,
    refused,
    reopen,
    update,
)
from rigs.sheet import draw, draw_panel
from second_blender import look_elsewhere


def with_keys() -> bpy.types.Object:
    """A lattice with two keys of the artist and modifiers."""
    obj = lattice()
    obj.shape_key_add(name="Rest", from_mix=False)
    block = obj.shape_key_add(name="Smile", from_mix=False)
    block.data[3].co += Vector((0.0, 0.3, 0.0))
    block.value = 0.5
    obj.active_shape_key_index = 1
    modifier = obj.modifiers.new("Cast", "CAST")
    modifier.factor = 0.3
    return obj


def snapshot(obj: bpy.types.Object) -> list:
    keys = obj.data.shape_keys
    return [
        points_of(obj).tolist(),
        [modifier.name for modifier in obj.modifiers],
        obj.active_shape_key_index,
        dict(obj.data.items()),
        None
        if keys is None
        else [
            (block.name, block.value, block.relative_key.name, held(block).tolist())
            for block in keys.key_blocks
        ],
    ]


def assert_rises(
    obj: bpy.types.Object, before: np.ndarray, cage: bpy.types.Object, tolerance: float = 4 * FLOAT32
) -> None:
    """From there it goes where an animated cage takes it, in each frame, in viewports and renders."""
    key(cage, {1: {"location": (0, 0, 0)}, 11: {"location": (0, 0, 2)}})
    for frame, height in ((11, 2.0), (1, 0.0), (6, 1.0)):
        bpy.context.scene.frame_set(frame)
        for shown in (evaluated_points(obj), render_points(obj)):
            assert np.abs(shown - before - height * UP).max() < tolerance, frame


@pytest.mark.parametrize("hidden", [False, True])
def test_what_the_lattice_moves_follows_in_the_same_frame_in_viewports_and_renders(hidden: bool):
    obj = lattice()
    mesh = follower(obj)
    before = evaluated_points(mesh)
    _, cage = bind(obj)
    obj.hide_viewport = obj.hide_render = hidden
    assert_rises(mesh, before, cage)


def test_an_animation_shows_each_frame_and_leaves_the_viewport_as_it_was():
    obj = lattice()
    mesh, scene = follower(obj), bpy.context.scene
    before = evaluated_points(mesh)
    _, cage = bind(obj)
    key(cage, {1: {"location": (0, 0, 0)}, 5: {"location": (0, 0, 2)}}, linear=True)
    scene.frame_set(2)
    scene.frame_start, scene.frame_end = 3, 5
    for height, seen in zip((1.0, 1.5, 2.0), render(animation=True), strict=True):
        assert np.abs(seen[mesh.name] - before - height * UP).max() < 4 * FLOAT32, height
    scene.frame_set(2)
    shown = evaluated_points(mesh)
    assert np.abs(shown - before - 0.5 * UP).max() < 4 * FLOAT32
    render(subframes=(0.0, 0.5))
    assert np.array_equal(evaluated_points(mesh), shown), "without a change of the frame"


def test_the_warp_is_that_of_the_cage_and_adds_to_keys_and_modifiers():
    """A rebind changes nothing."""
    obj = with_keys()
    rest = held(obj.data.shape_keys.key_blocks["Smile"]) * 0.5 + held(obj.data.shape_keys.reference_key) * 0.5
    obj.modifiers.clear()
    _, cage = bind(obj)
    expected = bend(cage)(rest)
    assert np.abs(expected - rest).max() > 0.05
    assert np.abs(evaluated_points(obj) - expected).max() < 4 * FLOAT32
    press(obj, "bind")
    assert np.abs(evaluated_points(obj) - expected).max() < 4 * FLOAT32
    obj.data.shape_keys.key_blocks["Smile"].value = 1.0
    more = 0.5 * (held(obj.data.shape_keys.key_blocks["Smile"]) - held(obj.data.shape_keys.reference_key))
    assert np.abs(evaluated_points(obj) - expected - more).max() < 4 * FLOAT32
    displacement = held(key_of(obj)) - held(obj.data.shape_keys.reference_key)
    moved = evaluated_points(obj)
    obj.modifiers.new("Cast", "CAST").factor = 0.3
    cast = evaluated_points(obj)
    plain = lattice()
    for point, place in zip(plain.data.points, moved):
        point.co_deform = place
    plain.data.update_tag()
    plain.modifiers.new("Cast", "CAST").factor = 0.3
    assert np.abs(evaluated_points(plain) - cast).max() < 4 * FLOAT32, "modifiers come after"
    assert np.abs(displacement).max() > 0.05


@pytest.mark.parametrize("make", [lattice, with_keys])
def test_without_its_deformers_a_lattice_is_what_it_was(make):
    obj = make()
    before, shown = snapshot(obj), evaluated_points(obj)
    _, cage = bind(obj)
    _, other = bind(obj)
    bend(cage)
    other.location.x = 0.4
    bpy.context.scene.frame_set(3)
    assert np.abs(evaluated_points(obj) - shown).max() > 0.1
    press(obj, "deformer_remove")
    cage.location.z += 0.5
    assert np.abs(evaluated_points(obj) - shown).max() > 0.1
    press(obj, "deformer_remove")
    assert snapshot(obj) == before
    assert np.array_equal(evaluated_points(obj), shown)


@pytest.mark.parametrize("make", [lattice, with_keys])
def test_unbind_lets_the_resolution_change_and_bind_takes_it(make):
    obj = make()
    before = snapshot(obj)
    _, cage = bind(obj)
    cage.location.z = 1.0
    update()
    with pytest.raises(AttributeError):
        obj.data.points_u = 5
    press(obj, "unbind")
    update()
    assert snapshot(obj) == before
    cage.location.z = 0.0
    if make is with_keys:  # which keep Blender from it, too
        return
    obj.data.points_u = 5
    bpy.ops.sinew.bind()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert "30 points" in obj.sinew.active.status
    cage.location.z = 1.0
    assert moved_up(obj)


@pytest.mark.parametrize("automatic", [False, True])
def test_other_points_ask_for_a_rebind(automatic: bool):
    obj, cage = bind(lattice())
    obj.sinew.active.auto_rebind = automatic
    other = bpy.data.lattices.new("Other")
    other.points_u = 7
    obj.data = other
    settle()
    if not automatic:
        assert obj.sinew.active.status == "The shape key was deleted - Rebind"
        assert np.array_equal(evaluated_points(obj), points_of(obj))
        press(obj, "bind")
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    cage.location.z = 1.0
    assert moved_up(obj)


@pytest.mark.parametrize(("own", "pushed"), [(False, True), (True, False), (True, True)])
def test_edits_move_the_basis_and_go_on_from_there(own: bool, pushed: bool):
    """Those of the basis, and those of our own key, also while its cage goes on."""
    obj = lattice()
    mesh = follower(obj)
    _, cage = bind(obj)
    cage.location.z = 1.0
    update()
    rest, height = points_of(obj), 2.0 if pushed else 1.0
    make_active(obj)
    if own:
        obj.active_shape_key_index = 1
        if hasattr(key_of(obj), "lock_shape"):  # Blender 4.2 and later: else nobody can edit it
            assert key_of(obj).lock_shape
            key_of(obj).lock_shape = False
    with in_mode(obj):
        update()
        bpy.ops.lattice.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(0.5, 0.0, 0.0))
        cage.location.z = height
        update()
    update()
    assert np.abs(held(obj.data.shape_keys.reference_key) - rest - (0.5, 0.0, 0.0)).max() < 2 * FLOAT32
    assert np.abs(evaluated_points(obj) - rest - (0.5, 0.0, height)).max() < 2 * FLOAT32
    shown = evaluated_points(mesh)
    cage.location.z = 0.0
    assert np.abs(evaluated_points(obj) - rest - (0.5, 0.0, 0.0)).max() < 2 * FLOAT32
    press(obj, "deformer_remove")
    assert np.abs(evaluated_points(obj) - rest - (0.5, 0.0, 0.0)).max() < 2 * FLOAT32
    assert np.abs(evaluated_points(mesh) - shown + height * UP).max() < 4 * FLOAT32


def test_edits_of_other_keys_and_by_scripts_count_as_blender_counts_them():
    obj = with_keys()
    obj.modifiers.clear()
    _, cage = bind(obj)
    cage.location.z = 1.0
    shown = evaluated_points(obj)
    make_active(obj)
    assert obj.active_shape_key.name == "Smile"
    on_all(obj, bpy.ops.transform.translate, value=(0.5, 0.0, 0.0))
    assert np.abs(evaluated_points(obj) - shown - (0.25, 0.0, 0.0)).max() < 2 * FLOAT32
    obj.data.shape_keys.reference_key.data[0].co.x += 0.1  # half of which Smile takes back
    obj.data.update_tag()
    expected = np.tile((0.25, 0.0, 0.0), (len(shown), 1))
    expected[0, 0] += 0.05
    assert np.abs(evaluated_points(obj) - shown - expected).max() < 2 * FLOAT32


def test_factor_mask_and_the_eye():
    obj = lattice()
    group = obj.vertex_groups.new(name="Part")
    group.add([0, 1, 2], 0.25, "REPLACE")
    _, cage = bind(obj)
    cage.location.z = 1.0
    rest, deformer = points_of(obj), obj.sinew.active
    deformer.factor = 0.5
    assert np.abs(evaluated_points(obj) - rest - 0.5 * UP).max() < FLOAT32
    deformer.mask_group = "Part"
    update()
    expected = np.zeros((len(rest), 3))
    expected[:3, 2] = 0.125
    assert np.abs(evaluated_points(obj) - rest - expected).max() < FLOAT32
    group.name = "Renamed"
    assert np.abs(evaluated_points(obj) - rest - expected).max() < FLOAT32
    deformer.mask_group, deformer.factor = "", 1.0
    assert moved_up(obj)
    key_of(obj).mute = True
    assert np.array_equal(evaluated_points(obj), rest)
    cage.location.z = 0.0
    update()
    cage.location.z = 1.0
    key_of(obj).mute = False
    assert moved_up(obj)
    deformer.live = False
    update()
    cage.location.z = 3.0
    assert moved_up(obj)


def test_a_renamed_key_is_found_and_a_deleted_one_is_made_again():
    obj, cage = bind(lattice())
    cage.location.z = 1.0
    assert moved_up(obj)
    key_of(obj).name = "Mine"
    obj.update_tag()
    update()
    assert obj.sinew.active.shape_key == "Mine"
    cage.location.z = 0.0
    update()
    cage.location.z = 1.0
    assert moved_up(obj)
    obj.shape_key_remove(key_of(obj))
    update()
    obj.update_tag()
    update()
    assert obj.sinew.active.status == "The shape key was deleted - Rebind"
    cage.location.z = 0.0
    press(obj, "bind")
    cage.location.z = 1.0
    assert moved_up(obj)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_lattice_follows_neither_itself_nor_what_follows_it():
    inner, outer = lattice(), lattice()
    inner.name, outer.name = "Inner", "Outer"
    refused("Inner cannot be its own lattice", "lattice_add", inner, source="OBJECT", lattice="Inner")
    assert bpy.ops.sinew.lattice_add(source="OBJECT", lattice="Outer") == {"FINISHED"}
    make_active(outer)
    if outer.sinew.deformers:
        pytest.fail("the outer lattice is the control")
    cage = ball("Cage", 2)
    cage.scale = 3.0, 3.0, 3.0
    cage.modifiers.new("Lattice", "LATTICE").object = inner
    press(inner, "cage_add", source="OBJECT", cage="Cage", method="mean_value")
    assert "follows its own shape" in " ".join(draw_panel().texts().split())


def test_an_outer_lattice_moves_inner_ones_and_other_objects_in_one_go():
    inner, mesh = lattice(), ball("Mesh", 2)
    inner.name = "Inner"
    inside = follower(inner)
    before = [evaluated_points(obj) for obj in (inner, mesh, inside)]
    make_active(inner, mesh)
    assert bpy.ops.sinew.lattice_add() == {"FINISHED"}
    outer = inner.sinew.active.controls[0].object
    assert mesh.sinew.active.controls[0].object == outer
    assert np.abs(evaluated_points(inner) - before[0]).max() < FLOAT32
    outer.location.z += 1.0
    for obj, rest in zip((inner, mesh, inside), before, strict=True):
        assert np.abs(evaluated_points(obj) - rest - UP).max() < 4 * FLOAT32, obj.name


def test_a_rig_that_follows_the_lattice_is_solved_after_it():
    """The empties of the rig are parented to a mesh that the lattice moves."""
    obj = lattice()
    carrier = follower(obj, "Carrier")
    plate = ball("Plate", 2)
    empty = new_empty("Point")
    empty.parent, empty.parent_type, empty.parent_vertices = carrier, "VERTEX", (0, 0, 0)
    make_active(plate, empty)
    assert bpy.ops.sinew.point_add(source="SELECTED", method="mls") == {"FINISHED"}
    _, cage = bind(obj)
    assert_rises(plate, evaluated_points(plate), cage, 1e-5)


def test_apply_moves_the_points_or_makes_a_key():
    obj = lattice()
    group = obj.vertex_groups.new(name="Part")
    group.add([0, 1, 2], 0.5, "REPLACE")
    _, cage = bind(obj)
    obj.sinew.active.mask_group = "Part"
    bend(cage)
    shown = evaluated_points(obj)
    press(obj, "apply", as_shape_key=True, keep_deformer=True)
    made = obj.data.shape_keys.key_blocks[-1]
    assert (made.name, made.value) == (obj.sinew.active.name, 0.0)
    assert np.abs(held(made) - shown).max() < FLOAT32
    assert np.abs(evaluated_points(obj) - shown).max() < FLOAT32
    refused("The lattice has shape keys, which keep its shape", "apply")
    obj.shape_key_remove(made)
    assert bpy.ops.sinew.apply() == {"FINISHED"}
    assert obj.data.shape_keys is None
    assert not obj.sinew.deformers
    assert np.abs(points_of(obj) - shown).max() < FLOAT32
    assert np.abs(evaluated_points(obj) - shown).max() < FLOAT32


def test_the_panel_draws_a_lattice():
    obj = lattice()
    make_active(obj)
    assert "sinew.start_task" in draw_panel().operator_names()
    bind(obj)
    make_active(obj)
    assert "mask_group" in draw(bpy.types.SINEW_PT_order).properties()
    obj.show_only_shape_key = True
    obj.update_tag()
    update()
    assert "shows the active shape key alone" in " ".join(draw_panel().texts().split())
    obj.show_only_shape_key = False
    obj.update_tag()
    with in_mode(obj):
        update()
        assert "in Edit Mode without" in " ".join(draw_panel().texts().split())


# Copies, links, files


@pytest.mark.parametrize("with_data", [False, True])
def test_duplicates(with_data: bool):
    obj, cage = bind(lattice())
    cage.location.z = 1.0
    update()
    copy = duplicated(obj, linked=not with_data)
    settle()
    if not with_data:
        assert "shares its points with Lattice, which moves both" in copy.sinew.active.status
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
        assert moved_up(obj)
        bpy.ops.object.make_single_user(object=True, obdata=True)
        update()
    assert copy.sinew.active.status_level == "INFO", copy.sinew.active.status
    assert obj.sinew.active.proxy != copy.sinew.active.proxy
    assert moved_up(obj)
    assert moved_up(copy)
    copy.sinew.active.factor = 0.5
    assert np.abs(evaluated_points(copy) - points_of(copy) - 0.5 * UP).max() < FLOAT32
    assert moved_up(obj)
    press(copy, "deformer_remove")
    assert copy.data.shape_keys is None
    assert moved_up(obj)


def test_what_cannot_be_moved_says_why():
    obj = lattice()
    other = linked(bpy.data.objects.new("Other", obj.data))
    attach(obj, "mean_value")
    assert obj.sinew.active.status == (
        "Lattice shares its points with Other - make it single-user first (Object > Relations)"
    )
    assert obj.data.shape_keys is None
    bpy.data.objects.remove(other)
    press(obj, "bind")
    obj.data.shape_keys.use_relative = False
    obj.update_tag()
    update()
    assert (
        obj.sinew.active.status == "The shape keys of Lattice are absolute - switch on Relative beside them"
    )
    refused("are absolute", "bind")
    assert obj.data.shape_keys is None, "as it was"
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_apply_transform_takes_it_along():
    obj, cage = bind(lattice())
    cage.parent = None
    bend(cage)
    obj.rotation_euler.z, obj.scale = 0.6, (1.5, 1.5, 1.5)
    update()
    before = apply_matrix(obj.matrix_world, evaluated_points(obj))
    make_active(obj)
    bpy.ops.object.transform_apply()
    assert np.abs(evaluated_points(obj) - before).max() < 1e-5


def test_files_show_the_last_shape_without_sinew_and_go_on_with_it(tmp_path: Path):
    obj = lattice()
    mesh = follower(obj)
    _, cage = bind(obj)
    bend(cage)
    shown, followed = evaluated_points(obj), evaluated_points(mesh)
    reopen(tmp_path / "lattice.blend")
    for name, places in (("Lattice", shown), ("Follower", followed)):
        for found in look_elsewhere(str(tmp_path / "lattice.blend"), name, tmp_path):
            assert np.abs(found - places).max() < FLOAT32, name
    obj, cage = bpy.data.objects["Lattice"], bpy.data.objects["Cage"]
    assert np.abs(evaluated_points(obj) - shown).max() < FLOAT32
    cage.location.z += 1.0
    assert np.abs(evaluated_points(obj) - shown - UP).max() < 4 * FLOAT32


def test_what_sinew_writes_is_no_edit_of_the_artist():
    """Else each pose would be followed by a comparison of the rest shapes, and that by another."""
    obj, cage = bind(lattice())
    settle()
    cage.location.z = 1.0
    update()
    update()
    assert not inner.sessions.has_edited()
    bpy.context.scene.frame_set(3)
    assert not inner.sessions.has_edited()
    obj.data.shape_keys.reference_key.data[0].co.x += 0.1
    obj.data.update_tag()
    update()
    assert inner.sessions.has_edited()
    for _ in range(3):
        settle()
    assert not inner.sessions.has_edited()


def test_links_show_the_last_shape_and_overrides_are_posed(tmp_path: Path):
    obj = lattice()
    mesh = follower(obj)
    _, cage = bind(obj)
    cage.location.z = 1.0
    shown, followed = evaluated_points(obj), evaluated_points(mesh)
    path = put_into_a_library(tmp_path / "library.blend", obj, mesh, cage)
    add_collection(path, link=True)
    obj = next(obj for obj in bpy.data.objects if obj.type == "LATTICE")
    assert obj.sinew.active.status.startswith("Linked: shows the last solution")
    assert np.abs(evaluated_points(obj) - shown).max() < FLOAT32
    new_file()
    obj = override(path)
    cage, mesh = (
        obj.sinew.active.cage,
        next(o for o in bpy.data.objects if o.modifiers and o.override_library),
    )
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert np.abs(evaluated_points(obj) - shown).max() < FLOAT32
    cage.location.z = 2.0
    assert np.abs(evaluated_points(obj) - shown - UP).max() < 2 * FLOAT32
    assert np.abs(evaluated_points(mesh) - followed - UP).max() < 4 * FLOAT32
    name, follows = obj.name, mesh.name
    reopen(tmp_path / "override.blend")
    obj, mesh = (next(o for o in bpy.data.objects if o.name == n and not o.library) for n in (name, follows))
    assert np.abs(evaluated_points(obj) - shown - UP).max() < 2 * FLOAT32
    obj.sinew.active.cage.location.z = 0.0
    assert np.abs(evaluated_points(obj) - shown + UP).max() < 2 * FLOAT32
    assert np.abs(evaluated_points(mesh) - followed + UP).max() < 4 * FLOAT32
