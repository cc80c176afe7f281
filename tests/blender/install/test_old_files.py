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
from inside import inner
from libraries import add_collection, override
from rigs.rig import base_points, coordinates, evaluated_points, linked, members, press, reopen, update

FILE = Path(__file__).parent / "before_controls.blend"
FLOAT32 = 2e-6  # rounding at a size of 2
CAGES = {"Ball": ("Ball Cage", True), "Pear": ("Box", False)}  # and whether the deformer owns it


def expected(obj: bpy.types.Object) -> np.ndarray:
    return coordinates(obj.data.attributes["expected"].data, "vector")


@pytest.fixture
def old(tmp_path: Path) -> str:
    """A copy, so that nothing here can spoil the file."""
    return str(shutil.copy(FILE, tmp_path / "old.blend"))


@pytest.fixture
def opened(old: str) -> None:
    bpy.ops.wm.open_mainfile(filepath=old)
    update()


@pytest.mark.parametrize("saved_again", [False, True])
def test_it_shows_what_it_showed_with_its_cages_and_goes_on(opened, tmp_path: Path, saved_again: bool):
    if saved_again:
        reopen(tmp_path / "new.blend")
        update()
    for name in (*CAGES, "Plate"):
        obj = bpy.data.objects[name]
        assert np.abs(evaluated_points(obj) - expected(obj)).max() < FLOAT32
        assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
        assert obj.sinew.active.sizes == "BOX", "shares of a size mean what they meant"
    for name, (cage, owned) in CAGES.items():
        obj = bpy.data.objects[name]
        deformer = obj.sinew.active
        (control,) = deformer.all_controls
        assert control.object == deformer.cage == bpy.data.objects[cage]
        assert control.rest == deformer.cage_rest
        assert len(control.rest.vertices) == len(deformer.cage.data.vertices)
        assert inner.ids.Keys.REST_TOKEN in control.rest
        assert control.owned == deformer.owns_cage == owned
        deformer.cage.location.z += 0.25
        assert np.abs(evaluated_points(obj) - expected(obj) - (0.0, 0.0, 0.25)).max() < FLOAT32


@pytest.mark.parametrize("name", CAGES)
def test_removing_the_deformer_removes_what_it_owns(opened, name: str) -> None:
    obj, (cage, owned) = bpy.data.objects[name], CAGES[name]
    rest = obj.sinew.active.cage_rest.name
    press(obj, "deformer_remove")
    assert (cage not in bpy.data.objects) == owned
    left = bpy.data.meshes.get(rest)
    # Blender 5 keeps a copy of the properties of older files under the add-on's name, and what it points to.
    assert left is None or ("sinew" in obj and left.users == 1)


def test_it_can_be_linked_and_overridden(scene, old: str) -> None:
    pear = add_collection(old, link=True).objects["Pear"]
    shown = evaluated_points(pear)
    assert np.abs(shown - expected(pear)).max() < FLOAT32
    obj = override(old)
    assert np.abs(evaluated_points(obj) - shown).max() < 1e-5
    cage = obj.sinew.active.cage
    assert cage.library is None
    cage.location.z += 0.25
    assert np.abs(evaluated_points(obj) - shown - (0.0, 0.0, 0.25)).max() < 1e-5


def test_controls_of_other_kinds_are_saved_with_their_rest(tmp_path: Path) -> None:
    target, control = (linked(bpy.data.objects.new(name, bpy.data.meshes.new(name))) for name in "TC")
    row = target.sinew.deformers.add().controls.add()
    row.kind, row.object, row.owned = "lattice", control, True
    row.rest = bpy.data.meshes.new("Rest")
    reopen(tmp_path / "controls.blend")
    (row,) = bpy.data.objects["T"].sinew.deformers[0].all_controls
    assert (row.kind, row.object.name, row.rest.name, row.owned) == ("lattice", "C", "Rest", True)
    row.object = None
    assert row.rest is None, "another object rests where it is when it is bound"


def test_a_handle_that_was_saved_posed_goes_on_from_there(opened) -> None:
    plate = bpy.data.objects["Plate"]
    (handle,) = (row for row in plate.sinew.active.handles if row.kind == "HANDLE")
    held = members(plate, handle.vertex_group)
    assert handle.stands_on == "WORLD"
    for height in (0.75, 0.0, 0.5):  # of the region; saved at 0.5
        handle.control.location.z = height
        moved = evaluated_points(plate) - base_points(plate)
        assert np.abs(moved[held] - (0.0, 0.0, height)).max() < FLOAT32
        assert np.abs(moved).max() < height + FLOAT32
    assert np.abs(evaluated_points(plate) - expected(plate)).max() < FLOAT32
