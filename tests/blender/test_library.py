# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked and overridden text, and a linked cage. Rigs of other kinds: ``test_event_files``."""

from __future__ import annotations

from pathlib import Path

import bpy
from cages import ball, surround
from libraries import add_collection, overridden, override, put_into_a_library, read
from point_objects import TESSELLATED, bind, outline, shown
from rig import FLOAT32, MATRIX, close, evaluated_points, key_heights, reopen


def test_a_linked_text_shows_the_last_solution_and_an_override_can_be_posed(tmp_path: Path):
    obj, cage = bind(outline())
    cage.location.z += 0.5
    posed, name = shown(obj), obj.name
    path = put_into_a_library(tmp_path / "library.blend", obj, cage)
    obj = add_collection(path, link=True).objects[name]
    bpy.context.scene.frame_set(3)
    assert close(shown(obj), posed)
    assert "library override" in obj.sinew.deformers[0].status
    obj = override(path)
    deformer = obj.sinew.deformers[0]
    assert deformer.proxy.library is None
    assert deformer.cage.library is None
    assert close(shown(obj), posed, FLOAT32)
    deformer.cage.location.z += 0.25
    moved = shown(obj)
    assert close(moved, posed + (0.0, 0.0, 0.25), TESSELLATED)
    reopen(tmp_path / "shot.blend")
    assert close(shown(overridden()), moved, TESSELLATED)


def test_an_animated_cage_of_another_file_moves_a_mesh_of_this_one(tmp_path: Path):
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    key_heights(bpy.context.object, {1: 0.0, 11: 0.5})
    path = put_into_a_library(tmp_path / "cage.blend", bpy.context.object)
    cage = read(path, True, "objects", "Cube")
    bpy.context.scene.collection.objects.link(cage)
    bpy.context.scene.frame_set(1)  # the cage still stands where its file left it
    target = ball()
    surround(target, cage)
    rest = evaluated_points(target)
    bpy.context.scene.frame_set(11)
    assert close(evaluated_points(target), rest + (0.0, 0.0, 0.5), MATRIX)
