# SPDX-License-Identifier: GPL-3.0-or-later
"""A file saved by an earlier build opens with its cages, their rest and their ownership intact.

``files/before_controls.blend`` was saved in Blender 3.4.1 before controls were a list. A ball is in an
automatic cage that its deformer owns, a pear in a box that somebody made (both in the collection Asset), and
a plate has handles. All are posed; the attribute ``expected`` of each mesh has the points that were shown.
"""

import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
from rig import evaluated_points, make_active, update

FILE = Path(__file__).parent / "files" / "before_controls.blend"
FLOAT32 = 2e-6  # rounding at a size of 2


def expected(obj: bpy.types.Object) -> np.ndarray:
    attribute = obj.data.attributes["expected"].data
    points = np.empty((len(attribute), 3), dtype=np.float32)
    attribute.foreach_get("vector", points.ravel())
    return points


@pytest.fixture
def old(tmp_path: Path) -> str:
    """A copy, so that nothing here can spoil the file."""
    return str(shutil.copy(FILE, tmp_path / "old.blend"))


@pytest.fixture
def opened(old: str) -> bpy.types.Scene:
    bpy.ops.wm.open_mainfile(filepath=old)
    update()
    return bpy.context.scene


@pytest.mark.parametrize("name", ["Ball", "Pear", "Plate"])
def test_it_shows_what_it_showed(opened, name: str) -> None:
    obj = bpy.data.objects[name]
    assert np.abs(evaluated_points(obj) - expected(obj)).max() < FLOAT32
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


@pytest.mark.parametrize(("name", "cage", "owned"), [("Ball", "Ball Cage", True), ("Pear", "Box", False)])
def test_a_cage_its_rest_and_its_owner_are_kept(opened, room, name: str, cage: str, owned: bool) -> None:
    deformer = bpy.data.objects[name].sinew.active
    (control,) = deformer.all_controls
    assert control.object == deformer.cage == bpy.data.objects[cage]
    assert control.rest == deformer.cage_rest
    assert len(control.rest.vertices) == len(deformer.cage.data.vertices)
    assert room("ids").Keys.REST_TOKEN in control.rest
    assert control.owned == deformer.owns_cage == owned


@pytest.mark.parametrize("name", ["Ball", "Pear"])
def test_a_cage_goes_on_moving_its_mesh(opened, name: str) -> None:
    obj = bpy.data.objects[name]
    obj.sinew.active.cage.location.z += 0.25
    update()
    assert np.abs(evaluated_points(obj) - expected(obj) - (0.0, 0.0, 0.25)).max() < FLOAT32


@pytest.mark.parametrize(("name", "cage", "goes"), [("Ball", "Ball Cage", True), ("Pear", "Box", False)])
def test_removing_the_deformer_removes_what_it_owns(opened, name: str, cage: str, goes: bool) -> None:
    obj = bpy.data.objects[name]
    rest = obj.sinew.active.cage_rest.name
    make_active(obj)
    assert bpy.ops.sinew.deformer_remove() == {"FINISHED"}
    assert (cage not in bpy.data.objects) == goes
    left = bpy.data.meshes.get(rest)
    # Blender 5 keeps a copy of the properties of older files under the add-on's name, and what it points to.
    assert left is None or ("sinew" in obj and left.users == 1)


def test_it_is_saved_and_opened_again(opened, tmp_path: Path) -> None:
    path = str(tmp_path / "new.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    update()
    for name in ("Ball", "Pear", "Plate"):
        obj = bpy.data.objects[name]
        assert np.abs(evaluated_points(obj) - expected(obj)).max() < FLOAT32


def test_it_can_be_linked_and_overridden(scene, room, old: str) -> None:
    with bpy.data.libraries.load(old, link=True) as (_there, here):
        here.collections = ["Asset"]
    scene.collection.children.link(here.collections[0])
    update()
    linked = here.collections[0].objects["Pear"]
    shown = evaluated_points(linked)
    assert np.abs(shown - expected(linked)).max() < FLOAT32
    here.collections[0].override_hierarchy_create(scene, bpy.context.view_layer)
    update()
    room("handlers.deferred").catch_up()
    obj = next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
    assert np.abs(evaluated_points(obj) - shown).max() < 1e-5
    cage = obj.sinew.active.cage
    assert cage.library is None
    cage.location.z += 0.25
    update()
    assert np.abs(evaluated_points(obj) - shown - (0.0, 0.0, 0.25)).max() < 1e-5


def test_controls_of_other_kinds_are_saved_with_their_rest(scene, tmp_path: Path) -> None:
    mesh = bpy.data.meshes.new("Target")
    obj = bpy.data.objects.new("Target", mesh)
    scene.collection.objects.link(obj)
    control = bpy.data.objects.new("Control", bpy.data.meshes.new("Control"))
    scene.collection.objects.link(control)
    row = obj.sinew.deformers.add().controls.add()
    row.kind, row.object, row.owned = "lattice", control, True
    row.rest = bpy.data.meshes.new("Rest")
    path = str(tmp_path / "controls.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    (row,) = bpy.data.objects["Target"].sinew.deformers[0].all_controls
    assert (row.kind, row.object.name, row.rest.name, row.owned) == ("lattice", "Control", "Rest", True)
    row.object = None
    assert row.rest is None, "another object rests where it is when it is bound"
