# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices: fitted, posed in every way that Blender has, refused where they cannot work."""

from __future__ import annotations

import itertools

import bpy
import numpy as np
import pytest
from inside import inner, notes_of
from mathutils import Euler, Matrix
from rigs import rig as scenes
from rigs.cages import SHEAR, ball, transform
from rigs.rig_of_lattice import bent, lattice_object, lattice_points, place, resolution, small_ball

BLENDER = {"KEY_LINEAR", "KEY_CARDINAL", "KEY_CATMULL_ROM", "KEY_BSPLINE"}
# Per axis, with those of one and two points, and those of fewer points than a cubic has.
COUNTS = ((4, 4, 4), (2, 2, 2), (1, 3, 2), (5, 1, 1), (3, 6, 4), (1, 1, 1))


def cloud() -> bpy.types.Object:
    """Points inside, on and far outside a lattice of size 1."""
    random = np.random.default_rng(3)
    corners = 0.5 * np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
    spread = random.uniform(-0.5, 0.5, (300, 3)) * random.choice((1.0, 1.5, 4.0, 20.0), (300, 1))
    return scenes.new_object("Cloud", np.concatenate((spread, corners)))


def add(obj: bpy.types.Object, *others: bpy.types.Object, **options: object) -> bpy.types.Object:
    """Fit a lattice to objects; the lattice."""
    scenes.make_active(obj, *others)
    assert bpy.ops.sinew.lattice_add(**options) == {"FINISHED"}
    deformer = obj.sinew.active
    assert deformer.status_level == "INFO", deformer.status
    return deformer.controls[0].object


def use(obj: bpy.types.Object, lattice: bpy.types.Object, **parameters: object) -> None:
    scenes.press(obj, "lattice_add", source="OBJECT", lattice=lattice.name)
    for name, value in parameters.items():
        setattr(obj.sinew.active.parameters, name, value)
    scenes.update()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


@pytest.mark.parametrize("counts", COUNTS, ids=str)
@pytest.mark.parametrize("kind", sorted(BLENDER))
def test_interpolation_as_in_blender_gives_the_numbers_of_blenders_modifier(counts: tuple, kind: str):
    obj, lattice = cloud(), lattice_object(counts)
    for axis in "uvw":
        setattr(lattice.data, f"interpolation_type_{axis}", kind)
    lattice.matrix_world = Matrix.LocRotScale((0.1, -0.2, 0.3), Euler((0.3, 0.5, -0.2)), (1.0, 1.4, 0.8))
    obj.matrix_world = Matrix.LocRotScale((0.3, 0.1, 0.0), Euler((0.1, 0.0, 0.4)), (1.2, 0.9, 1.0))
    scenes.update()
    twin = scenes.new_object("Twin", scenes.base_points(obj))
    twin.matrix_world = obj.matrix_world.copy()
    twin.modifiers.new("Lattice", "LATTICE").object = lattice
    use(obj, lattice, basis="blender")
    place(lattice, bent(lattice_points(lattice), by=0.8))
    shown, expected = scenes.evaluated_points(obj), scenes.evaluated_points(twin)
    assert len(lattice.data.points) == 1 or not scenes.close(expected, scenes.base_points(obj), 1e-3)
    assert scenes.close(shown, expected, 1e-5)  # of the box, whose sides are about 1


def test_mixed_interpolation_and_a_change_of_it_bind_by_themselves():
    obj, lattice = cloud(), lattice_object((4, 3, 5))
    twin = scenes.new_object("Twin", scenes.base_points(obj))
    twin.modifiers.new("Lattice", "LATTICE").object = lattice
    use(obj, lattice, basis="blender")
    place(lattice, bent(lattice_points(lattice)))
    for kinds in (
        ("KEY_LINEAR", "KEY_BSPLINE", "KEY_CARDINAL"),
        ("KEY_CATMULL_ROM", "KEY_LINEAR", "KEY_LINEAR"),
    ):
        for axis, kind in zip("uvw", kinds):
            setattr(lattice.data, f"interpolation_type_{axis}", kind)
        obj.update_tag()
        assert scenes.close(scenes.evaluated_points(obj), scenes.evaluated_points(twin), 1e-5), kinds


