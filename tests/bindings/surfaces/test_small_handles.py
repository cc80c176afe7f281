# SPDX-License-Identifier: GPL-3.0-or-later
"""Small handles do not crumple the surface, and those that hold almost fully move it as if they did."""

from collections.abc import Callable

import numpy as np
import pytest

import sinew_native as sn

from ..figures import animal, spot
from ..meshes import STILL, ends, off, sphere, turn
from ..methods import SURFACE_METHODS, bound_to, made


def feet(points: np.ndarray) -> list[np.ndarray]:
    """Hind and front, each left and right: what is near the ground."""
    x, y, z = points.T
    low, middle = z < z.min() + 0.04 * np.ptp(z), (x.min() + x.max()) / 2
    return [
        np.flatnonzero(low & (front == (x > middle)) & (left == (y > 0)))
        for front in (0, 1)
        for left in (0, 1)
    ]


def folds(points: np.ndarray, faces: np.ndarray) -> int:
    """Faces that look to the other side than the faces around them do together."""
    a, b, c = np.moveaxis(points[faces], 1, 0)
    areas = np.cross(b - a, c - a)
    around = np.zeros_like(points)
    for corner in faces.T:
        np.add.at(around, corner, areas)
    return int((np.einsum("ij,ikj->i", areas, around[faces]) < 0).sum())


@pytest.mark.parametrize("figure", [spot, animal])
def test_nothing_folds_beside_feet(figure: Callable) -> None:
    points, faces = figure()
    size = np.linalg.norm(np.ptp(points, axis=0))
    handles = feet(points)
    middles = [points[foot].mean(axis=0) for foot in handles]
    swing = [
        turn((0, 1, 0), 15 * way, middle, (0.08 * way * size, 0, 0.03 * size))
        for way, middle in zip((1, -1, -1, 1), middles)
    ]
    lift = [STILL, STILL, STILL, turn((0, 1, 0), 0, middles[3], (0.1 * size, 0, 0.08 * size))]
    found = {}
    for cage_faces in (160, 0):
        method = bound_to(sn.SubspaceLaplacian(sn.SurfaceMesh(points, faces), cage_faces=cage_faces), handles)
        found[cage_faces] = [folds(method.solve(np.stack(poses))[0], faces) for poses in (swing, lift)]
    assert folds(points, faces) == 0
    assert sum(found[160]) > 5
    assert found[0] == [0, 0]


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_weights_near_one_are_nearly_one(method: type) -> None:
    points, faces = sphere(4)
    points = points * (3, 1, 1)
    surface = made(method, sn.SurfaceMesh(points, faces))
    shapes = []
    for weight in (1.0, 0.999, 1.0 - 1e-5, 1.0 - 1e-9):
        surface.set_handles(ends(points, 0.8), [1.0, weight])
        shapes.append(surface.solve([STILL, turn((0, 0, 1), 60, move=(-0.5, 0.8, 0.0))])[0])
    assert max(off(shape, shapes[0]) for shape in shapes[1:]) < 0.003 * 6.0
