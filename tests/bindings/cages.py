# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages that the tests of the Python module share."""

from collections.abc import Sequence

import numpy as np

import sinew_native as sn

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
OUTLINE = np.array([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], float)


def u_prism(caps: Sequence[Sequence[int]] = (range(8),)) -> sn.SurfaceMesh:
    """A prism of depth 1 over a U, with quads for sides; `caps` are the faces of the U at both ends."""
    points = np.concatenate([np.column_stack([OUTLINE, np.full(8, z)]) for z in (0.0, 1.0)])
    faces = [list(cap)[::-1] for cap in caps] + [[v + 8 for v in cap] for cap in caps]
    faces += [[i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i] for i in range(8)]
    return sn.SurfaceMesh(points, ([len(face) for face in faces], np.concatenate(faces)))


def bound(method: type, cage: sn.SurfaceMesh, points: np.ndarray, **options: object):
    """Coordinates of double precision."""
    coordinates = method(cage, precision="double", **options)
    coordinates.bind(points)
    return coordinates
