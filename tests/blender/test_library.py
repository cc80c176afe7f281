# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked and overridden rigs: Blender never writes linked meshes, so an override gets shapes of its own."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cages import ball, surround
from inside import catch_up
from point_objects import bind, outline, shown
from rig import FLOAT32, Rig, evaluated_points, reopen, update


def plate_and_control() -> tuple[bpy.types.Object, bpy.types.Object]:
    plate = Rig.plate().bind()
    return plate.obj, plate.control


MAKERS = {
    "plate": plate_and_control,
    "ball in a cage": lambda: bind(ball()),
    "text in a cage": lambda: bind(outline()),
}


def save_asset(objects: Iterable[bpy.types.Object], path: Path) -> None:
    """A file with these in the collection ``Asset``; then an empty scene."""
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        for other in obj.users_collection:
            other.objects.unlink(obj)
        collection.objects.link(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def link_asset(path: Path) -> bpy.types.Collection:
    with bpy.data.libraries.load(str(path), link=True) as (_there, here):
        here.collections = ["Asset"]
    bpy.context.scene.collection.children.link(here.collections[0])
    update()
    return here.collections[0]


def control_of(obj: bpy.types.Object) -> bpy.types.Object:
    deformer = obj.sinew.deformers[0]
    return deformer.cage or deformer.handles[0].control


def overridden() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)


@pytest.mark.parametrize("maker", MAKERS.values(), ids=MAKERS)
def test_a_linked_rig_shows_the_last_solution_and_an_override_can_be_posed(maker, tmp_path: Path):
    obj, control = maker()
    control.location.z += 0.5
    posed, name = shown(obj), obj.name
    save_asset((obj, control), tmp_path / "library.blend")
    collection = link_asset(tmp_path / "library.blend")
    bpy.context.scene.frame_set(3)
    obj = collection.objects[name]
    assert np.abs(shown(obj) - posed).max() <= (0.0 if obj.type == "MESH" else FLOAT32)
    assert "library override" in obj.sinew.deformers[0].status

    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    catch_up()
    obj = overridden()
    assert obj.sinew.deformers[0].proxy.library is None
    assert np.abs(shown(obj) - posed).max() < (1e-5 if obj.type == "MESH" else FLOAT32)
    control = control_of(obj)
    assert control.library is None
    control.location.z += 0.25
    moved = shown(obj)
    assert moved[:, 2].max() == pytest.approx(posed[:, 2].max() + 0.25, abs=1e-5)
    if not control.name.startswith("Plate"):
        assert np.abs(moved - posed - (0.0, 0.0, 0.25)).max() < 1e-5
    reopen(tmp_path / "shot.blend")
    assert np.abs(shown(overridden()) - moved).max() < 1e-5


def test_an_animated_cage_of_another_file_moves_a_mesh_of_this_one(tmp_path: Path):
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    cage = bpy.context.object
    for frame, height in ((1, 0.0), (11, 0.5)):
        cage.location.z = height
        cage.keyframe_insert("location", frame=frame)
    save_asset((cage,), tmp_path / "cage.blend")
    (cage,) = link_asset(tmp_path / "cage.blend").objects
    bpy.context.scene.frame_set(1)  # the cage still stands where its file left it
    target = ball()
    surround(target, cage)
    rest = evaluated_points(target)
    bpy.context.scene.frame_set(11)
    assert np.abs(evaluated_points(target) - rest - (0.0, 0.0, 0.5)).max() < 1e-5
