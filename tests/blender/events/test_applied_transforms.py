# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply Location, Rotation and Scale, and Set Origin: rest and pose stay where they are in the world."""

import re
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import duplicate
from inside import calls_of, settle
from mathutils import Matrix
from probe import render_points
from registry import METHODS
from rigs import rig as scenes
from rigs.kinds import RIGS, HandleRig, rig_for

EXACT = 3e-5  # matrices and coordinates of a few units, rounded by Blender to float32 several times
PLACE = Matrix.Translation((0.7, -0.4, 1.1)) @ Matrix.Rotation(0.8, 4, (0.5, 0.3, 0.8)) @ Matrix.Scale(1.5, 4)
MIRRORED = Matrix.Translation((0.5, 0.0, 0.2)) @ Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0))
STRETCH = Matrix.Translation((0.7, -0.4, 1.1)) @ Matrix.Diagonal((2.0, 1.0, 1.0, 1.0))


def apply(**what: bool) -> Callable[[bpy.types.Object], None]:
    def do(obj: bpy.types.Object) -> None:
        scenes.make_active(obj)
        chosen = {"location": False, "rotation": False, "scale": False} | what
        assert bpy.ops.object.transform_apply("EXEC_DEFAULT", True, **chosen) == {"FINISHED"}

    return do


def set_origin(kind: str) -> Callable[[bpy.types.Object], None]:
    def do(obj: bpy.types.Object) -> None:
        bpy.context.scene.cursor.location = (0.3, 2.0, -1.0)
        scenes.make_active(obj)
        assert bpy.ops.object.origin_set("EXEC_DEFAULT", True, type=kind) == {"FINISHED"}

    return do


def by_script(obj: bpy.types.Object) -> None:
    """As importers and pipelines do; children stay where they are."""
    children = {child: child.matrix_world.copy() for child in obj.children}
    obj.data.transform(obj.matrix_world)
    obj.matrix_world = Matrix.Identity(4)
    for child, world in children.items():
        child.matrix_parent_inverse = world @ child.matrix_basis.inverted()
    scenes.update()


WAYS = {
    "location": apply(location=True),
    "rotation": apply(rotation=True),
    "scale": apply(scale=True),
    "all": apply(location=True, rotation=True, scale=True),
    "origin to geometry": set_origin("ORIGIN_GEOMETRY"),
    "origin to cursor": set_origin("ORIGIN_CURSOR"),
    "script": by_script,
}
ALL = WAYS["all"]
# How far the shape may change where the axes of the object decide something: cubes that stand along them
# change the shape of the plate by .007, of a diagonal of 6, and the lattice that a cage is made on by .013.
BY_AXES = {"rigid_cells": 0.01, "subspace_laplacian": 0.02}


def carry(rig: HandleRig, where: Matrix) -> None:
    """Move a rig as a whole."""
    control, follows = rig.control, rig.control.parent == rig.obj
    world = control.matrix_world.copy()
    rig.obj.matrix_world = where @ rig.obj.matrix_world
    if not follows:
        control.matrix_world = where @ world
    scenes.update()


def place(rig: HandleRig, where: Matrix = PLACE) -> None:
    """Move a rig as a whole, and remember where it rests: ``rig.frame``."""
    carry(rig, where)
    rig.frame = np.array(rig.obj.matrix_world)
    assert scenes.close(world_points(rig), expected(rig), EXACT)


def world_points(rig: HandleRig, obj: bpy.types.Object | None = None) -> np.ndarray:
    """What is shown of the rig, or of a copy."""
    points = scenes.evaluated_points(obj or rig.obj)
    return scenes.apply_matrix((obj or rig.obj).matrix_world, points)


def expected(rig: HandleRig, control: bpy.types.Object | None = None) -> np.ndarray:
    """In the world, with the control where it is: by the rest and the frame of before."""
    scenes.update()
    now = np.linalg.inv(rig.frame) @ np.array((control or rig.control).matrix_world, dtype=np.float64)
    return scenes.apply_matrix(rig.frame, rig.poses.shape(now @ np.linalg.inv(rig.poses._at_rest)))


def assert_shows(
    rig: HandleRig, shape: np.ndarray, tolerance: float = EXACT, obj: bpy.types.Object | None = None
) -> None:
    """In the world, of the rig or of a copy: at once, in a render, and after a pause."""
    obj = obj or rig.obj
    assert scenes.close(world_points(rig, obj), shape, tolerance)
    assert scenes.close(scenes.apply_matrix(obj.matrix_world, render_points(obj)), shape, tolerance)
    settle()
    assert scenes.close(world_points(rig, obj), shape, tolerance)


