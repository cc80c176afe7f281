# SPDX-License-Identifier: GPL-3.0-or-later
"""Polygons that Blender triangulates rightly are triangulated rightly, from whatever corner they begin."""

import bpy
import numpy as np
import pytest
from inside import native

OUTER = [(0, 0), (4, 0), (4, 4), (0, 4)]
HOLE = [(1, 1), (1, 3), (3, 3), (3, 1)]  # the other way round
COMB = [(0, 0), (9, 0), *[(9 - k, 5 if k % 2 else 1) for k in range(10)]]
TURNS = np.linspace(0.0, 5.0 * np.pi, 40)
SPIRAL = [
    (r * np.cos(t), r * np.sin(t)) for t, r in [*zip(TURNS, 2 + TURNS), *zip(TURNS[::-1], 1 + TURNS[::-1])]
]


def with_slit(outer: list, *holes: list) -> list:
    """One polygon: from a corner along a slit to a hole, around it, and back."""
    found = [outer[0]]
    for hole in holes:
        found += [*hole, hole[0], outer[0]]
    return found + outer[1:]


def moved(hole: list, scale: float, x: float, y: float) -> list:
    return [(scale * a + x, scale * b + y) for a, b in hole]


POLYGONS = {
    "a comb": COMB,
    "a spiral": SPIRAL,
    "a frame": with_slit(OUTER, HOLE),
    "two holes": with_slit(OUTER, moved(HOLE, 0.4, 0.2, 2.0), moved(HOLE, 0.4, 2.0, 0.2)),
}


def area(points: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize("corners", POLYGONS.values(), ids=POLYGONS)
@pytest.mark.parametrize("turned", [False, True])
def test_triangles_cover_what_blenders_cover(scene, corners: list, turned: bool):
    flat = np.array([(x, y, 0.0) for x, y in corners])
    x, y = flat[:, 0], flat[:, 1]
    inside = abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2
    places = flat @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0] if turned else flat
    unique, index = np.unique(places.round(9), axis=0, return_inverse=True)
    right = 0  # in Blender
    for start in range(len(corners)):
        polygon = np.roll(index.ravel(), -start).tolist()
        mesh = bpy.data.meshes.new("Polygon")
        mesh.from_pydata(unique.tolist(), [], [polygon])
        mesh.calc_loop_triangles()
        blenders = np.array([triangle.vertices for triangle in mesh.loop_triangles])
        bpy.data.meshes.remove(mesh)
        if area(unique, blenders) == pytest.approx(inside, rel=1e-6):
            right += 1
            ours = native().SurfaceMesh(unique, (np.array([len(polygon)]), np.array(polygon))).triangles
            assert area(unique, ours) == pytest.approx(inside, rel=1e-9), start
    assert right > len(corners) / 2
