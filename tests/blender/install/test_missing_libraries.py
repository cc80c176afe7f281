# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls and cages whose library is missing, and controls of a wrong type.

What they move stays where it was, the status says why, and the other rigs live.
"""

import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import settle
from libraries import put_into_a_library, read
from probe import render_points
from rigs import rig as scenes
from rigs.cages import assert_rests, ball, box, surround
from rigs.kinds import CageRig, HandleRig

LATE = 11  # the frame at which the controls are lifted by a half


def handles(folder: Path, kind: str = "empty") -> bpy.types.Object:
    """A plate that an animated object, or a bone, of a library moves."""
    bone = ""
    if kind == "bone":
        control, bone = scenes.new_armature(arm=((0.0, 0.9, 0.0), (0.0, 0.9, 0.5))), "arm"
        mover = control.pose.bones["arm"]
        scenes.key(
            mover, {1: {"location": (0, 0, 0)}, LATE: {"location": (0, 0.5, 0)}}
        )  # the bone points along z
    else:
        control = (
            scenes.new_empty("Control", (0.0, 0.9, 0.0))
            if kind == "empty"
            else scenes.grid_object("Control", 1)
        )
        scenes.key_heights(control, {1: 0.2, LATE: 0.7})
    name = control.name
    path = put_into_a_library(folder / "control.blend", control)
    scenes.linked(read(path, True, "objects", name))
    bpy.context.scene.frame_set(1)
    plate = scenes.Rig.plate()
    plate.bind(control_object=name, **({"bone": bone} if bone else {}))
    return plate.obj


def cage(folder: Path) -> bpy.types.Object:
    """A ball in an animated cage of a library."""
    scenes.key_heights(box(), {1: 0.0, LATE: 0.5})
    path = put_into_a_library(folder / "control.blend", bpy.data.objects["Cage"])
    return in_cage(scenes.linked(read(path, True, "objects", "Cage")))


def cage_mesh(folder: Path) -> bpy.types.Object:
    """The cage is of this file, its mesh is of a library."""
    path = put_into_a_library(folder / "control.blend", box())
    around = scenes.linked(bpy.data.objects.new("Cage", read(path, True, "meshes", "Cage")))
    scenes.key_heights(around, {1: 0.0, LATE: 0.5})
    return in_cage(around)


def in_cage(around: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.frame_set(1)
    target = ball()
    surround(target, around)
    return target


RIGS = {
    "empty": handles,
    "mesh object": lambda folder: handles(folder, "mesh"),
    "bone": lambda folder: handles(folder, "bone"),
    "cage": cage,
    "mesh of a cage": cage_mesh,
}


@pytest.fixture(params=RIGS)
def lost(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[str, np.ndarray]:
    """A target and what it showed before its library went away; beside it is a rig that lacks nothing."""
    target = RIGS[request.param](tmp_path)
    other = HandleRig.new("Other").start()
    other.lift(0.5)
    bpy.context.scene.frame_set(LATE)
    name, shown = target.name, scenes.evaluated_points(target)
    assert np.abs(shown - [vertex.co for vertex in target.data.vertices]).max() > 0.4
    if target.sinew.active.handles:
        target.sinew.active.handles[0].weight = 0.9  # the shape alone does not tell the pose
        shown = scenes.evaluated_points(target)
    scenes.save(tmp_path / "shot.blend")
    shutil.move(tmp_path / "control.blend", tmp_path / "away.blend")
    scenes.load(tmp_path / "shot.blend")
    return name, shown


def assert_stays(name: str, shown: np.ndarray) -> bpy.types.Object:
    """In viewport and renders, at every frame, and the status names the library and what to do."""
    obj = bpy.data.objects[name]
    for frame in (LATE, 1, 5):
        bpy.context.scene.frame_set(frame)
        assert scenes.close(scenes.evaluated_points(obj), shown, scenes.MATRIX)
        assert obj.sinew.active.status_level == "WARNING"
        assert "control.blend" in obj.sinew.active.status
        assert "put the file there" in obj.sinew.active.status
    assert scenes.close(render_points(obj), shown, scenes.MATRIX)
    return obj


def assert_others_live() -> None:
    other = HandleRig.called("Other")
    before = scenes.evaluated_points(other.obj)
    other.lift(0.25)
    moved = scenes.evaluated_points(other.obj) - before
    assert np.abs(moved[:, 2].max() - 0.25) < scenes.MATRIX
    assert other.deformer.status_level == "INFO"


def test_it_stays_where_it_was_and_the_others_live(lost, tmp_path: Path):
    assert_stays(*lost)
    assert_others_live()
    scenes.save(tmp_path / "again.blend")
    scenes.load(tmp_path / "again.blend")
    assert_stays(*lost)
    assert_others_live()


def test_every_button_reports(lost):
    """And none throws; afterwards the shape is as it was, or at rest."""
    name, shown = lost
    obj = bpy.data.objects[name]
    rest = np.array([vertex.co for vertex in obj.data.vertices])
    for operator in (
        bpy.ops.sinew.bind,
        bpy.ops.sinew.cage_set_rest,
        bpy.ops.sinew.cage_flip,
        bpy.ops.sinew.unbind,
    ):
        scenes.make_active(obj)
        words = ""
        if not operator.poll():
            continue
        try:
            operator()
        except RuntimeError as refusal:
            words = str(refusal)
        assert "Traceback" not in words
        settle()
        points = scenes.evaluated_points(obj)
        assert scenes.close(points, shown, scenes.MATRIX) or scenes.close(points, rest, scenes.MATRIX)
    assert_others_live()


def test_it_goes_on_when_the_library_is_back(lost, tmp_path: Path):
    name, shown = lost
    assert_stays(name, shown)
    scenes.save(tmp_path / "without.blend")
    shutil.move(tmp_path / "away.blend", tmp_path / "control.blend")
    scenes.load(tmp_path / "without.blend")
    obj = bpy.data.objects[name]
    bpy.context.scene.frame_set(LATE)
    assert scenes.close(scenes.evaluated_points(obj), shown, scenes.MATRIX)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    bpy.context.scene.frame_set(1)
    assert not scenes.close(scenes.evaluated_points(obj), shown, 0.1)


OTHERS = {
    "empty": lambda: scenes.new_empty("Nothing"),
    "camera": lambda: scenes.linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))),
    "curve": lambda: scenes.linked(bpy.data.objects.new("Curve", bpy.data.curves.new("Curve", "CURVE"))),
    "armature": scenes.new_armature,
}


@pytest.mark.parametrize("way", ["script", "file"])
@pytest.mark.parametrize("other", OTHERS)
def test_a_cage_of_a_wrong_type(other: str, way: str, tmp_path: Path):
    rig = CageRig.new().start()
    beside = HandleRig.new("Other").start()
    beside.lift(0.5)
    wrong = OTHERS[other]()
    if way == "script":
        rig.deformer.cage = wrong
    else:
        scenes.storage(rig.obj)["sinew"]["deformers"][0]["cage"] = wrong
        rig.obj.update_tag()
    scenes.update()
    assert rig.deformer.status_level == "ERROR"
    for _ in range(2):
        assert_rests(rig.obj)
        for operator in ("bind", "cage_set_rest"):
            scenes.refused("no mesh", operator, rig.obj)
        assert_others_live()
        scenes.save(tmp_path / "wrong.blend")
        scenes.load(tmp_path / "wrong.blend")
    rig.deformer.cage = box("Another")
    rig.press("bind")
    rig.deformer.cage.location.z += 0.25
    assert scenes.close(scenes.evaluated_points(rig.obj), rig.rest() + (0.0, 0.0, 0.25), scenes.MATRIX)


@pytest.mark.parametrize("other", OTHERS)
def test_an_object_of_any_type_moves_a_handle(other: str):
    plate = HandleRig.new().start()
    plate.deformer.handles[0].control = OTHERS[other]()
    settle()
    plate.control.location.z += 0.25
    assert np.abs(scenes.evaluated_points(plate.obj)[plate.top, 2] - 0.25).max() < scenes.MATRIX
    plate.deformer.handles[0].bone = "none"
    settle()
    assert np.abs(scenes.evaluated_points(plate.obj)[plate.top, 2] - 0.25).max() < scenes.MATRIX
