# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves the mesh: by object, by its vertices, by shape keys and bones; its rest, its smoothness."""

from __future__ import annotations

import threading
from collections.abc import Callable

import bmesh
import bpy
import numpy as np
import pytest
from inside import inner
from mathutils import Matrix, Vector
from registry import WITH_CAGE
from rigs import rig as scenes
from rigs.cages import (
    assert_goes_on,
    assert_rests,
    ball,
    box,
    crease,
    cross,
    motion_of,
    place,
    selected,
    set_rest,
    surround,
    transform,
)
from rigs.point_objects import bezier, curve_object, poly

Caged = tuple[bpy.types.Object, bpy.types.Object]


@pytest.fixture
def caged() -> Caged:
    """A ball and its cage, bound by mean value coordinates."""
    target, cage = ball(), box()
    surround(target, cage)
    return target, cage


@pytest.mark.parametrize("method", ["mean_value", "harmonic"])
def test_a_smooth_cage_moves_as_one_with_a_subdivision_modifier(method: str):
    """The same with few points; Blender's limit surface is the other cage, with the same creases."""
    places = []
    for smooth in (False, True):
        target, cage = ball(), box()
        cage.data.transform(Matrix.Scale(1.7, 4))  # so that its smooth surface encloses the ball
        crease(cage, range(3), 0.6)
        if not smooth:
            refine = cage.modifiers.new("Subdivision", "SUBSURF")
            refine.levels, refine.quality, refine.use_limit_surface = 2, 10, True
        deformer = surround(target, cage, method)
        if smooth:
            deformer.parameters.smooth = "levels"
            scenes.update()
            assert "cage of 6 faces (8 vertices)" in deformer.status
        cage.data.vertices[6].co += Vector((0.9, 0.4, 0.7))
        cage.data.vertices[1].co += Vector((0.0, -0.8, 0.2))
        scenes.update()
        assert deformer.status_level == "INFO", deformer.status
        places.append(scenes.evaluated_points(target))
        if not smooth:
            surface = scenes.evaluated_points(cage)
    curves = inner.smooth.curves(deformer)  # of eight pieces, where the modifier makes four
    assert len(curves) == 12
    assert np.linalg.norm(curves[:, ::2, None] - surface, axis=3).min(axis=2).max() < 1e-5
    assert np.abs(places[0] - scenes.base_points(target)).max() > 0.1
    assert np.abs(places[1] - places[0]).max() < (1e-5 if method == "mean_value" else 5e-3)


def test_new_rest_takes_creases(caged: Caged):
    target, cage = caged
    target.sinew.active.parameters.smooth = "automatic"
    cage.data.transform(Matrix.Scale(1.7, 4))
    set_rest(target)
    shapes = []
    for value in (0.0, 1.0):
        crease(cage, range(12), value)
        set_rest(target)
        cage.data.vertices[7].co *= 1.3
        scenes.update()
        shapes.append(scenes.evaluated_points(target))
        cage.data.vertices[7].co /= 1.3
        scenes.update()
    assert np.abs(shapes[1] - shapes[0]).max() > 0.01


def test_faces_of_a_cage_that_cross_are_named_and_can_be_selected():
    """A face that a modifier of the cage made is none of the cage's own: then Select says so."""
    target, cage = ball(), box()
    cross(cage)
    cage.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    deformer = surround(target, cage)

    def crossing() -> tuple[int, object]:
        notes = [note for note in inner.status.notes(deformer.uid) if note.elements]
        (line,) = (i for i, note in enumerate(notes) if note.elements.owner.name == "CONTROL")
        assert "faces of the cage cross" in notes[line].text
        assert notes[line].elements.element == "face"
        return line, notes[line].elements

    scenes.refused("turn off its modifiers", "select_problems", target, line=crossing()[0])
    cage.modifiers.clear()
    set_rest(target)
    line, elements = crossing()
    shown, faces = selected(target, "face", line)
    assert shown == cage
    assert set(elements.indices) <= faces


def test_a_cage_inside_out_can_be_flipped():
    target, cage = ball(), box()
    cage.data.flip_normals()
    deformer = surround(target, cage)
    assert deformer.status_level == "ERROR"
    assert "inside out" in deformer.status
    assert inner.status.current(deformer.uid).remedy.name == "FLIP_CAGE"
    assert_rests(target)
    scenes.press(target, "select_problems")
    assert bpy.context.object == cage
    assert cage.mode == "EDIT"
    assert all(face.select for face in bmesh.from_edit_mesh(cage.data).faces)
    assert bpy.ops.sinew.cage_flip() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert_goes_on(target, cage)