@pytest.mark.parametrize("counts", [(2, 3, 4), (7, 1, 2), (4, 4, 4)], ids=str)
def test_a_fitted_lattice_has_its_resolution_and_holds_the_object(counts: tuple):
    obj = ball()
    obj.matrix_world = Matrix.LocRotScale((3.0, 1.0, -2.0), Euler((0.4, 0.2, 1.0)), (1.0, 2.0, 0.5))
    scenes.update()
    lattice = add(obj, resolution=counts, margin=0.1)
    assert lattice.type == "LATTICE"
    assert resolution(lattice) == counts
    world = np.array([lattice.matrix_world.inverted() @ obj.matrix_world @ v.co for v in obj.data.vertices])
    shares = np.abs(world).max(axis=0) / np.maximum(np.array(counts) - 1, 1)  # of the box
    assert (shares < 0.5).all()
    assert (shares > 0.25).all()  # the margin is a share of the longest side
    assert scenes.close(scenes.evaluated_points(obj), scenes.base_points(obj))
    assert lattice.parent == obj
    assert bpy.context.object == lattice
    at = lattice_points(lattice)
    place(lattice, at + (0.0, 0.0, 0.5))  # all: a translation, which B-splines reproduce
    shift = obj.matrix_world.inverted().to_3x3() @ lattice.matrix_world.to_3x3().col[2] * 0.5
    assert scenes.close(
        scenes.evaluated_points(obj), scenes.base_points(obj) + np.array(shift), scenes.MATRIX
    )


def test_a_flat_object_gets_a_lattice_with_room():
    obj = scenes.grid_object()
    lattice = add(obj)
    assert min(lattice.scale) > 0.05
    points = lattice_points(lattice)
    place(lattice, points + np.outer(points[:, 2] > 0.0, (0.0, 0.0, 0.4)))
    assert np.ptp(scenes.evaluated_points(obj)[:, 2]) < 1e-5 < scenes.evaluated_points(obj)[:, 2].max()


def test_principal_axes_fit_a_leaning_shape_more_closely():
    obj = ball()
    obj.data.transform(Euler((0.0, 0.7, 0.4)).to_matrix().to_4x4() @ Matrix.Diagonal((3.0, 0.4, 0.6, 1.0)))
    volumes = {}
    for kind in ("OBJECT", "PRINCIPAL", "WORLD"):
        lattice = add(obj, orientation=kind)
        volumes[kind] = abs(lattice.matrix_world.determinant())
        assert bpy.ops.sinew.deformer_remove.poll()
        scenes.press(obj, "deformer_remove")
    assert volumes["PRINCIPAL"] < 0.5 * volumes["OBJECT"]
    assert volumes["OBJECT"] == pytest.approx(volumes["WORLD"], rel=1e-4)


def test_a_folded_lattice_names_its_points_and_select_shows_them():
    obj = small_ball(levels=2)
    lattice = lattice_object((3, 3, 3))
    points = lattice_points(lattice)
    points[13] = (1.5, 0.0, 0.0)
    place(lattice, points)
    scenes.press(obj, "lattice_add", source="OBJECT", lattice=lattice.name)
    deformer = obj.sinew.active
    assert deformer.status_level == "ERROR"
    assert "folded" in deformer.status
    line = inner.status.current(deformer.uid)
    assert (line.remedy.name, 13 in line.elements.indices) == ("LATTICE_REST", True)
    scenes.press(obj, "select_problems")
    assert (bpy.context.object, lattice.mode) == (lattice, "EDIT")
    assert lattice.data.points[13].select
    assert not lattice.data.points[0].select
    bpy.ops.object.mode_set(mode="OBJECT")
    place(lattice, lattice_points(lattice_object((3, 3, 3), "Straight")))
    scenes.press(obj, "lattice_set_rest")
    assert deformer.status_level == "INFO", deformer.status


@pytest.mark.parametrize("shape", ["CYLINDER", "FITTED"])
def test_meshes_of_hexahedra_hold_the_object_and_carry_affine_maps(shape: str):
    obj = ball(levels=3)
    lattice = add(obj, shape=shape, resolution=(4, 2, 3))
    assert lattice.type == "MESH"
    assert lattice.display_type == "WIRE"
    assert "outside" not in " ".join(notes_of(obj.sinew.active)), "all points lie inside"
    assert scenes.close(scenes.evaluated_points(obj), scenes.base_points(obj), 1e-5)
    world = obj.matrix_world.inverted() @ lattice.matrix_world
    transform(lattice, world.inverted() @ SHEAR @ world)
    expected = scenes.apply_matrix(SHEAR, scenes.base_points(obj))
    assert scenes.close(scenes.evaluated_points(obj), expected, 1e-4)


def test_fitted_boxes_are_only_where_the_object_is_and_inside_it():
    left, right = ball("Left", 2), ball("Right", 2)
    right.location.x = 6.0
    scenes.update()
    lattice = add(left, right, shape="FITTED", resolution=(12, 3, 3), margin=0.01)
    middles = np.array([polygon.center for polygon in lattice.data.polygons])
    world = np.array([lattice.matrix_world @ vertex.co for vertex in lattice.data.vertices])
    assert len(middles)
    assert not ((world[:, 0] > 1.5) & (world[:, 0] < 4.5)).any(), "nothing between the two balls"


def test_a_mesh_without_hexahedra_is_refused():
    obj = small_ball(levels=2)
    plane = scenes.grid_object("Plane", 2)
    scenes.press(obj, "lattice_add", source="OBJECT", lattice=plane.name)
    assert obj.sinew.active.status_level == "ERROR"
    assert "hexahedra" in obj.sinew.active.status
