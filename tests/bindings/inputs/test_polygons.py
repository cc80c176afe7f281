# SPDX-License-Identifier: GPL-3.0-or-later
"""Polygons with holes at the ends of slits, as Blender has them: a corner of theirs comes several times."""

import numpy as np
import pytest

import sinew_native as sn

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
HOLES = [[(0.6, 2.4), (0.6, 3.2), (1.4, 3.2), (1.4, 2.4)], [(2.4, 0.6), (2.4, 1.4), (3.2, 1.4), (3.2, 0.6)]]


@pytest.mark.parametrize("count", [1, 2])
def test_triangles_leave_the_holes_from_whatever_corner_the_polygon_begins(count: int) -> None:
    slits = [corner for hole in HOLES[:count] for corner in (*hole, hole[0], SQUARE[0])]
    corners = [(*corner, 0.0) for corner in (SQUARE[0], *slits, *SQUARE[1:])]
    places, polygon = np.unique(corners, axis=0, return_inverse=True)
    for start in range(len(corners)):
        mesh = sn.SurfaceMesh(places, [np.roll(polygon.ravel(), -start).tolist()])
        a, b, c = places[mesh.triangles.T]
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        assert area == pytest.approx(16 - count * 0.8**2, rel=1e-12), start