def pull_out(obj: bpy.types.Object) -> None:
    """Three of its points."""
    if obj.type == "MESH":
        for index in (3, 5, 7):
            obj.data.vertices[index].co.z = 5.0
        return
    spline = obj.data.splines[0]
    for point in (*spline.bezier_points, *spline.points)[1:4]:
        for name in ("co", "handle_left", "handle_right")[: 1 if spline.type == "POLY" else 3]:
            getattr(point, name).z = 5.0


OUTSIDE = {  # how a target is made, and what is said of it
    "mesh": (ball, "3 vertices lie outside the cage"),
    "curve": (poly, "3 points lie outside the cage"),
    "Bezier": (bezier, "points and handles lie outside the cage"),
}


@pytest.mark.parametrize("kind", OUTSIDE)
@pytest.mark.parametrize("method", WITH_CAGE)
def test_points_outside_are_said_alike_by_all_methods_and_can_follow(method: str, kind: str):
    """Mean Value and Green warn, the others refuse until a button takes the first or lets them follow."""
    status, (make, outside) = inner.status, OUTSIDE[kind]
    target, cage = make(), box(size=2.0 if kind == "mesh" else 3.0)
    pull_out(target)
    deformer = surround(target, cage, method)
    if method == "green":
        deformer.green.outside = "error"
        scenes.update()
    lines = (status.current(deformer.uid), *status.notes(deformer.uid))
    (said,) = (line for line in lines if "outside" in line.text)
    assert outside in said.text
    assert said.elements.indices == ((3, 5, 7) if kind == "mesh" else ())
    scenes.make_active(target)
    if method == "mean_value":
        assert said.level is status.Level.WARNING
        assert not bpy.ops.sinew.cage_outside_follow.poll()
    else:
        assert (said.level, said.remedy) == (status.Level.ERROR, inner.errors.OutsideError.remedy)
        if kind != "mesh":
            assert bpy.ops.sinew.select_problems() == {"CANCELLED"}
        quick = inner.status_box.remedies()[status.Remedy.QUICK_CAGE]
        assert bpy.ops.sinew.use_method(**dict(quick.properties)) == {"FINISHED"}
        assert deformer.status_level == "INFO"
        deformer.method = method
        scenes.update()
        assert bpy.ops.sinew.cage_outside_follow() == {"FINISHED"}
        (note,) = status.notes(deformer.uid)
        assert outside in note.text
    if kind != "Bezier":
        assert_goes_on(target, cage)


def by_four_balls(obj: bpy.types.Object) -> None:
    """Far apart."""
    edit = bmesh.new()
    for centre in ((3.0, 3.0, 3.0), (3.0, -3.0, -3.0), (-3.0, 3.0, -3.0), (-3.0, -3.0, 3.0)):
        bmesh.ops.create_icosphere(edit, subdivisions=2, radius=1.0, matrix=Matrix.Translation(centre))
    edit.to_mesh(obj.data)
    edit.free()


def by_horns(obj: bpy.types.Object) -> None:
    """To each side, and no two are alike."""
    for vertex in obj.data.vertices:
        for axis, sign, length in ((0, 1, 2.0), (1, 1, 3.0), (2, -1, 2.5)):
            if sign * vertex.co[axis] > 0.58:
                vertex.co[axis] *= length


@pytest.mark.parametrize(
    ("reshape", "options", "words", "told"),
    [
        (by_four_balls, {"faces": 12, "margin": 0.02}, "faces instead of 12: with fewer", True),
        (by_four_balls, {"faces": 100, "margin": 0.02}, "with fewer", False),
        (by_horns, {"faces": 60, "margin": 0.06}, "not symmetric: the sides differ by", True),
        (by_horns, {"faces": 60, "margin": 0.06, "symmetric": False}, "not symmetric", False),
    ],
)
def test_an_automatic_cage_says_where_it_is_not_as_it_was_asked_for(
    capfd: pytest.CaptureFixture, reshape: Callable, options: dict, words: str, told: bool
):
    target = ball()
    reshape(target)
    scenes.press(target, "cage_add", source="AUTO", **options)
    assert (words in capfd.readouterr().out) is told


