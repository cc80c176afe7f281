# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets and cages that the tests of cages share, and what mean value coordinates make of them."""

import bmesh
import bpy
import numpy as np
from expected import faces_of
from inside import native
from mathutils import Matrix

from rigs.rig import CORNERS, FLOAT32, SIDES, base_points, evaluated_points, new_object, press

SHEAR = Matrix(((1.0, 0.4, 0.0, 0.2), (0.0, 1.2, 0.1, 0.0), (0.0, 0.0, 0.8, -0.3), (0.0, 0.0, 0.0, 1.0)))
TURN = Matrix.Translation((0.3, 0.1, -0.2)) @ Matrix.Rotation(0.7, 4, (0.6, 0.0, 0.8)) @ Matrix.Scale(1.3, 4)


def ball(name: str = "Ball", levels: int = 3, radius: float = 0.6) -> bpy.types.Object:
    """A small sphere at the origin."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=levels, radius=radius)
    bpy.context.object.name = name
    return bpy.context.object


def box(name: str = "Cage", size: float = 2.0) -> bpy.types.Object:
    """A cube around it."""
    return new_object(name, 0.5 * size * np.array(CORNERS), SIDES)


def fine_box(cuts: int) -> bpy.types.Object:
    """The same cube of (cuts + 1)^2 squares a side."""
    obj, edit = box(), bmesh.new()
    edit.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(edit, edges=edit.edges[:], cuts=cuts, use_grid_fill=True)
    edit.to_mesh(obj.data)
    edit.free()
    return obj


def crease(obj: bpy.types.Object, edges: range, value: float) -> None:
    edit = bmesh.new()
    edit.from_mesh(obj.data)
    layers = edit.edges.layers
    if hasattr(layers, "crease"):  # up to 3.6
        layer = layers.crease.verify()
    else:
        layer = layers.float.get("crease_edge") or layers.float.new("crease_edge")
    edit.edges.ensure_lookup_table()
    for index in edges:
        edit.edges[index][layer] = value
    edit.to_mesh(obj.data)
    edit.free()


def surround(target: bpy.types.Object, cage: bpy.types.Object, method: str = "mean_value"):
    """The deformer; a refusal is in its status."""
    press(target, "cage_add", source="OBJECT", cage=cage.name, method=method)
    return target.sinew.active


def place(cage: bpy.types.Object, points: list) -> None:
    cage.data.vertices.foreach_set("co", np.array(points, dtype=np.float32).ravel())
    cage.data.update()


def transform(cage: bpy.types.Object, motion: Matrix) -> None:
    cage.data.transform(motion)
    cage.data.update()


def cross(cage: bpy.types.Object) -> None:
    """One corner goes through the opposite side."""
    cage.data.vertices[0].co = (1.5, 0.3, 0.2)


def mean_value(cage: bpy.types.Object, points: np.ndarray):
    """Coordinates of points, made anew, in the cage as its mesh is now."""
    mesh = native().SurfaceMesh(base_points(cage), faces_of(cage.data))
    coordinates = native().MeanValue(mesh, precision="double")
    coordinates.bind(points)
    return coordinates


def motion_of(target: bpy.types.Object) -> np.ndarray:
    """How far each vertex is from where it is at rest, (n, 3)."""
    return evaluated_points(target) - base_points(target)


def assert_rests(target: bpy.types.Object) -> None:
    """Nothing moves it, to the last bit."""
    assert np.array_equal(evaluated_points(target), base_points(target))


def assert_goes_on(target: bpy.types.Object, cage: bpy.types.Object) -> None:
    """The bind is well, and the cage moves the mesh."""
    deformer = target.sinew.active
    before = evaluated_points(target)
    assert deformer.status_level == "INFO", deformer.status
    cage.location.z += 0.25
    assert np.abs(evaluated_points(target) - before - (0.0, 0.0, 0.25)).max() < FLOAT32


def selected(target: bpy.types.Object, kind: str, line: int = -1) -> tuple[bpy.types.Object, set[int]]:
    """What Select shows: of which object, and the indices of its vertices or faces."""
    press(target, "select_problems", line=line)
    shown = bpy.context.object
    bpy.ops.object.mode_set(mode="OBJECT")
    elements = shown.data.polygons if kind == "face" else shown.data.vertices
    return shown, {element.index for element in elements if element.select}


def set_rest(target: bpy.types.Object) -> None:
    """The cage as it is now is its rest."""
    press(target, "cage_set_rest")