def assert_right(rig: HandleRig, tolerance: float = EXACT) -> None:
    assert_shows(rig, expected(rig), tolerance)


def assert_lives_on(rig: HandleRig, tolerance: float = EXACT) -> None:
    for lift in (0.0, 0.25):
        rig.lift(lift)
        assert_right(rig, tolerance)
    assert rig.deformer.status_level == "INFO", rig.deformer.status


@pytest.fixture
def placed(rig: HandleRig, tmp_path: Path) -> HandleRig:
    """At rest, away from the origin, turned and scaled."""
    rig.folder = tmp_path
    rig.start()
    place(rig)
    return rig


PLACED = [(way, PLACE, lift) for way in WAYS for lift in (0.0, 0.4)]
for scale in ((-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-2.0, -2.0, -2.0)):
    PLACED.append(("all", Matrix.Translation((0.5, 0.0, 0.2)) @ Matrix.Diagonal((*scale, 1.0)), 0.3))


@pytest.mark.parametrize(("way", "where", "lift"), PLACED)
def test_the_shape_stays_where_it_was(rig: HandleRig, way: str, where: Matrix, lift: float):
    """Where the scale mirrors, Blender 5.2 turns the faces to point outwards: they are the same faces."""
    rig.start()
    place(rig, where)
    rig.lift(lift)
    before = world_points(rig)
    WAYS[way](rig.obj)
    assert_shows(rig, before)
    assert_lives_on(rig)
    rig.press("bind")
    assert_lives_on(rig)


def test_twice_and_in_a_saved_file(placed: HandleRig):
    placed.lift(0.4)
    for way in ("rotation", "origin to cursor"):
        WAYS[way](placed.obj)
        assert_right(placed)
    scenes.reopen(placed.folder / "applied.blend")
    assert_lives_on(placed)
    ALL(placed.obj)
    assert_lives_on(placed)


@pytest.mark.parametrize("way", ["all", "origin to cursor"])
def test_undo_and_redo(placed: HandleRig, way: str):
    placed.lift(0.4)
    scenes.push("posed")
    WAYS[way](placed.obj)
    assert_right(placed)
    placed.lift(0.25)
    scenes.push("lifted")
    undo, redo = bpy.ops.ed.undo, bpy.ops.ed.redo
    for way, applied in ((undo, 1), (undo, 0), (redo, 1), (undo, 0), (redo, 1), (redo, 1)):
        way()
        settle()
        assert np.allclose(np.array(placed.obj.matrix_world), placed.frame) != bool(applied)
        assert_right(placed)
    assert_lives_on(placed)


@pytest.mark.parametrize("mirrored", [False, True], ids=["turned", "mirrored"])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_every_method(method, mirrored: bool):
    rig = rig_for(method.id).start(method.id)
    # The default stop of an iteration leaves up to .16 % of the box, whose diagonal is 6. Embedded
    # deformation does not depend on the axes, and takes as many steps from any.
    iterates = method.iterative or any(row.id == "max_iterations" for row in method.parameters)
    rig.exactness = 0.01 if iterates and method.id != "embedded_deformation" else EXACT
    place(rig, MIRRORED if mirrored else PLACE)
    rig.lift(0.3)
    before = world_points(rig)
    ALL(rig.obj)
    after = world_points(rig)
    changed = np.linalg.norm(after - before, axis=1).max()
    what = "mirroring" if mirrored else "transform"
    told = re.search(
        rf"up to ([\d.]+), as {method.label} depends on the {what} that was applied", rig.deformer.status
    )
    assert rig.deformer.status_level == ("WARNING" if told else "INFO"), rig.deformer.status
    if iterates and told:
        assert changed == pytest.approx(float(told[1]), rel=0.01)
        assert changed < BY_AXES.get(method.id, rig.exactness)
    else:
        assert changed < rig.exactness
    assert_shows(rig, after, rig.exactness)


def flip_all(obj: bpy.types.Object) -> None:
    scenes.on_all(obj, bpy.ops.mesh.flip_normals)
    settle()


