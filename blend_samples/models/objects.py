# SPDX-License-Identifier: GPL-3.0-or-later
"""From arrays to Blender mesh objects."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import bmesh
import bpy
import numpy as np

from ..posing import add_object
from .sculpt import neighbour_mean


@dataclass
class Sculpture:
    """A mesh as arrays, with what its materials and handles need."""

    points: np.ndarray  # (n, 3)
    quads: np.ndarray  # (m, 4)
    colours: np.ndarray  # (n, 3) linear RGB
    materials: np.ndarray  # (m,) material slot of each face
    attributes: dict[str, np.ndarray] = field(default_factory=dict)  # (n,) floats, read by the materials
    regions: dict[str, np.ndarray] = field(default_factory=dict)  # vertex group name -> vertex indices


def to_object(name: str, sculpture: Sculpture) -> bpy.types.Object:
    """A smooth-shaded object in the scene's collection, with colours, attributes and vertex groups."""
    points, quads = sculpture.points, sculpture.quads
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.astype(np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(quads), 4, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), bool))
    mesh.polygons.foreach_set("material_index", sculpture.materials.astype(np.int32))
    mesh.update(calc_edges=True)
    mesh.validate()

    rgba = np.column_stack((sculpture.colours, np.ones(len(points)))).astype(np.float32)
    mesh.color_attributes.new("Colour", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
    for key, values in sculpture.attributes.items():
        mesh.attributes.new(key, "FLOAT", "POINT").data.foreach_set("value", values.astype(np.float32))
    keep_rest_positions(mesh)

    obj = add_object(name, mesh)
    add_groups(obj, sculpture.regions)
    return obj


def mesh_object(
    name: str,
    points: np.ndarray | Sequence,
    faces: np.ndarray | Sequence,
    parent: bpy.types.Object | None = None,
    smooth: bool = False,
    slots: Sequence[int] | None = None,
    materials: Iterable[bpy.types.Material] = (),
) -> bpy.types.Object:
    """An object in the scene's collection; ``slots`` are the material slots of the faces."""
    mesh = bpy.data.meshes.new(name)
    points, faces = (part.tolist() if isinstance(part, np.ndarray) else part for part in (points, faces))
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    if slots is not None:
        mesh.polygons.foreach_set("material_index", np.asarray(slots, np.int32))
    for material in materials:
        mesh.materials.append(material)
    return add_object(name, mesh, parent)


def keep_vertices(mesh: bpy.types.Mesh, kept: np.ndarray) -> None:
    """Delete the vertices that are not to stay, of bool (n,)."""
    edit = bmesh.new()
    edit.from_mesh(mesh)
    edit.verts.ensure_lookup_table()
    lost = [edit.verts[index] for index in np.flatnonzero(~kept)]
    bmesh.ops.delete(edit, geom=lost, context="VERTS")
    edit.to_mesh(mesh)
    edit.free()


def add_groups(obj: bpy.types.Object, regions: dict[str, np.ndarray]) -> None:
    """Vertex groups of full weight: their vertices, by name."""
    for group, indices in regions.items():
        obj.vertex_groups.new(name=group).add(np.asarray(indices).tolist(), 1.0, "REPLACE")


def grid_faces(rows: int, columns: int, around: bool = False) -> np.ndarray:
    """The quads (m, 4) of a grid of points, row after row; ``around`` joins the last column to the first."""
    number = np.arange(rows * columns).reshape(rows, columns)
    beside = np.roll(number, -1, axis=1)
    quads = np.stack((number[:-1], beside[:-1], beside[1:], number[1:]), axis=-1)
    return quads[:, : columns if around else columns - 1].reshape(-1, 4)


def disc(cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grid bent to a disc of radius 1: points (n, 2), quads (m, 4), and the vertices of its rim."""
    u, v = square(cells).T
    points = np.stack((u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)), 1)
    number = np.arange(len(points)).reshape(cells + 1, cells + 1)
    rim = np.concatenate((number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]))
    return points, grid_faces(cells + 1, cells + 1)[:, ::-1], rim


def square(cells: int) -> np.ndarray:
    """The points (n, 2) of the grid that ``disc`` bends, from -1 to 1."""
    line = np.linspace(-1, 1, cells + 1)
    return np.stack([side.ravel() for side in np.meshgrid(line, line, indexing="ij")], 1)


def keep_rest_positions(mesh: bpy.types.Mesh) -> None:
    """Store the rest positions as the attribute ``rest``, so that textures stick to the deformed surface."""
    rest = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", rest)
    mesh.attributes.new("rest", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest)


def soften(values: np.ndarray, quads: np.ndarray, rounds: int) -> np.ndarray:
    """Values at vertices (n, ...), averaged with their neighbours a few times."""
    for _ in range(rounds):
        values = 0.5 * (values + neighbour_mean(values, quads))
    return values


def eye_colours(gaze: np.ndarray, iris: tuple[float, float, float], pupil: float, edge: float) -> np.ndarray:
    """Colours (n, 3) for the viewport, by the angle from the line of sight; the material has them sharp."""
    white = np.tile((0.80, 0.77, 0.72), (len(gaze), 1))
    white[gaze < edge] = iris
    white[gaze < pupil] = 0.004
    return white


def stack_of_boxes(
    name: str, floors: Sequence[tuple[float, float]], parent: bpy.types.Object
) -> bpy.types.Object:
    """A cage of boxes, one on the other: of each floor half its width, and its height."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    points = [(x * half, y * half, z) for half, z in floors for x, y in corners]
    sides = grid_faces(len(floors), 4, around=True)
    faces = [(3, 2, 1, 0), tuple(range(len(points) - 4, len(points))), *sides.tolist()]
    return mesh_object(name, points, faces, parent)
