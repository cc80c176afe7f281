# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattice objects as targets, as far as they differ from curves: shape keys show what moves them.

What holds for them as for curves is tested in ``test_cage_kinds`` and ``test_moves_anything``.
"""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import inner, settle
from libraries import add_collection, override, put_into_a_library
from mathutils import Vector
from probe import render, render_points
from rigs import rig as scenes
from rigs.cages import ball, box, surround
from rigs.lattice_objects import FLOAT32, UP, follower, held, key_of, moved_up, points_of
from rigs.point_objects import attach, bend, bind, lattice
from rigs.sheet import draw, draw_panel
from second_blender import look_elsewhere

Caged = tuple[bpy.types.Object, bpy.types.Object, bpy.types.Object]
LOST = "The shape key was deleted - Rebind"


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
    keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else ()
    blocks = [(block.name, block.value, block.relative_key.name, held(block).tolist()) for block in keys]
    names = [modifier.name for modifier in obj.modifiers]
    return [points_of(obj).tolist(), names, obj.active_shape_key_index, dict(obj.data.items()), blocks]


def is_at(obj: bpy.types.Object, expected: np.ndarray) -> bool:
    return scenes.close(scenes.evaluated_points(obj), expected, 4 * FLOAT32)


def caged(rises: float = 1.0) -> Caged:
    """A lattice, the cage that lifts it, and a mesh that follows the lattice."""
    obj = lattice()
    mesh = follower(obj)
    _, cage = bind(obj)
    cage.location.z = rises
    scenes.update()
    return obj, cage, mesh


def assert_rises(
    obj: bpy.types.Object, before: np.ndarray, cage: bpy.types.Object, tolerance: float = 4 * FLOAT32
) -> None:
    """From there it goes where an animated cage takes it, in each frame, in viewports and renders."""
    scenes.key(cage, {1: {"location": (0, 0, 0)}, 11: {"location": (0, 0, 2)}}, linear=True)
    for frame, height in ((11, 2.0), (1, 0.0), (6, 1.0)):
        bpy.context.scene.frame_set(frame)
        for shown in (scenes.evaluated_points(obj), render_points(obj)):
            assert scenes.close(shown, before + height * UP, tolerance), frame


@pytest.mark.parametrize("hidden", [False, True])
def test_what_the_lattice_moves_follows_in_each_frame_in_viewports_and_renders(hidden: bool):
    """An animation leaves the viewport as it was."""
    obj, cage, mesh = caged(0.0)
    before, scene = scenes.evaluated_points(mesh), bpy.context.scene
    obj.hide_viewport = obj.hide_render = hidden
    assert_rises(mesh, before, cage)
    obj.hide_render = False  # else Blender evaluates the cage for the viewport alone
    scene.frame_start, scene.frame_end = 7, 9
    for height, seen in zip((1.2, 1.4, 1.6), render(animation=True), strict=True):
        assert scenes.close(seen[mesh.name], before + height * UP, 4 * FLOAT32), height
    scene.frame_set(2)
    shown = scenes.evaluated_points(mesh)
    assert scenes.close(shown, before + 0.2 * UP, 4 * FLOAT32)
    render(subframes=(0.0, 0.5))
    assert np.array_equal(scenes.evaluated_points(mesh), shown), "without a change of the frame"


def test_the_warp_is_that_of_the_cage_and_adds_to_keys_and_modifiers():
    """A rebind changes nothing."""
    obj = with_keys()
    keys = obj.data.shape_keys
    smile, basis = keys.key_blocks["Smile"], held(keys.reference_key)
    rest = 0.5 * (held(smile) + basis)
    obj.modifiers.clear()
    _, cage = bind(obj)
    expected = bend(cage)(rest)
    assert np.abs(expected - rest).max() > 0.05
    assert is_at(obj, expected)
    scenes.press(obj, "bind")
    assert is_at(obj, expected)
    smile.value = 1.0
    assert is_at(obj, expected + 0.5 * (held(smile) - basis))
    plain = lattice()
    plain.data.points.foreach_set("co_deform", scenes.evaluated_points(obj).ravel())
    for each in (obj, plain):
        each.modifiers.new("Cast", "CAST").factor = 0.3
        each.data.update_tag()
    assert is_at(obj, scenes.evaluated_points(plain)), "modifiers come after"


@pytest.mark.parametrize("make", [lattice, with_keys])
def test_without_its_deformers_a_lattice_is_what_it_was(make):
    obj = make()
    before, shown = snapshot(obj), scenes.evaluated_points(obj)
    _, cage = bind(obj)
    _, other = bind(obj)
    bend(cage)
    other.location.x = 0.4
    bpy.context.scene.frame_set(3)
    assert np.abs(scenes.evaluated_points(obj) - shown).max() > 0.1
    scenes.press(obj, "deformer_remove")
    cage.location.z += 0.5
    assert np.abs(scenes.evaluated_points(obj) - shown).max() > 0.1
    scenes.press(obj, "deformer_remove")
    assert snapshot(obj) == before
    assert np.array_equal(scenes.evaluated_points(obj), shown)


@pytest.mark.parametrize("make", [lattice, with_keys])
def test_unbind_lets_the_resolution_change_and_bind_takes_it(make):
    """Unless keys of the artist keep Blender from it, too."""
    obj = make()
    before = snapshot(obj)
    _, cage = bind(obj)
    cage.location.z = 1.0
    scenes.update()
    with pytest.raises(AttributeError):
        obj.data.points_u = 5
    scenes.press(obj, "unbind")
    scenes.update()
    assert snapshot(obj) == before
    if make is lattice:
        cage.location.z = 0.0
        obj.data.points_u = 5
        bpy.ops.sinew.bind()
        assert "30 points" in obj.sinew.active.status
        cage.location.z = 1.0
        assert moved_up(obj)


@pytest.mark.parametrize("automatic", [False, True])
def test_other_points_ask_for_a_rebind(automatic: bool):
    obj, cage, _mesh = caged(0.0)
    obj.sinew.active.auto_rebind = automatic
    obj.data = bpy.data.lattices.new("Other")
    obj.data.points_u = 7
    settle()
    if not automatic:
        assert obj.sinew.active.status == LOST
        assert np.array_equal(scenes.evaluated_points(obj), points_of(obj))
        scenes.press(obj, "bind")
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    cage.location.z = 1.0
    assert moved_up(obj)


@pytest.mark.parametrize(("own", "pushed"), [(False, True), (True, False), (True, True)])
def test_edits_move_the_basis_and_go_on_from_there(own: bool, pushed: bool):
    """Those of the basis, and those of our own key, also while its cage goes on."""
    obj, cage, mesh = caged()
    edited, height = points_of(obj) + (0.5, 0.0, 0.0), 2.0 if pushed else 1.0
    scenes.make_active(obj)
    if own:
        obj.active_shape_key_index = 1
        if hasattr(key_of(obj), "lock_shape"):  # Blender 4.2 and later: else nobody can edit it
            assert key_of(obj).lock_shape
            key_of(obj).lock_shape = False
    with scenes.in_mode(obj):
        scenes.update()
        bpy.ops.lattice.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(0.5, 0.0, 0.0))
        cage.location.z = height
        scenes.update()
    scenes.update()
    assert scenes.close(held(obj.data.shape_keys.reference_key), edited, 2 * FLOAT32)
    assert scenes.close(scenes.evaluated_points(obj), edited + height * UP, 2 * FLOAT32)
    shown = scenes.evaluated_points(mesh)
    cage.location.z = 0.0
    assert scenes.close(scenes.evaluated_points(obj), edited, 2 * FLOAT32)
    scenes.press(obj, "deformer_remove")
    assert scenes.close(scenes.evaluated_points(obj), edited, 2 * FLOAT32)
    assert is_at(mesh, shown - height * UP)


def test_edits_of_other_keys_and_by_scripts_count_as_blender_counts_them():
    obj = with_keys()
    obj.modifiers.clear()
    _, cage = bind(obj)
    cage.location.z = 1.0
    expected = scenes.evaluated_points(obj) + (0.25, 0.0, 0.0)
    scenes.make_active(obj)
    assert obj.active_shape_key.name == "Smile"
    scenes.on_all(obj, bpy.ops.transform.translate, value=(0.5, 0.0, 0.0))
    assert scenes.close(scenes.evaluated_points(obj), expected, 2 * FLOAT32)
    obj.data.shape_keys.reference_key.data[0].co.x += 0.1  # half of which Smile takes back
    obj.data.update_tag()
    expected[0, 0] += 0.05
    assert scenes.close(scenes.evaluated_points(obj), expected, 2 * FLOAT32)


def test_factor_mask_and_the_eye():
    obj = lattice()
    group = obj.vertex_groups.new(name="Part")
    group.add([0, 1, 2], 0.25, "REPLACE")
    _, cage = bind(obj)
    cage.location.z = 1.0
    rest, deformer = points_of(obj), obj.sinew.active
    deformer.factor = 0.5
    assert scenes.close(scenes.evaluated_points(obj), rest + 0.5 * UP, FLOAT32)
    deformer.mask_group = "Part"
    masked = rest + np.outer(np.arange(len(rest)) < 3, 0.125 * UP)
    for name in ("Part", "Renamed"):
        group.name = name
        assert scenes.close(scenes.evaluated_points(obj), masked, FLOAT32)
    deformer.mask_group, deformer.factor = "", 1.0
    assert moved_up(obj)
    key_of(obj).mute = True
    assert np.array_equal(scenes.evaluated_points(obj), rest)
    rise_again(cage)
    key_of(obj).mute = False
    assert moved_up(obj)
    deformer.live = False
    scenes.update()
    cage.location.z = 3.0
    assert moved_up(obj)


def rise_again(cage: bpy.types.Object) -> None:
    cage.location.z = 0.0
    scenes.update()
    cage.location.z = 1.0


def test_a_renamed_key_is_found_and_a_deleted_one_is_made_again():
    obj, cage, _mesh = caged()
    key_of(obj).name = "Mine"
    obj.update_tag()
    scenes.update()
    assert obj.sinew.active.shape_key == "Mine"
    rise_again(cage)
    assert moved_up(obj)
    obj.shape_key_remove(key_of(obj))
    scenes.update()
    obj.update_tag()
    scenes.update()
    assert obj.sinew.active.status == LOST
    cage.location.z = 0.0
    scenes.press(obj, "bind")
    cage.location.z = 1.0
    assert moved_up(obj)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_lattice_follows_neither_itself_nor_what_follows_it():
    inner, outer = lattice(), lattice()
    inner.name, outer.name = "Inner", "Outer"
    scenes.refused("Inner cannot be its own lattice", "lattice_add", inner, source="OBJECT", lattice="Inner")
    scenes.press(inner, "lattice_add", source="OBJECT", lattice="Outer")
    assert not outer.sinew.deformers, "the outer lattice is the control"
    cage = box("Cage", 6.0)
    cage.modifiers.new("Lattice", "LATTICE").object = inner
    surround(inner, cage)
    scenes.make_active(inner)
    assert "follows its own shape" in panel()


def test_a_rig_that_follows_the_lattice_is_solved_after_it():
    """The empties of the rig are parented to a mesh that the lattice moves."""
    obj = lattice()
    carrier = follower(obj, "Carrier")
    plate = ball("Plate", 2)
    empty = scenes.new_empty("Point")
    empty.parent, empty.parent_type, empty.parent_vertices = carrier, "VERTEX", (0, 0, 0)
    scenes.make_active(plate, empty)
    assert bpy.ops.sinew.point_add(source="SELECTED", method="mls") == {"FINISHED"}
    _, cage = bind(obj)
    assert_rises(plate, scenes.evaluated_points(plate), cage, 1e-5)


def test_apply_moves_the_points_or_makes_a_key():
    obj = lattice()
    obj.vertex_groups.new(name="Part").add([0, 1, 2], 0.5, "REPLACE")
    _, cage = bind(obj)
    obj.sinew.active.mask_group = "Part"
    bend(cage)
    shown = scenes.evaluated_points(obj)
    scenes.press(obj, "apply", as_shape_key=True, keep_deformer=True)
    made = obj.data.shape_keys.key_blocks[-1]
    assert (made.name, made.value) == (obj.sinew.active.name, 0.0)
    scenes.refused("The lattice has shape keys, which keep its shape", "apply")
    for points in (held(made), scenes.evaluated_points(obj)):
        assert scenes.close(points, shown, FLOAT32)
    obj.shape_key_remove(made)
    assert bpy.ops.sinew.apply() == {"FINISHED"}
    assert obj.data.shape_keys is None
    assert not obj.sinew.deformers
    for points in (points_of(obj), scenes.evaluated_points(obj)):
        assert scenes.close(points, shown, FLOAT32)


def panel() -> str:
    return " ".join(draw_panel().texts().split())


def test_the_panel_draws_a_lattice():
    obj = lattice()
    assert "sinew.start_task" in draw_panel().operator_names()
    bind(obj)
    scenes.make_active(obj)
    assert "mask_group" in draw(bpy.types.SINEW_PT_order).properties()
    for alone, words in ((True, "shows the active shape key alone"), (False, "in Edit Mode without")):
        obj.show_only_shape_key = alone
        obj.update_tag()
        scenes.update()
        with nullcontext() if alone else scenes.in_mode(obj):
            scenes.update()
            assert words in panel()


# Copies, links, files


@pytest.mark.parametrize("with_data", [False, True])
def test_duplicates(with_data: bool):
    obj, _cage, _mesh = caged()
    copy = scenes.duplicated(obj, linked=not with_data)
    settle()
    if not with_data:
        assert "shares its points with Lattice, which moves both" in copy.sinew.active.status
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
        assert moved_up(obj)
        bpy.ops.object.make_single_user(object=True, obdata=True)
        scenes.update()
    assert copy.sinew.active.status_level == "INFO", copy.sinew.active.status
    assert obj.sinew.active.proxy != copy.sinew.active.proxy
    assert moved_up(obj)
    assert moved_up(copy)
    copy.sinew.active.factor = 0.5
    assert scenes.close(scenes.evaluated_points(copy), points_of(copy) + 0.5 * UP, FLOAT32)
    assert moved_up(obj)
    scenes.press(copy, "deformer_remove")
    assert copy.data.shape_keys is None
    assert moved_up(obj)


def test_what_cannot_be_moved_says_why():
    obj = lattice()
    deformers, other = obj.sinew.deformers, scenes.linked(bpy.data.objects.new("Other", obj.data))
    attach(obj, "mean_value")
    shared = "Lattice shares its points with Other - make it single-user first (Object > Relations)"
    assert (deformers[0].status, obj.data.shape_keys) == (shared, None)
    bpy.data.objects.remove(other)
    scenes.press(obj, "bind")
    obj.data.shape_keys.use_relative = False
    obj.update_tag()
    scenes.update()
    absolute = "The shape keys of Lattice are absolute - switch on Relative beside them"
    assert deformers[0].status == absolute
    scenes.refused("are absolute", "bind")
    assert obj.data.shape_keys is None, "as it was"
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert deformers[0].status_level == "INFO", deformers[0].status


def test_apply_transform_takes_it_along():
    obj, cage = bind(lattice())
    cage.parent = None
    bend(cage)
    obj.rotation_euler.z, obj.scale = 0.6, (1.5, 1.5, 1.5)
    scenes.update()
    before = scenes.apply_matrix(obj.matrix_world, scenes.evaluated_points(obj))
    scenes.make_active(obj)
    bpy.ops.object.transform_apply()
    assert scenes.close(scenes.evaluated_points(obj), before, 1e-5)


def test_files_show_the_last_shape_without_sinew_and_go_on_with_it(tmp_path: Path):
    obj, cage, mesh = caged()
    bend(cage)
    names, path = (obj.name, mesh.name), tmp_path / "lattice.blend"
    shown = [scenes.evaluated_points(each) for each in (obj, mesh)]
    scenes.reopen(path)
    for name, places in zip(names, shown, strict=True):
        for found in look_elsewhere(str(path), name, tmp_path):
            assert scenes.close(found, places, FLOAT32), name
    obj, cage = bpy.data.objects["Lattice"], bpy.data.objects["Cage"]
    assert scenes.close(scenes.evaluated_points(obj), shown[0], FLOAT32)
    cage.location.z += 1.0
    assert is_at(obj, shown[0] + UP)


def test_what_sinew_writes_is_no_edit_of_the_artist():
    """Else each pose would be followed by a comparison of the rest shapes, and that by another."""
    obj, cage, _mesh = caged(0.0)
    settle()
    cage.location.z = 1.0
    scenes.update()
    scenes.update()
    bpy.context.scene.frame_set(3)
    assert not inner.sessions.has_edited()
    obj.data.shape_keys.reference_key.data[0].co.x += 0.1
    obj.data.update_tag()
    scenes.update()
    assert inner.sessions.has_edited()
    settle()
    assert not inner.sessions.has_edited()


def test_links_show_the_last_shape_and_overrides_are_posed(tmp_path: Path):
    obj, cage, mesh = caged()
    shown, followed = scenes.evaluated_points(obj), scenes.evaluated_points(mesh)
    path = put_into_a_library(tmp_path / "library.blend", obj, mesh, cage)
    add_collection(path, link=True)
    obj = next(obj for obj in bpy.data.objects if obj.type == "LATTICE")
    assert obj.sinew.active.status.startswith("Linked: shows the last solution")
    assert scenes.close(scenes.evaluated_points(obj), shown, FLOAT32)
    scenes.new_file()
    obj = override(path)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert scenes.close(scenes.evaluated_points(obj), shown, FLOAT32)
    names = obj.name, next(o.name for o in bpy.data.objects if o.modifiers and o.override_library)
    obj.sinew.active.cage.location.z = 2.0
    for height in (1.0, -1.0):
        obj, mesh = (next(o for o in bpy.data.objects if o.name == n and not o.library) for n in names)
        obj.sinew.active.cage.location.z = 1.0 + height
        assert is_at(obj, shown + height * UP)
        assert is_at(mesh, followed + height * UP)
        scenes.reopen(tmp_path / "override.blend")
