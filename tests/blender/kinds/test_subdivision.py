# SPDX-License-Identifier: GPL-3.0-or-later
"""SubdivisionSurface next to Blender's own Subdivision modifier, which orders the vertices in another way."""

from __future__ import annotations

from itertools import product

import bmesh
import bpy
import numpy as np
import pytest
from expected import faces_of
from inside import native
from rigs.rig import base_points, evaluated_points, nearest, new_object

TOLERANCE = 1e-6  # of the bounding box: Blender computes in single precision


def prism() -> bpy.types.Object:
    """Two hexagons and six quads, closed, of no symmetry."""
    angles = np.arange(6) * np.pi / 3
    ring = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(6)))
    sides = [(k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6) for k in range(6)]
    points = np.vstack((ring, 0.7 * ring + (0.1, 0.2, 1.3)))
    return new_object("Prism", points.tolist(), [tuple(range(5, -1, -1)), tuple(range(6, 12)), *sides])


def sheet() -> bpy.types.Object:
    """An open sheet of 5 x 4 quads with a triangle, a pentagon, a hole and a part of one face."""
    points = np.array([(x, y, 0.0) for y in range(5) for x in range(6)])
    points += np.random.default_rng(3).uniform(-0.2, 0.2, points.shape)
    faces = [(a, a + 1, a + 7, a + 6) for y in range(4) for a in range(6 * y, 6 * y + 5)]
    gone = {(8, 9, 15, 14), (13, 14, 20, 19), (14, 15, 21, 20)}
    faces = [face for face in faces if face not in gone] + [(13, 14, 15, 20, 19), (15, 21, 20)]
    part = [(9, 0, 0), (10, 0, 0.5), (10, 1, 0), (9, 1, 0.3)]
    return new_object("Sheet", [*points.tolist(), *part], [*faces, (30, 31, 32, 33)])


def fin() -> bpy.types.Object:
    """Three quads at one edge."""
    points = [(0, 0, 0), (0, 1, 0), (1, 0, 0.1), (1, 1, 0), (-1, 0, 0), (-1, 1, 0.2), (0, 0, 1), (0, 1, 1.2)]
    return new_object("Fin", points, [(0, 2, 3, 1), (0, 1, 5, 4), (0, 1, 7, 6)])


CREASES = {(0, 1): 1.0, (4, 5): 0.5, (5, 11): 0.3, (1, 2): 0.4, (2, 3): 0.2, (3, 9): 0.55}
CORNERS = {0: 1.0, 7: 0.5, 10: 0.3}


def crease(obj: bpy.types.Object) -> dict[str, tuple[list, list]]:
    """Creases and corners, as far as it has such elements; what these are here."""
    edges = {tuple(sorted(edge.vertices)) for edge in obj.data.edges}
    creases = {edge: value for edge, value in CREASES.items() if edge in edges}
    corners = {vertex: value for vertex, value in CORNERS.items() if vertex < len(obj.data.vertices)}
    edit = bmesh.new()
    edit.from_mesh(obj.data)
    rows = ((edit.edges, creases, "crease_edge"), (edit.verts, corners, "crease_vert"))
    for elements, values, name in rows:
        before = getattr(elements.layers, "crease", None)  # up to 3.6
        layer = before.verify() if before is not None else elements.layers.float.new(name)
        for element in elements:
            ends = tuple(sorted(vertex.index for vertex in getattr(element, "verts", ())))
            element[layer] = values.get(ends or element.index, 0.0)
    edit.to_mesh(obj.data)
    edit.free()
    return {
        name: (list(values), [10.0 * value**2 for value in values.values()])
        for name, values in (("creases", creases), ("corners", corners))
    }


def subdivide(obj: bpy.types.Object, **settings: object) -> None:
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    for name, value in {"show_only_control_edges": False, "use_limit_surface": False, **settings}.items():
        setattr(modifier, name, value)


