# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies, links, files, undo and refusals of lattice objects that are moved."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import inner, settle
from libraries import add_collection, override, put_into_a_library
from rigs.lattice_objects import FLOAT32, UP, follower, moved_up, points_of
from rigs.point_objects import attach, bend, bind, lattice
from rigs.rig import (
    duplicated,
    evaluated_points,
    linked,
    make_active,
    new_file,
    press,
    refused,
    reopen,
    update,
)
from second_blender import look_elsewhere


@pytest.mark.parametrize("linked", [False, True])
def test_duplicates(linked: bool):
    obj = lattice()
    _, cage = bind(obj)
    cage.location.z = 1.0
    update()
    copy = duplicated(obj, linked=linked)
    settle()
    if linked:
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
    obj = lattice()
    _, cage = bind(obj)
    cage.parent = None
    bend(cage)
    obj.rotation_euler.z, obj.scale = 0.6, (1.5, 1.5, 1.5)
    update()
    world = np.array(obj.matrix_world)
    before = evaluated_points(obj) @ world[:3, :3].T + world[:3, 3]
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
    obj = lattice()
    _, cage = bind(obj)
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