@pytest.mark.parametrize("turn", [ALL, flip_all], ids=["applied", "flipped"])
def test_modifiers_that_number_their_vertices_anew_for_turned_faces(rig: HandleRig, turn: Callable):
    """Two parts, which renders show finer. A vertex has another number afterwards, but the same place."""
    if rig.obj.type != "MESH":
        pytest.skip("about faces")
    rig.obj.modifiers.new("Array", "ARRAY").relative_offset_displace = (0.0, 1.5, 0.0)
    scenes.subdivided(rig.obj, 2, 3)
    rig.bind_alone(rig.methods[0])
    carry(rig, MIRRORED)
    rig.lift(0.3)
    scenes.push("posed")
    before = places_shown(rig)
    turn(rig.obj)
    scenes.push("turned")
    for step in (None, bpy.ops.ed.undo, bpy.ops.ed.redo):
        if step is not None:
            step()
            settle()
        for seen, shape in zip(places_shown(rig), before, strict=True):
            assert max(scenes.nearest(seen, shape)[1].max(), scenes.nearest(shape, seen)[1].max()) < EXACT
        assert rig.deformer.status_level == "INFO", rig.deformer.status


def places_shown(rig: HandleRig) -> list[np.ndarray]:
    return [
        scenes.apply_matrix(rig.obj.matrix_world, shape)
        for shape in (scenes.evaluated_points(rig.obj), render_points(rig.obj))
    ]


def far_away(rig: HandleRig) -> None:
    place(rig, Matrix.Translation((2000.0, -1000.0, 500.0)))


def stretched_at_rest(rig: HandleRig) -> None:
    """An uneven scale is exact there."""
    rig.lift_to(0.0)
    rig.relax()
    carry(rig, STRETCH)


def with_shape_keys(rig: HandleRig) -> None:
    scenes.add_key(rig.obj, "Bump", scenes.slope(0.2)).value = 0.5
    rig.obj.matrix_world = PLACE


def with_two_deformers(rig: HandleRig) -> None:
    place(rig)
    if rig.deformer.handles:
        rig.bind("arap")
        rig.lift(0.1)


@pytest.mark.parametrize(
    ("rig", "prepare", "tolerance"),
    [
        ("handles", far_away, 1e-3),
        ("handles", with_shape_keys, EXACT),
        *((kind, stretched_at_rest, EXACT) for kind in RIGS),
        *((kind, with_two_deformers, 2e-3) for kind in RIGS),
    ],
    indirect=["rig"],
)
def test_all_of_it_is_applied(posed: HandleRig, prepare: Callable, tolerance: float):
    prepare(posed)
    before = world_points(posed)
    ALL(posed.obj)
    assert_shows(posed, before, tolerance)


@pytest.mark.parametrize("carried", [1.0, 10.0], ids=["alone", "on a parent of ten times the scale"])
def test_where_the_proportions_count_the_status_says_so(posed_plate: HandleRig, carried: float):
    """A thin shell twice as wide bends otherwise. What is told is a length in the world."""
    rig = posed_plate
    world = rig.control.matrix_world.copy()
    rig.control.parent, rig.control.matrix_world = None, world
    parent = scenes.new_empty("Parent")
    rig.control.parent = rig.obj.parent = parent
    parent.scale = (carried, carried, carried)
    carry(rig, STRETCH)
    scenes.move_world(rig.control, Matrix.Rotation(0.7, 4, "Y"))
    before = world_points(rig)
    ALL(rig.obj)
    after = world_points(rig)
    changed = np.linalg.norm(after - before, axis=1).max()
    told = re.search(
        r"up to ([\d.]+), as .* depends on the proportions that were applied", rig.deformer.status
    )
    assert told, rig.deformer.status
    assert rig.deformer.status_level == "WARNING"
    assert float(told[1]) == pytest.approx(changed, rel=0.01)
    assert "undo" in rig.deformer.status
    assert scenes.close(after[rig.top], before[rig.top], EXACT * carried)
    assert not scenes.close(after, before, 1e-3)
    assert_shows(rig, after, EXACT * carried)
    rig.lift(0.1)
    assert rig.deformer.status_level == "INFO"


# --- what else hangs on the mesh