def test_faces_of_an_automatic_cage_can_be_changed_as_long_as_it_is_as_made():
    """It is symmetric about a plane of the ball, which is turned."""
    target = ball()
    target.location, target.rotation_euler = (3.0, -1.0, 0.5), (0.4, 0.2, 1.1)
    scenes.press(target, "cage_add", faces=80, margin=0.06)
    scenes.make_active(target)
    cage, rest = target.sinew.active.cage, scenes.evaluated_points(target)
    for faces in (30, 160):
        assert bpy.ops.sinew.cage_faces(faces=faces) == {"FINISHED"}
        assert faces - 2 <= len(cage.data.polygons) <= faces + 1
        assert target.sinew.active.cage == cage
        assert scenes.close(scenes.evaluated_points(target), rest, 4 * scenes.FLOAT32)
        low, high = scenes.base_points(cage).min(axis=0), scenes.base_points(cage).max(axis=0)
        assert (low == -high).any()
    cage.location.x += 0.5
    moved = np.linalg.norm(scenes.evaluated_points(target) - rest, axis=1)
    assert np.abs(moved - 0.5).max() < 1e-4  # it is bound, and takes the ball along


@pytest.mark.parametrize("sheared", [False, True])
def test_an_automatic_cage_rides_along_and_stays_where_it_is_under_another_parent(sheared: bool):
    target = ball()
    target.location, target.rotation_euler, target.scale = (3.0, -1.0, 0.5), (0.4, 0.2, 1.1), (1.5, 0.7, 1.0)
    if sheared:
        target.parent = scenes.new_empty("Above")
        target.parent.scale.x = 3.0
    scenes.press(target, "cage_add", source="AUTO", faces=60)
    cage = target.sinew.active.cage
    assert not any(vertex.select for vertex in cage.data.vertices)  # so that a first click picks what moves
    target.location.x += 2.0
    assert np.abs(motion_of(target)).max() < 4 * scenes.FLOAT32
    if sheared:
        return  # no location, rotation and scale of its own stand for where it is
    target.location.x -= 2.0
    scenes.update()
    place = np.array(cage.matrix_world)
    rig = scenes.new_empty("Rig", (5.0, 6.0, 7.0))
    scenes.make_active(rig, cage)
    assert bpy.ops.object.parent_set(type="OBJECT") == {"FINISHED"}
    scenes.update()
    assert cage.parent == rig
    assert np.abs(np.array(cage.matrix_world) - place).max() < 1e-5


def test_rays_are_shown_until_the_exact_weights_are_there(caged: Caged, monkeypatch: pytest.MonkeyPatch):
    """As in a window, where heavy meshes bind in a thread."""
    target, cage = caged
    binding, deformer = inner.binding, target.sinew.active
    monkeypatch.setattr(binding, "may_wait", lambda _count: True)
    may_begin, build = threading.Event(), binding.build_factor
    monkeypatch.setattr(binding, "build_factor", lambda *found: may_begin.wait(20.0) and build(*found))
    may_begin.set()
    cage.data.vertices[0].co = (-1.6, -0.7, -1.3)
    with inner.sessions.suspended():
        deformer.method = "positive_mean_value"
    session = inner.sessions.find(deformer.uid)
    assert binding.ensure(session, deformer, deformer, wait=False) is None
    shapes = []
    for is_preview in (True, False):
        binding.job(deformer.uid).thread.join(timeout=20.0)
        may_begin.clear()  # so that the exact weights are still under way below
        assert binding.collect() == [deformer.uid]
        assert session.bound.is_preview is is_preview
        target.update_tag(refresh={"OBJECT"})
        if is_preview:  # what came in between stopped the exact weights: they are asked for anew
            assert binding.ensure(session, deformer, deformer, wait=False) is session.bound
            binding.abandon(deformer.uid)
            may_begin.set()
            assert binding.ensure(session, deformer, deformer, wait=False) is None
            binding.job(deformer.uid).thread.join(timeout=20.0)
            assert binding.collect() == [deformer.uid]
        shapes.append(scenes.evaluated_points(target) if not is_preview else _shown_by(session, cage, target))
    assert binding.job(deformer.uid) is None
    monkeypatch.undo()
    assert 1e-6 < np.abs(shapes[0] - shapes[1]).max() < 0.1
    bpy.ops.sinew.bind()
    assert np.abs(scenes.evaluated_points(target) - shapes[1]).max() < scenes.FLOAT32


def _shown_by(session, cage: bpy.types.Object, target: bpy.types.Object) -> np.ndarray:
    """By the factor that is bound; in background an evaluation would wait for the exact one."""
    relative = target.matrix_world.inverted() @ cage.matrix_world
    return session.bound.factor.solve(scenes.apply_matrix(relative, scenes.base_points(cage)))[0]


# --- a cage in a plane bends flat art: curves, text and flat meshes


