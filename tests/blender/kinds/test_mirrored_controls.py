# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls whose objects are mirrored by a negative scale, and targets that are: Blender shows both well."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from probe import render_points
from registry import WITH_CAGE
from rigs import rig as scenes
from rigs.cages import TURN, assert_goes_on, assert_rests, ball, box, place, set_rest, surround

MIRROR = (-1.0, 1.0, 1.0)
UNEVEN = [*scenes.CORNERS[:-1], (1.5, 1.2, 1.1)]  # no mirror image of itself


MIRRORED = {  # what is set of the target, and of its cage
    "cage": ({}, {"scale": MIRROR}),
    "cage that its scale turns inside out": (
        {},
        {"scale": (-1.1, -1.2, -1.0), "rotation_euler": (0.2, 0.1, 0.3)},
    ),
    "cage by its parent": ({}, {"parent": "Parent"}),
    "cage by its delta scale": ({}, {"delta_scale": MIRROR}),
    "target": ({"scale": (0.9, -0.9, 0.9), "rotation_euler": (0.2, 0.1, 0.3)}, {}),
    "both": ({"scale": MIRROR}, {"scale": MIRROR}),
}


def in_world(obj: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    return scenes.apply_matrix(obj.matrix_world, points)


@pytest.mark.parametrize("mirror", MIRRORED)
@pytest.mark.parametrize("method", WITH_CAGE)
def test_a_mirrored_cage_or_target_is_as_good_as_one_whose_scale_is_applied(method: str, mirror: str):
    """Bound, posed, rendered and set to rest; and truly inside out it is refused, until it is flipped."""
    target, cage = ball(), box()
    place(cage, UNEVEN)
    scenes.new_empty("Parent").scale = MIRROR
    for obj, settings in zip((target, cage), MIRRORED[mirror], strict=True):
        for name, value in settings.items():
            setattr(obj, name, bpy.data.objects[value] if name == "parent" else value)
    scenes.update()
    deformer = surround(target, cage, method)
    assert deformer.status_level == "INFO", deformer.status
    rest = scenes.base_points(target)
    assert scenes.close(scenes.evaluated_points(target), rest, scenes.MATRIX)

    twin, applied = ball("Twin"), box("Applied")
    place(applied, in_world(cage, scenes.base_points(cage)).tolist())
    if cage.matrix_world.determinant() < 0.0:
        applied.data.flip_normals()
    twin.data.transform(target.matrix_world)
    if target.matrix_world.determinant() < 0.0:
        twin.data.flip_normals()
    surround(twin, applied, method)
    place(cage, [*UNEVEN[:-1], (1.1, 0.7, 1.9)])
    place(applied, in_world(cage, scenes.base_points(cage)).tolist())
    posed = in_world(target, scenes.evaluated_points(target))
    assert np.abs(posed - in_world(target, rest)).max() > 0.02
    assert scenes.close(posed, scenes.evaluated_points(twin), scenes.MATRIX)
    assert scenes.close(in_world(target, render_points(target)), posed, scenes.MATRIX)

    place(cage, UNEVEN)
    scenes.move_world(cage, TURN)
    assert scenes.close(
        in_world(target, scenes.evaluated_points(target)),
        scenes.apply_matrix(TURN, in_world(target, rest)),
        2e-5,
    )
    set_rest(target)
    assert deformer.status_level == "INFO", deformer.status
    assert scenes.close(scenes.evaluated_points(target), rest, scenes.MATRIX)

    cage.data.flip_normals()
    scenes.refused("inside out", "cage_set_rest", target)
    assert_rests(target)
    assert bpy.ops.sinew.cage_flip() == {"FINISHED"}
    assert scenes.close(scenes.evaluated_points(target), rest, scenes.MATRIX)


@pytest.mark.parametrize("shape", ["BOX", "CYLINDER", "FITTED"])
def test_a_mirrored_lattice_is_a_lattice(shape: str):
    target = ball()
    scenes.press(target, "lattice_add", shape=shape, resolution=(4, 2, 3))
    deformer, rest = target.sinew.active, scenes.base_points(target)
    lattice = deformer.controls[0].object
    lattice.scale.x *= -1.0
    scenes.press(target, "lattice_set_rest")
    assert deformer.status_level == "INFO", deformer.status
    assert scenes.close(scenes.evaluated_points(target), rest, scenes.MATRIX)
    scenes.move_world(lattice, TURN)
    assert scenes.close(scenes.evaluated_points(target), scenes.apply_matrix(TURN, rest), 2e-5)


def test_a_mirrored_mesh_is_a_cage_of_the_subspace_laplacian(plate: scenes.Rig):
    plate.bind("subspace_laplacian").lift(1.0)
    cage = plate.deformer.parameters.cage = box(size=4.0)
    shapes = []
    for cage.scale in ((1.0, 1.0, 1.0), MIRROR):
        shapes.append(plate.points())
        assert plate.deformer.status_level == "INFO", plate.deformer.status
    assert np.abs(shapes[1] - plate.rest()).max() > 0.1
    assert np.abs(np.subtract(*shapes)).max() < 0.1  # the cage is cut along other diagonals


def test_faces_of_an_automatic_cage_that_was_mirrored_can_be_changed():
    target = ball()
    scenes.press(target, "cage_add", faces=80, margin=0.06)
    cage = target.sinew.active.cage
    cage.scale = MIRROR
    set_rest(target)
    assert bpy.ops.sinew.cage_faces(faces=40) == {"FINISHED"}
    assert target.sinew.active.status_level == "INFO", target.sinew.active.status
    assert np.abs(scenes.evaluated_points(target) - scenes.base_points(target)).max() < 4 * scenes.FLOAT32
    assert_goes_on(target, cage)