def ours(obj: bpy.types.Object, **options: object) -> object:
    mesh = native().SurfaceMesh(base_points(obj), faces_of(obj.data))
    return native().SubdivisionSurface(mesh, **options)


def ways_apart(own: np.ndarray, blenders: np.ndarray) -> np.ndarray:
    """Each of Blender's vertices has one of ours to itself; their distances, ascending, in bounding boxes."""
    numbers, distances = nearest(blenders, own)
    assert len(set(numbers)) == len(own) == len(blenders)
    return np.sort(distances) / np.linalg.norm(np.ptp(own, axis=0))


# What Blender is asked for, and what is the same here. Ours is exact (tests/bindings/surfaces). Blender's
# limit stops ten levels in: the end of the endless crease is still 0.46^10 of an edge away from it, 6.4e-6.
LIMIT = {"use_limit_surface": True, "quality": 10}
WAYS = {
    **{
        f"{boundary}, {'limit' if limit else 'refined'}": (
            LIMIT | {"use_limit_surface": limit, "boundary_smooth": boundary.upper()},
            {"limit": limit, "boundary_smooth": boundary},
        )
        for boundary, limit in product(("all", "preserve_corners"), (False, True))
    },
    "creases": ({"use_creases": True}, {}),
    "creases ignored": ({"use_creases": False}, {}),
    "limit of creases": ({"use_creases": True, **LIMIT}, {"limit": True}),
    "bilinear": ({"subdivision_type": "SIMPLE"}, {"scheme": "bilinear"}),
}


@pytest.mark.parametrize("level", [1, 2, 3])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("shape", [prism, sheet, fin])
def test_shapes_are_those_of_blender(shape, way: str, level: int) -> None:
    obj, (blenders, options) = shape(), WAYS[way]
    made = crease(obj) if "crease" in way else {}
    options = {**options, **(made if blenders.get("use_creases") else {}), "level": level}
    own = ours(obj, **options).refine(base_points(obj))
    subdivide(obj, levels=level, **blenders)
    *distances, farthest = ways_apart(own, evaluated_points(obj))
    assert max(distances) < TOLERANCE
    assert farthest < TOLERANCE * (10.0 if way == "limit of creases" and shape is prism else 1.0)


UV_CHOICES = (
    "none",
    "preserve_corners",
    "preserve_corners_and_junctions",
    "preserve_corners_junctions_and_concave",
    "preserve_boundaries",
    "smooth_all",
)


@pytest.mark.parametrize("uv_smooth", UV_CHOICES)
def test_face_varying_values_are_the_uvs_of_blender(uv_smooth: str) -> None:
    """Two islands: the faces left and right of a seam through the sheet."""
    obj = sheet()
    points, (counts, corners) = base_points(obj), faces_of(obj.data)
    island = [points[list(face.vertices), 0].mean() > 2.5 for face in obj.data.polygons]
    uvs = points[corners, :2] + np.outer(np.repeat(island, counts), (3.0, 0.0))
    obj.data.uv_layers.new(name="UV").data.foreach_set("uv", uvs.astype(np.float32).ravel())
    values, indices = np.unique(uvs, axis=0, return_inverse=True)
    surface = ours(obj, level=2, uv_smooth=uv_smooth, face_varying=indices.ravel())
    fine = surface.refine(points)[surface.faces.ravel()]
    own = np.column_stack((fine, surface.refine_face_varying(values)[surface.face_varying_corners]))
    subdivide(obj, levels=2, uv_smooth=uv_smooth.upper())
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    corners = zip(mesh.loops, mesh.uv_layers[0].data, strict=True)
    blenders = np.array([(*mesh.vertices[loop.vertex_index].co, *uv.uv) for loop, uv in corners])
    assert len(own) == len(blenders)
    apart = [np.abs(own - corner).max(axis=1).min() for corner in blenders]
    assert max(apart) < TOLERANCE * 10.0  # the width of the sheet