FLAT_METHODS = ("mean_value", "green")
OTHERS = ("positive_mean_value", "harmonic")
SHARE = 2e-6  # of a unit: weights and coordinates have single precision


def add_cage(obj: bpy.types.Object, method: str, **options: object) -> bpy.types.Object:
    scenes.press(obj, "cage_add", method=method, **options)
    assert obj.sinew.active.is_bound
    return obj.sinew.active.cage


def drawing() -> bpy.types.Object:
    """A closed curve in its plane, turned out of the axes of the world."""
    obj = curve_object("Drawing")
    obj.data.dimensions = "2D"
    spline = obj.data.splines.new("POLY")
    spline.points.add(11)
    for index, point in enumerate(spline.points):
        angle = 2 * np.pi * index / 12
        point.co = (1 + 0.3 * (index % 2)) * np.cos(angle), np.sin(angle), 0.0, 1.0
    spline.use_cyclic_u = True
    obj.matrix_world = Matrix.Rotation(0.7, 4, "X") @ Matrix.Translation((1, 2, 3))
    scenes.update()
    return obj


def lettering() -> bpy.types.Object:
    bpy.ops.object.text_add()
    bpy.context.object.data.body = "Flat"
    return bpy.context.object


TARGETS = {"mesh": scenes.grid_object, "curve": drawing, "text": lettering}


@pytest.mark.parametrize("method", FLAT_METHODS)
@pytest.mark.parametrize("kind", TARGETS)
def test_add_cage_makes_a_flat_outline(kind: str, method: str) -> None:
    obj = TARGETS[kind]()
    cage = add_cage(obj, method)
    assert len(cage.data.polygons) == 1
    assert np.ptp(scenes.base_points(cage) @ np.array(cage.data.polygons[0].normal)) < SHARE
    assert "outside" not in obj.sinew.active.status
    rest = scenes.evaluated_points(obj)
    motion = Matrix.Translation((0.2, 0.1, 0.4)) @ Matrix.Rotation(0.5, 4, (1.0, 2.0, -1.0))
    transform(cage, motion)
    scenes.update()
    np.testing.assert_allclose(
        scenes.evaluated_points(obj), scenes.apply_matrix(motion, rest), rtol=0, atol=10 * SHARE
    )


@pytest.mark.parametrize("method", OTHERS)
def test_other_methods_get_a_closed_cage_and_refuse_a_flat_one(method: str) -> None:
    cage = add_cage(scenes.grid_object(), method, faces=60, margin=0.1)
    assert len(cage.data.polygons) > 20
    other = scenes.grid_object("Other")
    outline = scenes.new_object("Outline", [(-9, -9, 0), (9, -9, 0), (0, 9, 0)], [(0, 1, 2)])
    deformer = surround(other, outline, method)
    assert "take flat cages" in deformer.status
    deformer.method = "green"
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert "take flat cages" not in deformer.status


def test_a_grid_is_a_cage_by_its_outline() -> None:
    """Its middle vertex is on no outline, so it moves nothing."""
    target, cage = scenes.grid_object(), scenes.grid_object("Cage", cells=2)
    cage.data.transform(Matrix.Scale(1.5, 4))
    surround(target, cage)
    rest, points = scenes.base_points(target), scenes.base_points(cage)
    for lift, stretch in ((0.0, 2.0), (3.0, 1.0)):
        place(cage, points * (1.0, stretch, 1.0) + np.outer(np.arange(9) == 4, (0.0, 0.0, lift)))
        assert scenes.close(scenes.evaluated_points(target), rest * (1.0, stretch, 1.0), 10 * SHARE)


def test_a_flat_cage_that_crosses_itself_is_named() -> None:
    target = scenes.grid_object()
    bow = scenes.new_object(
        "Bow", [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-1, -4, 0), (-3, 3, 0)], [(0, 1, 2, 3, 4)]
    )
    assert "crosses itself" in surround(target, bow).status
    bpy.ops.sinew.select_problems()
    assert [vertex.index for vertex in bow.data.vertices if vertex.select] == [0, 1, 2, 3, 4]


def test_changing_the_faces_of_a_flat_cage_keeps_it_flat_and_a_solid_target_gets_a_closed_one() -> None:
    cage = add_cage(scenes.grid_object(), "mean_value", faces=240)
    before = len(cage.data.vertices)
    assert bpy.ops.sinew.cage_faces(faces=600) == {"FINISHED"}
    assert len(cage.data.polygons) == 1
    assert len(cage.data.vertices) > 1.5 * before
    assert len(add_cage(ball(), "mean_value", faces=60, margin=0.1).data.polygons) > 20
