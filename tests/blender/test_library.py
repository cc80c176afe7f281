# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked and overridden rigs: Blender never writes linked meshes, so an override gets shapes of its own."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import catch_up
from mathutils import Matrix
from rig import Rig, evaluated_points, make_active, move_world, update


@pytest.fixture
def library(plate: Rig, tmp_path: Path) -> tuple[str, np.ndarray]:
    """A file with a posed plate in the collection ``Asset``; its path, and what it shows."""
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    plate.bind().lift(0.5)
    for obj in (plate.obj, plate.control):
        collection.objects.link(obj)
    shown = plate.points()
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return path, shown


def link(path: str, collection: bool) -> bpy.types.ID:
    with bpy.data.libraries.load(path, link=True) as (_there, here):
        if collection:
            here.collections = ["Asset"]
        else:
            here.objects = ["Plate"]
    return here.collections[0] if collection else here.objects[0]


def test_a_linked_rig_shows_the_last_solution(library: tuple[str, np.ndarray]):
    path, shown = library
    obj = link(path, collection=False)
    bpy.context.scene.collection.objects.link(obj)
    update()
    bpy.context.scene.frame_set(3)
    assert np.array_equal(evaluated_points(obj), shown)
    assert "library override" in obj.sinew.deformers[0].status


def test_an_override_can_be_posed(library: tuple[str, np.ndarray], tmp_path: Path):
    path, shown = library
    collection = link(path, collection=True)
    bpy.context.scene.collection.children.link(collection)
    update()
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    obj = next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
    catch_up()
    assert obj.sinew.deformers[0].proxy.library is None
    assert np.abs(evaluated_points(obj) - shown).max() < 1e-5
    control = obj.sinew.deformers[0].handles[0].control
    assert control.library is None
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    moved = evaluated_points(obj)
    assert moved[:, 2].max() == pytest.approx(0.75, abs=1e-5)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    obj = next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
    assert np.abs(evaluated_points(obj) - moved).max() < 1e-5


def caged_ball() -> tuple[bpy.types.Object, bpy.types.Object]:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
    target = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    cage = bpy.context.object
    target.name, cage.name = "Ball", "Cage"
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage="Cage", method="mean_value") == {"FINISHED"}
    return target, cage


def save_collection(objects: tuple[bpy.types.Object, ...], path: Path) -> str:
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        collection.objects.link(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return str(path)


def test_an_animated_cage_of_another_file_moves_a_mesh_of_this_one(scene, tmp_path: Path):
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    cage = bpy.context.object
    cage.name = "Plate"  # what ``link`` asks for
    for frame, height in ((1, 0.0), (11, 0.5)):
        cage.location.z = height
        cage.keyframe_insert("location", frame=frame)
    path = save_collection((cage,), tmp_path / "cage.blend")
    cage = link(path, collection=False)
    bpy.context.scene.collection.objects.link(cage)
    bpy.context.scene.frame_set(1)  # the cage still stands where its file left it
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
    target = bpy.context.object
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name) == {"FINISHED"}
    rest = evaluated_points(target)
    bpy.context.scene.frame_set(11)
    assert np.abs(evaluated_points(target) - rest - (0.0, 0.0, 0.5)).max() < 1e-5


def test_a_cage_and_its_mesh_can_be_linked_and_overridden(scene, tmp_path: Path):
    target, cage = caged_ball()
    cage.location.z = 0.5
    update()
    shown = evaluated_points(target)
    path = save_collection((target, cage), tmp_path / "asset.blend")
    collection = link(path, collection=True)
    bpy.context.scene.collection.children.link(collection)
    update()
    assert np.array_equal(evaluated_points(collection.objects["Ball"]), shown)
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    catch_up()
    target = next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
    assert np.abs(evaluated_points(target) - shown).max() < 1e-5
    cage = target.sinew.deformers[0].cage
    assert cage.library is None
    cage.location.z += 0.25
    update()
    assert np.abs(evaluated_points(target) - shown - (0.0, 0.0, 0.25)).max() < 1e-5