@pytest.mark.parametrize("on_the_same_mesh", [True, False])
def test_a_copy_stays_where_it_is(placed: HandleRig, on_the_same_mesh: bool):
    """Set Origin moves the mesh that both share, and both objects; others share the stored rest shapes."""
    rig = placed
    rig.lift(0.4)
    copy = duplicate(rig, linked=on_the_same_mesh)
    rig.lift_of(copy, 0.1)
    before = [world_points(rig, obj) for obj in (rig.obj, copy)]
    if on_the_same_mesh:
        scenes.make_active(rig.obj, copy)
        assert bpy.ops.object.origin_set("EXEC_DEFAULT", True, type="ORIGIN_CURSOR") == {"FINISHED"}
        settle()
    else:
        ALL(copy)
    for obj, shape in zip((rig.obj, copy), before, strict=True):
        assert_shows(rig, shape, obj=obj)
    rig.lift(0.2)
    assert_right(rig)


def test_an_armature_below(plate):
    bone = scenes.add_armature(plate.obj).pose.bones["high"]
    plate.obj.matrix_world = Matrix.Translation((0.0, 0.0, 0.6)) @ Matrix.Rotation(0.5, 4, "Z")
    plate.bind("thin_shell")
    bone.rotation_euler.x = 0.5
    plate.lift(0.3)
    before = world_points(plate)
    ALL(plate.obj)
    assert_shows(plate, before)
    for angle in (0.2, 0.5):
        bone.rotation_euler.x = angle
        assert scenes.close(world_points(plate), before, EXACT if angle == 0.5 else 0.01) == (angle == 0.5)


def test_while_live_is_off(placed: HandleRig):
    placed.lift(0.3)
    before = world_points(placed)
    placed.deformer.live = False
    placed.lift(0.2)
    ALL(placed.obj)
    assert_shows(placed, before)
    placed.deformer.live = True
    assert_right(placed)


def test_a_region_that_has_lost_its_control(placed: HandleRig):
    placed.lift(0.3)
    before = world_points(placed)
    bpy.data.objects.remove(placed.control)
    assert scenes.close(world_points(placed), before, EXACT)
    ALL(placed.obj)
    assert_shows(placed, before)
    if placed.goes_on:
        scenes.reopen(placed.folder / "lost.blend")
        assert scenes.close(world_points(placed), before, EXACT)


def test_the_cage_rests_again_where_it_is(placed: HandleRig):
    """New Rest and Unbind forget what Apply did."""
    if placed.deformer.cage is None:
        pytest.skip("about cages")
    placed.lift(0.3)
    ALL(placed.obj)
    placed.press("cage_set_rest")
    assert scenes.close(placed.points(), placed.unmoved(placed.obj), EXACT)
    placed.press("unbind")
    placed.press("bind")
    assert scenes.close(placed.points(), placed.unmoved(placed.obj), EXACT)


# --- what is no Apply


def geometry_to_origin(obj: bpy.types.Object) -> None:
    """Moves the mesh, and neither its object nor its controls."""
    set_origin("GEOMETRY_ORIGIN")(obj)


def transformed(obj: bpy.types.Object) -> None:
    """By a script that does not touch the object."""
    obj.data.transform(Matrix.Translation((0.2, 0.0, 0.4)) @ Matrix.Rotation(0.4, 4, "X"))
    scenes.push("moved")


@pytest.mark.parametrize("move", [geometry_to_origin, transformed], ids=lambda move: move.__name__)
def test_a_mesh_that_was_moved_away_from_its_controls_says_so(rig: HandleRig, move: Callable):
    """It is an edit on top of the pose, until it is undone."""
    rig.obj.data.transform(Matrix.Translation((0.0, 0.0, 0.5)))  # away from the origin before it is bound
    rig.start()
    rig.lift(0.4)
    before = world_points(rig)
    scenes.push("posed")
    move(rig.obj)
    assert rig.deformer.status_level == "WARNING"
    assert "away from its controls" in rig.deformer.status
    assert "undo" in rig.deformer.status
    assert not scenes.close(world_points(rig), before, 0.1)
    bpy.ops.ed.undo()
    settle()
    assert rig.deformer.status_level == "INFO"
    assert scenes.close(world_points(rig), before, EXACT)


def test_an_ordinary_frame_looks_at_nothing(posed_plate: HandleRig):
    rig = posed_plate
    for obj in (rig.control, rig.obj):
        scenes.key_heights(obj, {1: 0.0, 11: 1.0})
    bpy.context.scene.frame_set(2)
    found = calls_of(lambda: bpy.context.scene.frame_set(5))
    assert found["write_shape"] == 1, found
    assert not {"follow", "sample"} & found.keys(), found
