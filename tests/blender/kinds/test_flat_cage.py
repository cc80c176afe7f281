# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage in a plane bends flat art: curves, text and flat meshes."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from rigs.cages import ball, place, surround, transform
from rigs.point_objects import curve_object
from rigs.rig import (
    apply_matrix,
    base_points,
    evaluated_points,
    grid_object,
    new_object,
    press,
    update,
)

FLAT_METHODS = ("mean_value", "green")
OTHERS = ("positive_mean_value", "harmonic")
SHARE = 2e-6  # of a unit: weights and coordinates have single precision


def add_cage(obj: bpy.types.Object, method: str, **options: object) -> bpy.types.Object:
    press(obj, "cage_add", method=method, **options)
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
    update()
    return obj


def lettering() -> bpy.types.Object:
    bpy.ops.object.text_add()
    bpy.context.object.data.body = "Flat"
    return bpy.context.object


TARGETS = {"mesh": grid_object, "curve": drawing, "text": lettering}


@pytest.mark.parametrize("method", FLAT_METHODS)
@pytest.mark.parametrize("kind", TARGETS)
def test_add_cage_makes_a_flat_outline(kind: str, method: str) -> None:
    obj = TARGETS[kind]()
    cage = add_cage(obj, method)
    assert len(cage.data.polygons) == 1
    assert np.ptp(base_points(cage) @ np.array(cage.data.polygons[0].normal)) < SHARE
    assert "outside" not in obj.sinew.active.status
    rest = evaluated_points(obj)
    motion = Matrix.Translation((0.2, 0.1, 0.4)) @ Matrix.Rotation(0.5, 4, (1.0, 2.0, -1.0))
    transform(cage, motion)
    update()
    np.testing.assert_allclose(evaluated_points(obj), apply_matrix(motion, rest), rtol=0, atol=10 * SHARE)


@pytest.mark.parametrize("method", OTHERS)
def test_other_methods_get_a_closed_cage_and_refuse_a_flat_one(method: str) -> None:
    cage = add_cage(grid_object(), method, faces=60, margin=0.1)
    assert len(cage.data.polygons) > 20
    other = grid_object("Other")
    outline = new_object("Outline", [(-9, -9, 0), (9, -9, 0), (0, 9, 0)], [(0, 1, 2)])
    deformer = surround(other, outline, method)
    assert "take flat cages" in deformer.status
    deformer.method = "green"
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert "take flat cages" not in deformer.status


def test_a_grid_is_a_cage_by_its_outline() -> None:
    target, cage = grid_object(), grid_object("Cage", cells=2)
    cage.data.transform(Matrix.Scale(1.5, 4))
    surround(target, cage)
    rest = base_points(target)
    points = base_points(cage)
    place(cage, points * (1.0, 2.0, 1.0))
    update()
    np.testing.assert_allclose(evaluated_points(target), rest * (1.0, 2.0, 1.0), rtol=0, atol=10 * SHARE)
    middle = int(np.abs(points).sum(1).argmin())
    points[middle] += (0.0, 0.0, 3.0)  # on no outline, so it moves nothing
    place(cage, points)
    update()
    np.testing.assert_allclose(evaluated_points(target), rest, rtol=0, atol=10 * SHARE)


def test_a_flat_cage_that_crosses_itself_is_named() -> None:
    target = grid_object()
    bow = new_object("Bow", [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-1, -4, 0), (-3, 3, 0)], [(0, 1, 2, 3, 4)])
    assert "crosses itself" in surround(target, bow).status
    bpy.ops.sinew.select_problems()
    assert [vertex.index for vertex in bow.data.vertices if vertex.select] == [0, 1, 2, 3, 4]


def test_changing_the_faces_of_a_flat_cage_keeps_it_flat() -> None:
    obj = grid_object()
    cage = add_cage(obj, "mean_value", faces=240)
    before = len(cage.data.vertices)
    assert bpy.ops.sinew.cage_faces(faces=600) == {"FINISHED"}
    assert len(cage.data.polygons) == 1
    assert len(cage.data.vertices) > 1.5 * before


def test_a_solid_target_gets_a_closed_cage() -> None:
    assert len(add_cage(ball(), "mean_value", faces=60, margin=0.1).data.polygons) > 20
