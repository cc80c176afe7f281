# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked and overridden text, and a linked cage. Rigs of other kinds: ``test_event_files``."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from inside import settle
from libraries import add_collection, overridden, override, put_into_a_library, read
from rigs.point_objects import TESSELLATED, bind, outline, shown
from rigs.rig import FLOAT32, MATRIX, close, make_active, reopen


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


# --- hidden shapes stay hidden


def hidden_ones() -> list[str]:
    """Our hidden objects that show as rows in the outliner."""
    return [obj.name for scene in bpy.data.scenes for obj in scene.objects if obj.name.startswith(".Sinew")]


@pytest.mark.parametrize("root", ["object", "collection"])
def test_make_library_override_puts_no_hidden_shape_into_the_scene(rig, root: str, tmp_path: Path):
    rig.start()
    rig.lift(0.5)
    name = rig.name
    path = put_into_a_library(tmp_path / "library.blend", rig.obj, rig.control)
    if root == "object":
        for wanted in (name, rig.control_of(read(path, True, "objects", name)).name):
            obj = read(path, True, "objects", wanted)
            if obj.name not in bpy.context.scene.objects:
                bpy.context.scene.collection.objects.link(obj)
        make_active(bpy.data.objects[name])
        assert bpy.ops.object.make_override_library() == {"FINISHED"}
    else:
        add_collection(path, link=True).override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    for _ in range(2):
        settle()
        assert hidden_ones() == []
        reopen(tmp_path / "shot.blend")
    assert hidden_ones() == []
    obj = overridden()
    assert rig.shows(rig.at(0.5), obj, MATRIX)


def test_an_override_made_by_a_script_can_be_posed_at_once(rig, tmp_path: Path):
    """Without a pause, and without a call of ours."""
    rig.start()
    rig.lift(0.5)
    name = rig.name
    path = put_into_a_library(tmp_path / "library.blend", rig.obj, rig.control)
    collection = add_collection(path, link=True)
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    obj = overridden()
    assert obj.name == name
    rig.control_of(obj).location.z += 0.25
    assert rig.shows(rig.now(obj), obj, MATRIX)
    assert not rig.shows(rig.at(0.5), obj, 0.1)
    rig.lift_of(obj, 0.25)
    assert rig.shows(rig.now(obj), obj, MATRIX)
    assert obj.sinew.deformers[0].status_level == "INFO"
    assert hidden_ones() == []
