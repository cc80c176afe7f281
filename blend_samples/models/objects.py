# SPDX-License-Identifier: GPL-3.0-or-later
"""From arrays to Blender mesh objects."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

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

    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    for group, indices in sculpture.regions.items():
        obj.vertex_groups.new(name=group).add([int(i) for i in indices], 1.0, "REPLACE")
    return obj


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
